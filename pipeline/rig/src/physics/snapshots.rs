//! The snapshots that the reduced model is built from: equilibria under pressure on one side and on both, equilibria under lateral forces like
//! those of the tail's own inertia and of water, along and against the bending by pressure, and the directions in which such forces move the
//! body at the equilibria without them.
//!
//! A direction is one solve with the tangent of the equilibrium. Forces act up to two fifths of the highest pressure alone: beyond, a force
//! against the bending leads a thin tail back and forth through its buckle, which took more time than all other equilibria together.
//! With directions alone and no force the motion of a thick tail was off by twice as much.

use diagnostics::{Diagnostic, Result};
use fem::{Equilibrium, LoadRamp, Snapshot, SolveError, StaticSettings};
use rayon::prelude::*;
use si::{Metre, Pascal};

use super::centre_line::{CentreLine, Station};
use super::pressure_sweep::TOLERANCE;
use super::{Body, PressureSweep};
use crate::side::Side;

/// Pressures of both sides, relative to the highest.
const BOTH_SIDES: [[f64; 2]; 4] = [[0.3, 0.3], [0.6, 0.3], [0.3, 0.6], [0.55, 0.55]];
/// The same where lateral forces act.
const UNDER_FORCE: [[f64; 2]; 4] = [[0.0, 0.0], [0.35, 0.0], [0.0, 0.35], [0.4, 0.4]];
/// Displacement of the tip by a lateral force in the linear model at rest, m: along the bending of the pressure, against it, and by the
/// force that changes its sign along the tail.
const TIP_DISPLACEMENTS: [Metre; 3] = [0.010, 0.024, 0.005];

/// Number of equilibria that [`training_shapes`] solves.
pub(crate) const COUNT: usize = BOTH_SIDES.len() + 4 * UNDER_FORCE.len();

/// A shape of a body, and the directions in which lateral forces move it.
pub struct BodyShape {
    displacement: Vec<f64>,
    directions: Vec<Vec<f64>>,
}

impl BodyShape {
    /// What a reduced model is trained on.
    pub(crate) fn as_snapshot(&self) -> Snapshot<'_> {
        Snapshot { displacement: &self.displacement, regions: &[], changes: &self.directions }
    }
}

/// Pressures of both sides, and the shape under them.
type Inflated = ([Pascal; 2], Vec<f64>);

/// The body at rest, every second equilibrium of both `sweeps`, equilibria with both sides filled, and those under forces. `tick` is called
/// after each that is solved for.
///
/// # Errors
/// When an equilibrium is not found.
pub fn training_shapes(
    body: &Body,
    line: &CentreLine,
    sweeps: &[PressureSweep; 2],
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<BodyShape>> {
    let top = sweeps[0].pressures.last().copied().unwrap_or(0.0);
    let lateral = LateralForces::new(body, line)?;
    let rest_shape = ([0.0; 2], vec![0.0; 3 * body.mesh.nodes.len()]);
    let swept = [Side::Left, Side::Right].into_iter().zip(sweeps).flat_map(|(side, sweep)| {
        let levels = sweep.pressures.iter().zip(&sweep.shapes).skip(1).step_by(2);
        levels.map(move |(pressure, shape)| (side.alone(*pressure), shape.clone()))
    });
    let both = BOTH_SIDES.par_iter().map(|shares| inflated_shape(body, sweeps, shares.map(|share| share * top)));
    let both: Vec<Inflated> = both.inspect(|_| tick()).collect::<Result<_>>()?;
    let loaded = UNDER_FORCE.par_iter().map(|shares| {
        let inflated = inflated_shape(body, sweeps, shares.map(|share| share * top))?;
        lateral.loaded_shapes(&inflated, tick)
    });
    let loaded: Vec<Vec<BodyShape>> = loaded.collect::<Result<_>>()?;
    let free: Vec<Inflated> = std::iter::once(rest_shape).chain(swept).chain(both).collect();
    let free: Vec<BodyShape> =
        free.into_par_iter().map(|inflated| lateral.with_directions(inflated)).collect::<Result<_>>()?;
    Ok(free.into_iter().chain(loaded.into_iter().flatten()).collect())
}

/// The equilibrium under pressures of both sides (left, right; Pa): of one side alone from the nearest shape of its sweep, of both from rest with
/// both in proportion, which leads past no buckle where they are alike.
fn inflated_shape(body: &Body, sweeps: &[PressureSweep; 2], pressures: [Pascal; 2]) -> Result<Inflated> {
    let [left, right] = pressures;
    let rest_shape = vec![0.0; 3 * body.mesh.nodes.len()];
    let (level, nearest) = match pressures {
        [left, 0.0] => sweeps[0].nearest_level(left),
        [0.0, right] => sweeps[1].nearest_level(right),
        _ => (0.0, rest_shape.as_slice()),
    };
    let ends = [pressures.map(|p| if p > 0.0 { level } else { 0.0 }), pressures];
    let ends = ends.map(|[left, right]| body.pressures(left, right));
    let ramp = LoadRamp { pressures: ends.each_ref().map(Vec::as_slice), forces: [&[], &[]] };
    let equilibrium = body.system.solver().equilibrium_along(&[(0.0, nearest)], &ramp, &static_settings());
    let doing = || format!("equilibrium at {:.0} and {:.0} mbar", left / si::MILLIBAR, right / si::MILLIBAR);
    Ok((pressures, equilibrium.map_err(|e| Diagnostic::from(e).while_doing(doing()))?.displacement))
}

fn static_settings() -> StaticSettings {
    StaticSettings { load_steps: 1, tolerance: TOLERANCE, ..StaticSettings::default() }
}

/// A body and the lateral forces that act on it.
struct LateralForces<'a> {
    body: &'a Body,
    line: &'a CentreLine,
    /// 3 a node, N per metre of the tip's displacement in the linear model at rest: one to one side, one that changes its sign along the tail.
    forces: [Vec<f64>; 2],
}

