//! Flapping: a tail in air or water under the pressures of both sides, in the coordinates of its reduced model.
//!
//! Time integration is BDF2 with the relaxation of the silicone; the pull on the holder follows from the balance of momentum.

use std::cell::Cell;

use crate::side::Side;
use diagnostics::{Diagnostic, Result};
use fem::{Actuation, DynamicSettings, NoForce, ReducedMotion, Scheme};
use mesh::BODY;
use nalgebra::{DMatrix, DVector};
use si::{Hertz, Newton, Pascal, Point2, Point3, Second};

use super::centre_line::CentreLine;
use super::snapshots;
use super::water::{Fluid, Kinematics, Water, WaterForce};
use super::{Body, Motion, PressureSweep};
use crate::settings::Mullins;

/// A tail in the coordinates of its reduced model.
pub struct FlappingModel<'a> {
    /// The whole body.
    pub body: &'a Body,
    /// The reduced model.
    pub reduced: fem::ReducedModel,
    /// The centre line.
    pub line: CentreLine,
    rest_line: Vec<Point2>,
    /// (stations × 2) × coordinates.
    rows: DMatrix<f64>,
    /// Coordinates × (nodes × 3), m.
    modes: Vec<Vec<f32>>,
    /// Σ m x of the whole tail by coordinate, kg m.
    moments: DVector<f64>,
    /// Equilibria of the reduced model at the pressures of both sweeps (left, right).
    pub(super) equilibria: [Vec<DVector<f64>>; 2],
}

/// Coordinates of the reduced model.
const COORDINATES: usize = 34;

/// Conditions that differ from trial to trial.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// The water; none in air.
    pub fluid: Option<Fluid>,
    /// The silicone's moduli relative to those at the reference temperature, no unit.
    pub softening: f64,
    /// The model that the trial's cycles have softened; none after a rest.
    pub softened: Option<&'a SoftenedModel>,
}

/// A tail whose silicone cycles have softened, point by point.
#[derive(Debug)]
pub struct SoftenedModel {
    reduced: fem::ReducedModel,
    /// Moduli at each sampled point of the silicone over those at rest, no unit.
    pub factors: Vec<f64>,
    /// Their mean over the silicone's volume.
    pub mean: f64,
}

/// The interval of a motion and its time step, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSpan {
    /// The body is at rest until then.
    pub start: Second,
    /// End of the motion.
    pub end: Second,
    /// Time step.
    pub step: Second,
}

/// A motion, and its force on the holder.
pub struct FlappingMotion<'a> {
    model: &'a FlappingModel<'a>,
    start: Second,
    rate: Hertz,
    shapes: Vec<DVector<f64>>,
    /// Force on the holder, forwards, and the thrust of the water in it, N.
    pulls: Vec<(Newton, Newton)>,
}

impl<'a> FlappingModel<'a> {
    /// Reduces `body` to the span of its equilibria in `sweeps` (left, right) and in the snapshots. `tick` is called after each
    /// equilibrium.
    ///
    /// # Errors
    /// When an equilibrium is not found.
    pub fn reduce_body(
        body: &Body,
        line: &CentreLine,
        sweeps: &[PressureSweep; 2],
        tick: &(dyn Fn() + Sync),
    ) -> Result<fem::ReducedModelData> {
        let shapes = snapshots::training_shapes(body, line, sweeps, tick)?;
        let snapshots: Vec<fem::Snapshot> = shapes.iter().map(snapshots::BodyShape::as_snapshot).collect();
        let settings =
            fem::ReductionSettings { coordinates: COORDINATES, tolerance: 5e-5, ..fem::ReductionSettings::default() };
        let reduced = body.system.reduce_trained(&snapshots, &settings);
        Ok(reduced.map_err(|e| Diagnostic::from(e).while_doing("the reduced model"))?.data())
    }

