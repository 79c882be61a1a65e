//! The snapshots that the reduced model is built from: equilibria under pressure on one side, on both sides, and under lateral forces like
//! those of the tail's own inertia and of water, along and against the bending by pressure.

use diagnostics::{Diagnostic, Result};
use fem::StaticSettings;
use rayon::prelude::*;
use si::{Metre, Pascal};

use super::centre_line::{CentreLine, Station};
use super::pressure_sweep::TOLERANCE;
use super::{Body, PressureSweep};

/// Pressures (left, right) at which lateral forces act, relative to the highest.
const UNDER_FORCE: [[f64; 2]; 6] = [[0.0, 0.0], [0.35, 0.0], [0.0, 0.35], [0.7, 0.0], [0.0, 0.7], [0.4, 0.4]];
/// Pressures of both sides without a lateral force.
const BOTH_SIDES: [[f64; 2]; 4] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6], [0.55, 0.55]];
/// Displacement of the tip by a lateral force in the linear model at rest, m: along the bending of the pressure, against it, and by the
/// force that changes its sign along the tail.
const TIP_DISPLACEMENTS: [Metre; 3] = [0.010, 0.024, 0.005];

/// Number of equilibria that [`shapes`] solves.
pub(crate) const COUNT: usize = 4 * UNDER_FORCE.len() + BOTH_SIDES.len();

/// Displacements (3 a node, m). `tick` is called after each equilibrium.
///
/// # Errors
/// When an equilibrium is not found.
pub fn shapes(
    body: &Body,
    line: &CentreLine,
    sweeps: &[PressureSweep; 2],
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<f64>>> {
    let top = sweeps[0].pressures.last().copied().unwrap_or(0.0);
    let forces = lateral_forces(body, line)?;
    let one = |fractions: &[f64; 2]| -> Result<Vec<Vec<f64>>> {
        let mut loaded = LoadedBody::at(body, sweeps, fractions.map(|s| s * top))?;
        let cases = load_cases(*fractions);
        let found = cases.iter().map(|(k, tip)| loaded.under(&forces[*k], *tip).inspect(|_| tick())).collect();
        match cases.is_empty() {
            true => Ok(vec![loaded.rest]).inspect(|_| tick()),
            false => found,
        }
    };
    let each: Result<Vec<_>> = UNDER_FORCE.par_iter().chain(&BOTH_SIDES).map(one).collect();
    Ok(each?.into_iter().flatten().collect())
}

/// Index and tip displacement (m) of the lateral forces at `fractions` of the highest pressure; none for [`BOTH_SIDES`].
fn load_cases(fractions: [f64; 2]) -> Vec<(usize, Metre)> {
    if !UNDER_FORCE.contains(&fractions) {
        return Vec::new();
    }
    let [with, against, mixed] = TIP_DISPLACEMENTS;
    let along = (fractions[1] - fractions[0]).signum();
    let tip = |sign: f64| sign * if fractions[0] == fractions[1] || sign == along { with } else { against };
    [1.0, -1.0].into_iter().flat_map(|sign| [(0, tip(sign)), (1, sign * mixed)]).collect()
}

/// Nodal forces (3 a node, N per metre of tip displacement): one to one side, one that changes its sign along the tail.
fn lateral_forces(body: &Body, line: &CentreLine) -> Result<[Vec<f64>; 2]> {
    let end = line.stations.last().map_or(1.0, |s| s.x);
    let one_sign = |s: &Station| (s.x / end).powi(2);
    let two_signs = |s: &Station| (s.x / end) * (0.7 - s.x / end);
    let mut solver = body.system.solver();
    let settings = StaticSettings::default();
    let at_rest = |e| Diagnostic::from(e).while_doing("the body at rest");
    let rest = solver.equilibrium(&body.pressures(0.0, 0.0), None, &settings).map_err(at_rest)?;
    solver.assemble(&rest).map_err(at_rest)?;
    solver.factorise(&rest).map_err(at_rest)?;
    let mut scaled = |each: &dyn Fn(&Station) -> f64| -> Result<Vec<f64>> {
        let forces = line.lateral(body.mesh.nodes.len(), each);
        let moved = line.displacements(&solver.solve(&forces).map_err(at_rest)?);
        let most = moved.iter().skip(1).step_by(2).fold(0.0, |most: f64, y| most.max(y.abs()));
        Ok(forces.into_iter().map(|f| f / most).collect())
    };
    Ok([scaled(&one_sign)?, scaled(&two_signs)?])
}

/// A body under pressures of both sides, ready for lateral forces.
struct LoadedBody {
    solver: fem::Solver,
    pressures: [Pascal; 2],
    chambers: Vec<Pascal>,
    /// Without a lateral force, m.
    rest: Vec<f64>,
}

impl LoadedBody {
    fn at(body: &Body, sweeps: &[PressureSweep; 2], pressures: [Pascal; 2]) -> Result<Self> {
        let [left, right] = pressures;
        // the displacements of both sides nearly cancel: their sum is a better initial guess than either alone
        let guess: Vec<f64> =
            sweeps[0].nearest(left).iter().zip(sweeps[1].nearest(right)).map(|(l, r)| l + r).collect();
        let (solver, chambers) = (body.system.solver(), body.pressures(left, right));
        let mut loaded = Self { solver, pressures, chambers, rest: guess.clone() };
        loaded.rest = loaded.solve(&vec![0.0; guess.len()], 0.0, &guess)?;
        Ok(loaded)
    }

    /// The shape under `force` scaled by `tip` (m); if it is not found at once, by way of half the force.
    fn under(&mut self, force: &[f64], tip: Metre) -> Result<Vec<f64>> {
        let rest = self.rest.clone();
        self.solve(force, tip, &rest).or_else(|_| {
            let half = self.solve(force, 0.5 * tip, &rest)?;
            self.solve(force, tip, &half)
        })
    }

    fn solve(&mut self, force: &[f64], tip: Metre, guess: &[f64]) -> Result<Vec<f64>> {
        let [left, right] = self.pressures.map(|p| p / 100.0);
        let doing = || format!("shape at {left:.0} and {right:.0} mbar, tip moved by {:.1} mm", tip * 1e3);
        let settings = StaticSettings { load_steps: 1, tolerance: TOLERANCE, ..StaticSettings::default() };
        let forces: Vec<f64> = force.iter().map(|f| tip * f).collect();
        self.solver.set_forces(&forces).map_err(|e| Diagnostic::from(e).while_doing(doing()))?;
        let found = self.solver.equilibrium(&self.chambers, Some(guess), &settings);
        Ok(found.map_err(|e| Diagnostic::from(e).while_doing(doing()))?.displacement)
    }
}