impl<'a> LateralForces<'a> {
    fn new(body: &'a Body, line: &'a CentreLine) -> Result<Self> {
        let end = line.stations.last().map_or(1.0, |s| s.x);
        let one_sign = |s: &Station| (s.x / end).powi(2);
        let two_signs = |s: &Station| (s.x / end) * (0.7 - s.x / end);
        let nodes = body.mesh.nodes.len();
        let forces = [line.lateral_forces(nodes, &one_sign), line.lateral_forces(nodes, &two_signs)];
        let unscaled = Self { body, line, forces };
        let responses = unscaled.linear_responses(&([0.0; 2], vec![0.0; 3 * nodes]));
        let responses = responses.map_err(|e| Diagnostic::from(e).while_doing("the body at rest"))?;
        let [one, two] = responses.each_ref().map(|responses| unscaled.tip_displacement(responses));
        let [first, second] = &unscaled.forces;
        Ok(Self { forces: [scaled_field(first, 1.0 / one), scaled_field(second, 1.0 / two)], ..unscaled })
    }

    /// An equilibrium with the directions in which the forces move it; without, where its tangent is not positive definite, as where a wall is
    /// about to snap.
    fn with_directions(&self, inflated: Inflated) -> Result<BodyShape> {
        let [first_goal, _, mixed] = TIP_DISPLACEMENTS;
        let directions = match self.linear_responses(&inflated) {
            Err(SolveError::NotStable) => Vec::new(),
            Err(other) => return Err(Diagnostic::from(other).while_doing("the tangent of an equilibrium")),
            Ok([one, two]) => vec![
                scaled_field(&one, first_goal / self.tip_displacement(&one)),
                scaled_field(&two, mixed / self.tip_displacement(&two)),
            ],
        };
        Ok(BodyShape { displacement: inflated.1, directions })
    }

    /// Displacements under each force in the linear model at an equilibrium, 3 a node.
    fn linear_responses(&self, ([left, right], displacement): &Inflated) -> Result<[Vec<f64>; 2], SolveError> {
        let (mut solver, pressures) = (self.body.system.solver(), self.body.pressures(*left, *right));
        let equilibrium = Equilibrium { displacement: displacement.clone(), pressures, ..Equilibrium::default() };
        solver.assemble(&equilibrium)?;
        solver.factorise(&equilibrium)?;
        let [one, two] = self.forces.each_ref().map(|force| solver.solve(force));
        Ok([one?, two?])
    }

    /// Greatest lateral displacement of the centre line, m.
    fn tip_displacement(&self, displacement: &[f64]) -> Metre {
        let line = self.line.displacements(displacement);
        line.iter().skip(1).step_by(2).fold(f64::MIN_POSITIVE, |greatest: f64, y| greatest.max(y.abs()))
    }

    /// The equilibria with each force in both directions at the pressures of an equilibrium.
    fn loaded_shapes(&self, (pressures, displacement): &Inflated, tick: &(dyn Fn() + Sync)) -> Result<Vec<BodyShape>> {
        let [left, right] = *pressures;
        let [with, against, mixed] = TIP_DISPLACEMENTS;
        let bends = (right - left).signum();
        let tip = |sign: f64| sign * if left == right || sign == bends { with } else { against };
        let cases = [1.0, -1.0].into_iter().flat_map(|sign| [(0, tip(sign)), (1, sign * mixed)]);
        let (mut solver, chambers) = (self.body.system.solver(), self.body.pressures(left, right));
        let no_forces = vec![0.0; displacement.len()];
        let mut shape_under_force = |(k, tip): (usize, Metre)| {
            let forces = scaled_field(&self.forces[k], tip);
            let ramp = LoadRamp { pressures: [&chambers; 2], forces: [&no_forces, &forces] };
            let equilibrium = solver.equilibrium_along(&[(0.0, displacement)], &ramp, &static_settings());
            let [left, right] = pressures.map(|p| p / si::MILLIBAR);
            let doing =
                || format!("shape at {left:.0} and {right:.0} mbar, tip moved by {:.1} mm", tip / si::MILLIMETRE);
            let equilibrium = equilibrium.map_err(|e| Diagnostic::from(e).while_doing(doing()))?;
            tick();
            Ok(BodyShape { displacement: equilibrium.displacement, directions: Vec::new() })
        };
        cases.map(&mut shape_under_force).collect()
    }
}

fn scaled_field(field: &[f64], factor: f64) -> Vec<f64> {
    field.iter().map(|entry| factor * entry).collect()
}
