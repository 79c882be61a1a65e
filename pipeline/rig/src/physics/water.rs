//! Hydrodynamic force on a tail that flaps without forward speed.
//!
//! Large-amplitude elongated-body theory \[lighthill1971\] with a resistive force normal to the section. With w the velocity of a section
//! along its normal n, u along its tangent t (towards the fin), and m = ¼ π ρ s² the added mass per length at depth s:
//!
//! f = −∂(m w n)/∂t + ∂(m u w n − ½ m w² t)/∂s − ½ ρ C s |w| w n
//!
//! The flux ends at the trailing edge, where the fin is deepest: momentum that leaves there is shed, and its reaction along the tail is the
//! thrust. Behind the trailing edge the fin still has added mass and drag; without them the identified added mass and drag were too large
//! by a factor of two.

use std::collections::VecDeque;

use fem::{ExternalForce, StepState};
use nalgebra::{DMatrix, DVector};
use si::{Newton, Point2};

use super::centre_line::CentreLine;

/// Properties of the water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// kg/m³.
    pub density: f64,
    /// Added mass relative to the theory's, no unit.
    pub added: f64,
    /// Drag coefficient C normal to the section, no unit.
    pub drag: f64,
}

/// Momentum, flux and drag at the stations at one time.
struct Slices {
    /// m w n, kg/s: x₀, y₀, x₁, …
    momentum: DVector<f64>,
    /// m u w n − ½ m w² t, N.
    flux: Vec<Point2>,
    /// −½ ρ C s |w| w n per length, N/m.
    drag: Vec<Point2>,
}

/// The resultant force of the water on a tail.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WaterForce {
    /// Reaction of the momentum shed at the trailing edge, positive forwards, N.
    pub thrust: Newton,
    /// Resultant force, positive forwards (along −x), N.
    pub total: Newton,
}

/// The motion of a centre line in reduced coordinates.
pub(super) struct Kinematics<'a> {
    pub(super) line: &'a CentreLine,
    /// Positions at rest, m.
    pub(super) rest: &'a [Point2],
    /// (stations × 2) × coordinates.
    pub(super) rows: &'a DMatrix<f64>,
    /// Whether the coordinates describe half of the tail.
    pub(super) half: bool,
}

/// Water around a tail in reduced coordinates.
pub struct Water<'a> {
    line: &'a CentreLine,
    fluid: Fluid,
    rest: DVector<f64>,
    /// (stations × 2) × coordinates.
    rows: &'a DMatrix<f64>,
    /// Fraction of the tail in the equations of the coordinates: ½ for a half model.
    fraction: f64,
    /// Momenta of past steps, newest first.
    past: VecDeque<DVector<f64>>,
    /// At the last step.
    pub total: WaterForce,
    /// On each station at the last step, N: x₀, y₀, x₁, …
    pub forces: DVector<f64>,
}

impl<'a> Water<'a> {
    /// Water at rest around a tail at rest.
    pub(super) fn at_rest(fluid: Fluid, kinematics: &Kinematics<'a>) -> Self {
        let Kinematics { line, rest, rows, half } = *kinematics;
        let rest = DVector::from_iterator(2 * rest.len(), rest.iter().flatten().copied());
        let zero = DVector::zeros(rest.len());
        let fraction = if half { 0.5 } else { 1.0 };
        Self {
            line,
            fluid,
            rows,
            fraction,
            past: VecDeque::from([zero.clone()]),
            rest,
            total: WaterForce::default(),
            forces: zero,
        }
    }

    fn slices_of(&self, state: &StepState) -> Slices {
        let (position, speed) = (&self.rest + self.rows * state.coordinates, self.rows * state.velocity);
        let count = self.line.stations.len();
        let mut slices = Slices { momentum: DVector::zeros(2 * count), flux: Vec::new(), drag: Vec::new() };
        for (k, station) in self.line.stations.iter().enumerate() {
            let t = unit_tangent(&position, k, count);
            let n = [-t[1], t[0]];
            let v = [speed[2 * k], speed[2 * k + 1]];
            let (u, w) = (v[0] * t[0] + v[1] * t[1], v[0] * n[0] + v[1] * n[1]);
            let m = self.fluid.added * 0.25 * std::f64::consts::PI * self.fluid.density * station.depth.powi(2);
            (0..2).for_each(|axis| slices.momentum[2 * k + axis] = m * w * n[axis]);
            slices.flux.push([0, 1].map(|axis| m * u * w * n[axis] - 0.5 * m * w * w * t[axis]));
            let drag = -0.5 * self.fluid.density * self.fluid.drag * station.depth * w.abs() * w;
            slices.drag.push(n.map(|n| drag * n));
        }
        slices
    }

    /// Force on each station, N: x₀, y₀, x₁, …
    fn station_forces(&self, state: &StepState, slices: &Slices) -> DVector<f64> {
        let (spacing, trailing) = (self.line.spacing, self.line.trailing);
        let mut rate = &slices.momentum * state.gamma;
        self.past.iter().zip(state.weights).for_each(|(past, weight)| rate.axpy(*weight, past, 1.0));
        let mut forces = rate * -spacing;
        let between = |k: usize, axis: usize| 0.5 * (slices.flux[k][axis] + slices.flux[k + 1][axis]);
        for (k, drag) in slices.drag.iter().enumerate() {
            for axis in 0..2 {
                let inflow = if k == 0 { slices.flux[0][axis] } else { between(k - 1, axis) };
                let flux = match k {
                    k if k < trailing => between(k, axis) - inflow,
                    k if k == trailing => slices.flux[k][axis] - inflow,
                    _ => 0.0,
                };
                forces[2 * k + axis] += flux + spacing * drag[axis];
            }
        }
        forces
    }
}

impl ExternalForce for Water<'_> {
    fn force(&self, state: &StepState) -> DVector<f64> {
        self.rows.tr_mul(&self.station_forces(state, &self.slices_of(state))) * self.fraction
    }

    fn accept(&mut self, state: &StepState) {
        let slices = self.slices_of(state);
        self.forces = self.station_forces(state, &slices);
        let total = -self.forces.iter().step_by(2).sum::<f64>();
        self.total = WaterForce { thrust: -slices.flux[self.line.trailing][0], total };
        self.past.push_front(slices.momentum);
        self.past.truncate(2);
    }
}

/// Unit tangent of the line at station `k`.
fn unit_tangent(position: &DVector<f64>, k: usize, count: usize) -> Point2 {
    let (a, b) = (k.saturating_sub(1), (k + 1).min(count - 1));
    let d = [position[2 * b] - position[2 * a], position[2 * b + 1] - position[2 * a + 1]];
    d.map(|x| x / d[0].hypot(d[1]))
}
