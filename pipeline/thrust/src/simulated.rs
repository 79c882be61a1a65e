//! Thrust of a simulated motion: its mean, and the gradient of that through the finite elements.
//!
//! A square wave of pressure moves a body; its markers are read at every step; a trained network or theory gives the thrust, whose
//! mean over the steps after `settled` is L. The derivative of L by the markers enters the adjoint of the motion, which gives ∂L/∂E
//! and ∂L/∂p of every step; the chain rule with the wave's derivatives gives ∂L/∂amplitude and ∂L/∂frequency. The mean of a rate in
//! time is the difference of its end values, so no step is differentiated.

use fem::{DynamicSettings, InitialValueProblem, LossGradient, Solver, State};
use hydro::{Tail, Terms};
use optimize::network::Network;
use si::{Newton, Point2, Second};

use crate::ascent::Objective;
use crate::square_wave::SquareWave;
use diagnostics::Result;

/// Bytes that a recorded motion may take.
const MEMORY: usize = 1 << 30;

/// The model that gives the thrust.
#[derive(Debug, Clone, Copy)]
pub enum ThrustLaw<'a> {
    /// The network: places and velocities of the markers, pressures and their rates.
    Network(&'a Network),
    /// Theory with its five coefficients, as `models::theory` has them.
    Theory(&'a Tail, [f64; 5]),
}

/// Markers and time steps of an evaluation of mean thrust.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation<'a> {
    /// Nodes of the body.
    pub nodes: usize,
    /// Markers as weighted nodes, from the head to the fin.
    pub marks: &'a [Vec<(u32, f64)>],
    /// Settings of the time integration.
    pub settings: DynamicSettings,
    /// Number of steps.
    pub steps: usize,
    /// Steps before the mean begins.
    pub settled: usize,
}

/// The mean thrust and its gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct ThrustGradient {
    /// N.
    pub mean: Newton,
    /// By Young's modulus of each region, N/Pa.
    pub by_youngs_modulus: Vec<f64>,
    /// By the wave's amplitude, N/Pa.
    pub by_amplitude: f64,
    /// By its frequency, N/Hz.
    pub by_frequency: f64,
}

/// One state of the recorded motion.
#[derive(Clone, Copy)]
struct Step<'a> {
    /// From 0, the state at rest.
    number: usize,
    /// s.
    time: Second,
    /// Displacement and velocity of every node.
    state: &'a State,
}

/// The markers at one step, x and y of each.
struct MarkerMotion {
    /// Displacement, m.
    moved: Vec<Point2>,
    /// Velocity, m/s.
    speed: Vec<Point2>,
}

/// Factors of theory's terms in the mean over the steps.
#[derive(Clone, Copy)]
pub(crate) struct Weights {
    /// Of an instantaneous term, no unit.
    pub part: f64,
    /// Of a quantity whose rate in time is a term, 1/s.
    pub ends: f64,
}

/// The thrust at one step and its derivatives.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Instant {
    pub value: f64,
    pub by_place: Vec<Point2>,
    pub by_velocity: Vec<Point2>,
    by_pressure: Vec<f64>,
    by_rate: Vec<f64>,
}

