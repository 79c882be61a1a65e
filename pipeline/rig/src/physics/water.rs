//! Water around a tail that flaps on the spot: the momentum that it gives to each slice of water, and what it sheds.
//!
//! Large-amplitude elongated-body theory [lighthill1971] with a resistive force across the flow. With w the speed of a section
//! along its normal n, u along its tangent t (towards the fin), m = ¼ π ρ s² a length of water as deep as the section:
//!
//! f = −∂(m w n)/∂t + ∂(m u w n − ½ m w² t)/∂s − ½ ρ C s |w| w n
//!
//! The flux ends at the trailing edge, where the fin is deepest: what leaves there is shed for good, and its reaction along the
//! tail is the thrust. Behind it the fin still carries water and resists.
//!
//! Stands on: the centre line. Never knows: elasticity, what is done with the force.

use std::collections::VecDeque;

use fem::{Around, Moment};
use nalgebra::{DMatrix, DVector};
use si::{Newton, Point2};

use super::line::CentreLine;

/// What the water is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// kg/m³.
    pub density: f64,
    /// Of the added mass of the theory, no unit.
    pub added: f64,
    /// C, no unit.
    pub drag: f64,
}

/// The stations' water at one moment.
struct Slices {
    /// m w n, kg/s: x₀, y₀, x₁, …
    momentum: DVector<f64>,
    /// m u w n − ½ m w² t, N.
    flux: Vec<Point2>,
    /// − ½ ρ C s |w| w n a length, N/m.
    drag: Vec<Point2>,
}

/// The force of water on a tail.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Push {
    /// The reaction of what is shed at the trailing edge, forwards; N.
    pub thrust: Newton,
    /// All of it, forwards (along −x); N.
    pub forwards: Newton,
}

/// Water around a tail whose shape is given by coordinates.
pub struct Water<'a> {
    line: &'a CentreLine,
    fluid: Fluid,
    rest: DVector<f64>,
    /// (stations × 2) × coordinates.
    rows: &'a DMatrix<f64>,
    /// Share of the tail that the coordinates' equations stand for: ½ of a half model.
    share: f64,
    /// Momenta of past steps, newest first.
    past: VecDeque<DVector<f64>>,
    /// At the last step.
    pub push: Push,
    /// On each station at the last step, N: x₀, y₀, x₁, …
    pub forces: DVector<f64>,
}

impl<'a> Water<'a> {
    /// Still water around a tail at rest at `rest`.
    pub fn around(line: &'a CentreLine, fluid: Fluid, rest: &[Point2], rows: &'a DMatrix<f64>, half: bool) -> Self {
        let rest = DVector::from_iterator(2 * rest.len(), rest.iter().flatten().copied());
        let still = DVector::zeros(rest.len());
        let share = if half { 0.5 } else { 1.0 };
        Self {
            line,
            fluid,
            rows,
            share,
            past: VecDeque::from([still.clone()]),
            rest,
            push: Push::default(),
            forces: still,
        }
    }

    fn slices(&self, at: &Moment) -> Slices {
        let (place, speed) = (&self.rest + self.rows * at.shape, self.rows * at.speed);
        let count = self.line.stations.len();
        let mut slices = Slices { momentum: DVector::zeros(2 * count), flux: Vec::new(), drag: Vec::new() };
        for (k, station) in self.line.stations.iter().enumerate() {
            let t = tangent(&place, k, count);
            let n = [-t[1], t[0]];
            let v = [speed[2 * k], speed[2 * k + 1]];
            let (u, w) = (v[0] * t[0] + v[1] * t[1], v[0] * n[0] + v[1] * n[1]);
            let m = self.fluid.added * 0.25 * std::f64::consts::PI * self.fluid.density * station.depth.powi(2);
            (0..2).for_each(|axis| slices.momentum[2 * k + axis] = m * w * n[axis]);
            slices.flux.push([0, 1].map(|axis| m * u * w * n[axis] - 0.5 * m * w * w * t[axis]));
            let resist = -0.5 * self.fluid.density * self.fluid.drag * station.depth * w.abs() * w;
            slices.drag.push(n.map(|n| resist * n));
        }
        slices
    }

    /// On each station, N: x₀, y₀, x₁, …
    fn pushes(&self, at: &Moment, slices: &Slices) -> DVector<f64> {
        let (spacing, trailing) = (self.line.spacing, self.line.trailing);
        let mut rate = &slices.momentum * at.gamma;
        self.past.iter().zip(at.weights).for_each(|(past, weight)| rate.axpy(*weight, past, 1.0));
        let mut forces = rate * -spacing;
        let between = |k: usize, axis: usize| 0.5 * (slices.flux[k][axis] + slices.flux[k + 1][axis]);
        for (k, drag) in slices.drag.iter().enumerate() {
            for axis in 0..2 {
                let before = if k == 0 { slices.flux[0][axis] } else { between(k - 1, axis) };
                let flux = match k {
                    k if k < trailing => between(k, axis) - before,
                    k if k == trailing => slices.flux[k][axis] - before,
                    _ => 0.0,
                };
                forces[2 * k + axis] += flux + spacing * drag[axis];
            }
        }
        forces
    }
}

impl Around for Water<'_> {
    fn force(&self, at: &Moment) -> DVector<f64> {
        self.rows.tr_mul(&self.pushes(at, &self.slices(at))) * self.share
    }

    fn accept(&mut self, at: &Moment) {
        let slices = self.slices(at);
        self.forces = self.pushes(at, &slices);
        let forwards = -self.forces.iter().step_by(2).sum::<f64>();
        self.push = Push { thrust: -slices.flux[self.line.trailing][0], forwards };
        self.past.push_front(slices.momentum);
        self.past.truncate(2);
    }
}

/// Along the line at station `k`, of length 1.
fn tangent(place: &DVector<f64>, k: usize, count: usize) -> Point2 {
    let (a, b) = (k.saturating_sub(1), (k + 1).min(count - 1));
    let d = [place[2 * b] - place[2 * a], place[2 * b + 1] - place[2 * a + 1]];
    d.map(|x| x / d[0].hypot(d[1]))
}