    /// The model of `body` in the coordinates of `reduced`, which was reduced from the same body and `sweeps`.
    ///
    /// # Errors
    /// When the data are of another body, or an equilibrium of the reduced model is not found.
    pub fn of_reduced_data(
        body: &'a Body,
        line: CentreLine,
        sweeps: &[PressureSweep; 2],
        reduced: &fem::ReducedModelData,
    ) -> Result<Self> {
        let reduced = body.system.restore(reduced);
        let reduced = reduced.map_err(|e| Diagnostic::from(e).while_doing("the reduced model"))?;
        let (rest_line, rows) = (line.rest_positions(body), line.station_rows(&reduced));
        let unit = |k: usize| DVector::from_fn(reduced.coordinates(), |i, _| f64::from(u8::from(i == k)));
        let mode = |k: usize| reduced.displacement(&unit(k)).into_iter().map(|u| u as f32).collect::<Vec<f32>>();
        let modes: Vec<Vec<f32>> = (0..reduced.coordinates()).map(mode).collect();
        let halves = if body.mesh.half { 2.0 } else { 1.0 };
        let moment = |mode: &Vec<f32>| {
            let x = body.system.node_masses().iter().zip(mode.iter().step_by(3));
            halves * x.map(|(m, u)| m * f64::from(*u)).sum::<f64>()
        };
        let moments = DVector::from_iterator(modes.len(), modes.iter().map(moment));
        let of_side = |side: Side, sweep: &PressureSweep| reduced_equilibria(body, &reduced, side, sweep);
        let equilibria = [of_side(Side::Left, &sweeps[0])?, of_side(Side::Right, &sweeps[1])?];
        Ok(Self { body, reduced, line, rest_line, rows, modes, moments, equilibria })
    }

    /// The motion from rest under the pressures (left, right; Pa) at any time (s).
    ///
    /// # Errors
    /// When a step does not converge.
    pub fn simulate_flapping(
        &'a self,
        span: TimeSpan,
        pressures: &dyn Fn(Second) -> [Pascal; 2],
        conditions: &Conditions,
    ) -> Result<FlappingMotion<'a>> {
        let TimeSpan { start, end, step } = span;
        let count = ((end - start) / step).ceil() as usize;
        let settings = DynamicSettings { step, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
        let actuation = |t: Second| {
            let [left, right] = pressures(start + t);
            Actuation { pressures: self.body.pressures(left, right) }
        };
        let relaxation = self.body.relaxation();
        let reduced = conditions.softened.map_or(&self.reduced, |softened| &softened.reduced);
        let motion = ReducedMotion {
            settings: &settings,
            modulus_scale: &self.body.modulus_scales(conditions.softening),
            relaxation: &relaxation,
            stiffening: &[],
            actuation: &actuation,
        };
        let observed = self
            .observe_motion((reduced, conditions.fluid), &motion, count)
            .map_err(|e| Diagnostic::from(e).while_doing(format!("motion between {start:.3} s and {end:.3} s")))?;
        let pulls = self.holder_forces(&observed.velocities, &observed.forces, 1.0 / step);
        Ok(FlappingMotion { model: self, start, rate: 1.0 / step, shapes: observed.shapes, pulls })
    }

    /// The motion of a reduced model from rest over `count` steps, in a fluid or in air.
    fn observe_motion(
        &self,
        (reduced, fluid): (&fem::ReducedModel, Option<Fluid>),
        motion: &ReducedMotion,
        count: usize,
    ) -> std::result::Result<ObservedMotion, fem::ReducedError> {
        let r = self.reduced.coordinates();
        let (mut shapes, mut velocities) = (vec![DVector::zeros(r)], vec![DVector::zeros(r)]);
        // a step that is halved accepts more forces than are observed
        let (last, mut forces) = (Cell::new(WaterForce::default()), vec![WaterForce::default()]);
        let mut observe = |_: Second, q: &DVector<f64>, v: &DVector<f64>| {
            shapes.push(q.clone());
            velocities.push(v.clone());
            forces.push(last.get());
        };
        match fluid {
            None => reduced.integrate(motion, &mut NoForce, count, &mut observe),
            Some(fluid) => {
                let mut water = ObservedWater { water: self.water_at_rest(fluid), last: &last };
                reduced.integrate(motion, &mut water, count, &mut observe)
            }
        }?;
        Ok(ObservedMotion { shapes, velocities, forces })
    }

