//! The shapes that a tail is reduced from: up both ladders of pressure, both sides filled at once, and bent by sideways pulls
//! like those of its own inertia and of water, with and against the pressure.
//!
//! Stands on: `fem` (equilibria), the centre line, the ladders. Never knows: a trial.

use fem::StaticSettings;
use rayon::prelude::*;
use si::{Metre, Pascal};

use super::line::{CentreLine, Station};
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
    let one = |(share, pull, far): &([f64; 2], usize, Metre)| {
        let found = equilibrium(body, ladders, share.map(|s| s * top), &pulls[*pull], *far);
        tick();
        found
    };
    asked().par_iter().map(one).collect()
}

/// Shares of the highest pressure on both sides, which pull, and how far.
fn asked() -> Vec<([f64; 2], usize, Metre)> {
    let along = |share: [f64; 2]| (share[1] - share[0]).signum();
    let far = |share: [f64; 2], sign: f64| {
        let with = share[0] == share[1] || sign == along(share);
        sign * if with { PULLS[0] } else { PULLS[1] }
    };
    let both_ways = |share: [f64; 2]| [1.0, -1.0].map(|s| [(share, 0, far(share, s)), (share, 1, s * PULLS[2])]);
    let pulled = PULLED.into_iter().flat_map(both_ways).flatten();
    pulled.chain(BOTH.into_iter().map(|share| (share, 0, 0.0))).collect()
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

/// The shape under `pressures` (left, right; Pa) and `far` × `pull`, reached by way of half the pull.
fn equilibrium(
    body: &Body,
    ladders: &[Ladder; 2],
    pressures: [Pascal; 2],
    pull: &[f64],
    far: Metre,
) -> Result<Vec<f64>, Fault> {
    let mut solver = body.system.solver();
    let settings = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let [left, right] = pressures;
    let side = usize::from(right > left);
    let mut shape = ladders[side].nearest(pressures[side]).to_vec();
    let parts: &[f64] = if far == 0.0 { &[0.0] } else { &[0.0, 0.5, 1.0] };
    for part in parts {
        let forces: Vec<f64> = pull.iter().map(|f| part * far * f).collect();
        let place = || {
            format!("shape under {:.0} and {:.0} mbar, pulled {:.1} mm", left / 100.0, right / 100.0, part * far * 1e3)
        };
        solver.set_forces(&forces).map_err(|e| Fault::at(place(), e))?;
        let found = solver.equilibrium(&body.pressures(left, right), Some(&shape), &settings);
        shape = found.map_err(|e| Fault::at(place(), e))?.displacement;
    }
    Ok(shape)
}