impl Evaluation<'_> {
    /// The mean thrust (N) of a body under `wave`, without a gradient.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the body finds no motion.
    pub fn mean(&self, solver: &mut Solver, wave: &SquareWave, law: &ThrustLaw) -> Result<Newton> {
        let (mut sum, mut step) = (0.0, 0);
        let initial = State::rest(self.nodes);
        let mut observe = |t: Second, state: &State| {
            step += 1;
            sum += self.step_contribution(Step { number: step, time: t, state }, wave, law).value;
        };
        let pressures = |t: Second| wave.at(t);
        solver.integrate(
            &InitialValueProblem { settings: &self.settings, initial: &initial, pressures: &pressures },
            self.steps,
            &mut observe,
        )?;
        Ok(sum)
    }

    /// The mean thrust and its gradient.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the body finds no motion or the adjoint of a step cannot be solved.
    pub fn gradient(&self, solver: &mut Solver, wave: &SquareWave, law: &ThrustLaw) -> Result<ThrustGradient> {
        let initial = State::rest(self.nodes);
        let pressures = |t: Second| wave.at(t);
        let trajectory = solver.record(
            &InitialValueProblem { settings: &self.settings, initial: &initial, pressures: &pressures },
            self.steps,
            MEMORY,
        )?;
        let mut predicted =
            ThrustGradient { mean: 0.0, by_youngs_modulus: Vec::new(), by_amplitude: 0.0, by_frequency: 0.0 };
        let times = trajectory.times().to_vec();
        let mut observe = |n: usize, state: &State| {
            let contribution = self.step_contribution(Step { number: n, time: times[n], state }, wave, law);
            predicted.mean += contribution.value;
            for (side, (p, r)) in [1.0, -1.0].iter().zip(contribution.by_pressure.iter().zip(&contribution.by_rate)) {
                let pressure = wave.value_at(*side, times[n]);
                predicted.by_amplitude += p * pressure.by_amplitude[0] + r * pressure.by_amplitude[1];
                predicted.by_frequency += p * pressure.by_frequency[0] + r * pressure.by_frequency[1];
            }
            self.loss_gradient(&contribution, state)
        };
        let adjoint = solver.trajectory_adjoint(&trajectory, &mut observe)?;
        for (n, step) in adjoint.pressures.iter().enumerate() {
            for (side, slope) in [1.0, -1.0].iter().zip(step) {
                let pressure = wave.value_at(*side, times[n + 1]);
                predicted.by_amplitude += slope * pressure.by_amplitude[0];
                predicted.by_frequency += slope * pressure.by_frequency[0];
            }
        }
        predicted.by_youngs_modulus = adjoint.regions.iter().map(|r| r.youngs_modulus).collect();
        Ok(predicted)
    }

    /// The share of a step in the mean.
    fn step_contribution(&self, Step { number, time, state }: Step, wave: &SquareWave, law: &ThrustLaw) -> Instant {
        let first = self.settled + 1;
        let ends = match number {
            n if n == self.settled => -1.0,
            n if n == self.steps => 1.0,
            _ => 0.0,
        };
        let counted = f64::from(u8::from(number >= first));
        if counted == 0.0 && ends == 0.0 {
            return Instant::default();
        }
        let count = (self.steps - self.settled) as f64;
        let markers =
            MarkerMotion { moved: self.marker_values(&state.displacement), speed: self.marker_values(&state.velocity) };
        match law {
            ThrustLaw::Network(network) if counted > 0.0 => self.network_contribution(network, &markers, wave, time),
            ThrustLaw::Network(_) => Instant::default(),
            ThrustLaw::Theory(tail, c) => {
                let terms = tail.terms(&markers.moved, &markers.speed);
                let weights = Weights { part: counted / count, ends: ends / (count * self.settings.step) };
                theory_contribution(&terms, c, weights, &markers.speed)
            }
        }
    }

    fn network_contribution(&self, network: &Network, markers: &MarkerMotion, wave: &SquareWave, t: Second) -> Instant {
        let MarkerMotion { moved, speed } = markers;
        let sides = [1.0, -1.0].map(|side| wave.value_at(side, t));
        let flat = |points: &[Point2]| points.iter().flatten().copied().collect::<Vec<f64>>();
        let row = [flat(moved), flat(speed), sides.map(|s| s.value).to_vec(), sides.map(|s| s.rate).to_vec()].concat();
        let (value, slopes) = network.prediction_and_slope(&row);
        let weight = 1.0 / (self.steps - self.settled) as f64;
        let slopes: Vec<f64> = slopes.iter().map(|slope| weight * slope).collect();
        let marks = 2 * moved.len();
        let pairs = |derivatives: &[f64]| derivatives.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        Instant {
            value: weight * value,
            by_place: pairs(&slopes[..marks]),
            by_velocity: pairs(&slopes[marks..2 * marks]),
            by_pressure: slopes[2 * marks..2 * marks + 2].to_vec(),
            by_rate: slopes[2 * marks + 2..].to_vec(),
        }
    }

    /// x and y of every marker.
    fn marker_values(&self, field: &[f64]) -> Vec<Point2> {
        let marker_value = |mark: &Vec<(u32, f64)>| {
            [0, 1].map(|k| mark.iter().map(|&(node, w)| w * field[3 * node as usize + k]).sum::<f64>())
        };
        self.marks.iter().map(marker_value).collect()
    }

    /// Derivatives by nodes from derivatives by markers.
    fn loss_gradient(&self, contribution: &Instant, state: &State) -> LossGradient {
        if contribution.by_place.is_empty() {
            return LossGradient::default();
        }
        let scattered = |derivatives: &[Point2]| {
            let mut field = vec![0.0; state.displacement.len()];
            for (mark, derivatives) in self.marks.iter().zip(derivatives) {
                for &(node, weight) in mark {
                    (0..2).for_each(|k| field[3 * node as usize + k] += weight * derivatives[k]);
                }
            }
            field
        };
        LossGradient { displacement: scattered(&contribution.by_place), velocity: scattered(&contribution.by_velocity) }
    }
}

/// The contribution of theory: instantaneous terms weighted by `part`, rates in time by `ends`.
pub(crate) fn theory_contribution(
    terms: &Terms,
    coefficients: &[f64; 5],
    Weights { part, ends }: Weights,
    speed: &[Point2],
) -> Instant {
    let last_marker = speed.len() - 1;
    let weighted_terms = [
        (&terms.edge_flux, part * coefficients[0]),
        (&terms.drag, part * coefficients[2]),
        (&terms.momentum, ends * coefficients[1]),
    ];
    let summed = |derivative: fn(&hydro::Term) -> &Vec<Point2>| {
        (0..speed.len())
            .map(|marker| {
                [0, 1].map(|k| weighted_terms.iter().map(|(term, weight)| weight * derivative(term)[marker][k]).sum())
            })
            .collect()
    };
    let (by_place, mut by_velocity): (Vec<Point2>, Vec<Point2>) =
        (summed(|p| &p.by_displacement), summed(|p| &p.by_velocity));
    by_velocity[last_marker][0] += ends * coefficients[3];
    let value = weighted_terms.iter().map(|(term, weight)| weight * term.value).sum::<f64>()
        + ends * coefficients[3] * speed[last_marker][0]
        + part * coefficients[4];
    Instant { value, by_place, by_velocity, ..Instant::default() }
}

/// Mean thrust of a full model as an objective, with the gradient through the finite elements.
pub struct SimulatedThrust<'a> {
    /// Markers and time steps.
    pub bench: &'a Evaluation<'a>,
    /// The body's solver.
    pub solver: &'a mut Solver,
    /// The model that gives the thrust.
    pub law: &'a ThrustLaw<'a>,
}

impl Objective for SimulatedThrust<'_> {
    fn value(&mut self, wave: &SquareWave) -> Result<Newton> {
        self.bench.mean(self.solver, wave, self.law)
    }

    fn gradient(&mut self, wave: &SquareWave) -> Result<[f64; 2]> {
        let predicted = self.bench.gradient(self.solver, wave, self.law)?;
        Ok([predicted.by_amplitude, predicted.by_frequency])
    }
}