    /// The model after cycles up to `pressure` (Pa) on either side; `pressures` are those of its sweeps.
    ///
    /// # Errors
    /// When the reduced model is refused.
    // The first cycle softens a point, which a square wave ends before the study's first window: that cycle is not resolved.
    pub fn softened_model(&self, mullins: &Mullins, pressures: &[Pascal], pressure: Pascal) -> Result<SoftenedModel> {
        let level = pressures.partition_point(|p| *p < pressure).min(pressures.len() - 1);
        let energies = |side: &Vec<DVector<f64>>| self.reduced.energy_densities(usize::from(BODY), &side[level]);
        let [left, right] = self.equilibria.each_ref().map(energies);
        let factors = left.iter().zip(right).map(|(left, right)| mullins.softened_share(left.max(right))).collect();
        self.with_point_factors(factors)
    }

    // Every law, relaxation included, is linear in the moduli, and a point enters the energy as weight times density: a factor of the moduli
    // is one of the weight.
    fn with_point_factors(&self, factors: Vec<f64>) -> Result<SoftenedModel> {
        let mut data = self.reduced.data();
        let points = &mut data.points[usize::from(BODY)];
        let volume: f64 = points.iter().map(|(_, weight)| weight).sum();
        points.iter_mut().zip(&factors).for_each(|((_, weight), factor)| *weight *= factor);
        let mean = points.iter().map(|(_, weight)| weight).sum::<f64>() / volume;
        let reduced = self.body.system.restore(&data);
        let reduced = reduced.map_err(|e| Diagnostic::from(e).while_doing("the softened reduced model"))?;
        Ok(SoftenedModel { reduced, factors, mean })
    }

    /// Water around the tail at rest.
    pub fn water_at_rest(&self, fluid: Fluid) -> Water<'_> {
        let half = self.body.mesh.half;
        Water::at_rest(fluid, &Kinematics { line: &self.line, rest: &self.rest_line, rows: &self.rows, half })
    }

    /// Force on the holder: the force of the water plus the rate of change of the tail's own momentum, which is counted rearwards.
    fn holder_forces(&self, velocities: &[DVector<f64>], forces: &[WaterForce], rate: Hertz) -> Vec<(Newton, Newton)> {
        let momentum: Vec<f64> = velocities.iter().map(|v| self.moments.dot(v)).collect();
        let last = momentum.len() - 1;
        let momentum_rate = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            (momentum[b] - momentum[a]) * rate / (b - a).max(1) as f64
        };
        forces.iter().enumerate().map(|(i, force)| (force.total + momentum_rate(i), force.thrust)).collect()
    }
}

/// Equilibria of the reduced model with `side` at the pressures of its sweep, each from the whole body's.
fn reduced_equilibria(
    body: &Body,
    reduced: &fem::ReducedModel,
    side: Side,
    sweep: &PressureSweep,
) -> Result<Vec<DVector<f64>>> {
    let equilibrium = |(pressure, shape): (&Pascal, &Vec<f64>)| {
        let guess = reduced.projected(shape);
        let solution = reduced.equilibrium(&body.one_side(side, *pressure), &body.modulus_scales(1.0), &guess);
        let doing = || format!("equilibrium of the reduced model at {:.0} mbar", pressure / si::MILLIBAR);
        solution.map_err(|e| Diagnostic::from(e).while_doing(doing()))
    };
    sweep.pressures.iter().zip(&sweep.shapes).map(equilibrium).collect()
}

/// Coordinates, velocities and forces of the fluid at the ends of steps, the start included.
struct ObservedMotion {
    shapes: Vec<DVector<f64>>,
    velocities: Vec<DVector<f64>>,
    forces: Vec<WaterForce>,
}

/// Water whose force at the end of the last step is kept.
struct ObservedWater<'a, 'b> {
    water: Water<'a>,
    last: &'b Cell<WaterForce>,
}

impl fem::ExternalForce for ObservedWater<'_, '_> {
    fn force(&self, state: &fem::StepState) -> DVector<f64> {
        self.water.force(state)
    }

    fn accept(&mut self, state: &fem::StepState) {
        self.water.accept(state);
        self.last.set(self.water.total);
    }
}

