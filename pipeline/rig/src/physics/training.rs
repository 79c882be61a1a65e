//! The shapes that a tail is reduced from: up both ladders of pressure, both sides filled at once, and bent by sideways pulls
//! like those of its own inertia and of water, with and against the pressure.
//!
//! Stands on: `fem` (equilibria), the centre line, the ladders. Never knows: a trial.

use fem::StaticSettings;
use rayon::prelude::*;
use si::{Metre, Pascal};

use super::line::{CentreLine, Station};
use super::statics::SETTLED;
use super::{Body, Ladder};
use crate::fault::Fault;

/// Pressures (left, right) under which the tail is pulled, as shares of the highest.
const PULLED: [[f64; 2]; 6] = [[0.0, 0.0], [0.35, 0.0], [0.0, 0.35], [0.7, 0.0], [0.0, 0.7], [0.4, 0.4]];
/// Pressures of both sides without a pull.
const BOTH: [[f64; 2]; 4] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6], [0.55, 0.55]];
/// A pull along the bend of the pressure moves the tip of a tail at rest so far, one against it so far, one in two
/// directions at once so far; m.
const PULLS: [Metre; 3] = [0.010, 0.024, 0.005];

/// How many equilibria [`shapes`] asks for.
pub const COUNT: usize = 4 * PULLED.len() + BOTH.len();

/// Displacements (3 a node, m). `tick` is called after each equilibrium.
///
/// # Errors
/// [`Fault`] when no equilibrium is found.
pub fn shapes(
    body: &Body,
    line: &CentreLine,
    ladders: &[Ladder; 2],
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<f64>>, Fault> {
    let top = ladders[0].pressures.last().copied().unwrap_or(0.0);
    let pulls = pulls(body, line)?;
    let one = |share: &[f64; 2]| -> Result<Vec<Vec<f64>>, Fault> {
        let mut pulled = Pulled::under(body, ladders, share.map(|s| s * top))?;
        let asked = asked(*share);
        let found = asked.iter().map(|(pull, far)| pulled.by(&pulls[*pull], *far).inspect(|_| tick())).collect();
        match asked.is_empty() {
            true => Ok(vec![pulled.rest]).inspect(|_| tick()),
            false => found,
        }
    };
    let each: Result<Vec<_>, Fault> = PULLED.par_iter().chain(&BOTH).map(one).collect();
    Ok(each?.into_iter().flatten().collect())
}

/// Which pulls, and how far (m), under shares of the highest pressure: with and against the bend, and to both sides; none in [`BOTH`].
fn asked(share: [f64; 2]) -> Vec<(usize, Metre)> {
    if !PULLED.contains(&share) {
        return Vec::new();
    }
    let along = (share[1] - share[0]).signum();
    let far = |sign: f64| sign * if share[0] == share[1] || sign == along { PULLS[0] } else { PULLS[1] };
    [1.0, -1.0].into_iter().flat_map(|sign| [(0, far(sign)), (1, sign * PULLS[2])]).collect()
}

/// Nodal forces (3 a node, N a metre of the tip) of a pull to one side, and of one to both.
fn pulls(body: &Body, line: &CentreLine) -> Result<[Vec<f64>; 2], Fault> {
    let end = line.stations.last().map_or(1.0, |s| s.x);
    let one = |s: &Station| (s.x / end).powi(2);
    let both = |s: &Station| (s.x / end) * (0.7 - s.x / end);
    let mut solver = body.system.solver();
    let settings = StaticSettings::default();
    let said = |e| Fault::at("the body at rest", e);
    let rest = solver.equilibrium(&body.pressures(0.0, 0.0), None, &settings).map_err(said)?;
    solver.assemble(&rest).map_err(said)?;
    solver.factorise(&rest).map_err(said)?;
    let mut scaled = |each: &dyn Fn(&Station) -> f64| {
        let forces = line.sideways(body.mesh.nodes.len(), each);
        let moved = line.moved(&solver.solve(&forces).map_err(said)?);
        let most = moved.iter().skip(1).step_by(2).fold(0.0, |most: f64, y| most.max(y.abs()));
        Ok(forces.into_iter().map(|f| f / most).collect())
    };
    Ok([scaled(&one)?, scaled(&both)?])
}

/// A body under the pressures of both sides, to be pulled.
struct Pulled {
    solver: fem::Solver,
    pressures: [Pascal; 2],
    given: Vec<Pascal>,
    /// Without a pull, m.
    rest: Vec<f64>,
}

impl Pulled {
    fn under(body: &Body, ladders: &[Ladder; 2], pressures: [Pascal; 2]) -> Result<Self, Fault> {
        let [left, right] = pressures;
        // the bends of both sides add up to a small one: nearer than either alone
        let near: Vec<f64> =
            ladders[0].nearest(left).iter().zip(ladders[1].nearest(right)).map(|(l, r)| l + r).collect();
        let (solver, given) = (body.system.solver(), body.pressures(left, right));
        let mut pulled = Self { solver, pressures, given, rest: near.clone() };
        pulled.rest = pulled.step(&vec![0.0; near.len()], 0.0, &near)?;
        Ok(pulled)
    }

    /// The shape under `far` × `pull`; by way of half the pull where it is not found at once.
    fn by(&mut self, pull: &[f64], far: Metre) -> Result<Vec<f64>, Fault> {
        let rest = self.rest.clone();
        self.step(pull, far, &rest).or_else(|_| {
            let half = self.step(pull, 0.5 * far, &rest)?;
            self.step(pull, far, &half)
        })
    }

    fn step(&mut self, pull: &[f64], far: Metre, start: &[f64]) -> Result<Vec<f64>, Fault> {
        let [left, right] = self.pressures;
        let place =
            || format!("shape under {:.0} and {:.0} mbar, pulled {:.1} mm", left / 100.0, right / 100.0, far * 1e3);
        let settings = StaticSettings { load_steps: 1, tolerance: SETTLED, ..StaticSettings::default() };
        let forces: Vec<f64> = pull.iter().map(|f| far * f).collect();
        self.solver.set_forces(&forces).map_err(|e| Fault::at(place(), e))?;
        let found = self.solver.equilibrium(&self.given, Some(start), &settings);
        Ok(found.map_err(|e| Fault::at(place(), e))?.displacement)
    }
}