impl FlappingMotion<'_> {
    /// Linear between steps, zero beyond.
    fn between_steps(&self, t: Second, component: impl Fn(&(Newton, Newton)) -> Newton) -> Newton {
        let index = (t - self.start) * self.rate;
        let value_at_step = |i: f64| if i < 0.0 { 0.0 } else { self.pulls.get(i as usize).map_or(0.0, &component) };
        let fraction = index - index.floor();
        value_at_step(index.floor()) * (1.0 - fraction) + value_at_step(index.floor() + 1.0) * fraction
    }

    /// Coordinates × (nodes × 3), m.
    pub(super) fn nodal_modes(&self) -> &[Vec<f32>] {
        &self.model.modes
    }

    /// Coordinates at time `t` (s): linear between steps, constant beyond.
    pub(super) fn coordinates_at(&self, t: Second) -> DVector<f64> {
        let last = self.shapes.len() - 1;
        let index = ((t - self.start) * self.rate).clamp(0.0, last as f64);
        let first = (index.floor() as usize).min(last.saturating_sub(1));
        let fraction = index - first as f64;
        &self.shapes[first] * (1.0 - fraction) + &self.shapes[(first + 1).min(last)] * fraction
    }
}

impl Motion for FlappingMotion<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (nodes, displacements) =
            (&self.model.body.mesh.nodes, nodal_displacements(&self.model.modes, &self.coordinates_at(t)));
        let (displacements, _) = displacements.as_chunks::<3>();
        let node = |(x, u): (&Point3, &[f32; 3])| [0, 1, 2].map(|axis| x[axis] + f64::from(u[axis]));
        nodes.iter().zip(displacements).map(node).collect()
    }

    fn nodes_of(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let mut nodes = self.model.body.mesh.nodes.clone();
        for (node, u) in of.iter().zip(displacements_of(&self.model.modes, &self.coordinates_at(t), of)) {
            nodes[*node as usize].iter_mut().zip(u).for_each(|(x, u)| *x += f64::from(u));
        }
        nodes
    }

    fn pull(&self, t: Second) -> Newton {
        self.between_steps(t, |pull| pull.0)
    }

    fn thrust(&self, t: Second) -> Newton {
        self.between_steps(t, |pull| pull.1)
    }
}

/// Displacements of all nodes, nodes × 3, m.
pub(super) fn nodal_displacements(modes: &[Vec<f32>], q: &DVector<f64>) -> Vec<f32> {
    let mut displacements = vec![0.0; modes.first().map_or(0, Vec::len)];
    for (mode, q) in modes.iter().zip(q.iter()) {
        displacements.iter_mut().zip(mode).for_each(|(displacements, u)| *displacements += *q as f32 * u);
    }
    displacements
}

/// Displacements of the nodes `nodes`, m: the same sums as [`nodal_displacements`] in the same order, so the same numbers.
pub(super) fn displacements_of(modes: &[Vec<f32>], q: &DVector<f64>, nodes: &[u32]) -> Vec<[f32; 3]> {
    let mut displacements = vec![[0.0; 3]; nodes.len()];
    for (mode, q) in modes.iter().zip(q.iter()) {
        let (mode, _) = mode.as_chunks::<3>();
        for (displacements, node) in displacements.iter_mut().zip(nodes) {
            displacements
                .iter_mut()
                .zip(mode[*node as usize])
                .for_each(|(displacements, u)| *displacements += *q as f32 * u);
        }
    }
    displacements
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_of_some_nodes_equal_those_of_all_nodes() {
        let mode = |m: usize| (0..15).map(|k| ((7 * k + 3 * m) % 11) as f32 / 7.0 - 0.6).collect::<Vec<f32>>();
        let (modes, q) = ((0..4).map(mode).collect::<Vec<_>>(), DVector::from_vec(vec![0.31, -1.7, 0.05, 2.2]));
        let (all, of) = (nodal_displacements(&modes, &q), [0, 2, 4]);
        for (some, node) in displacements_of(&modes, &q, &of).iter().zip(of) {
            assert_eq!(some[..], all[3 * node as usize..][..3]);
        }
    }
}
