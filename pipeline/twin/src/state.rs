//! The state of a reduced tail: what the next step needs of the past.

use std::collections::VecDeque;

use crate::elastic::Stresses;
use crate::history::{Factors, History};

/// What steps have cost so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Steps, parts of halved ones included.
    pub steps: usize,
    /// Evaluations of the residual.
    pub residuals: usize,
    /// Tangents that were summed and inverted.
    pub tangents: usize,
}

/// A moving tail.
#[derive(Debug, Clone)]
pub struct TwinState {
    pub(crate) time: f64,
    pub(crate) past: Past,
    /// One per chamber, Pa, at the end of the last step.
    pub(crate) pressures: Vec<f64>,
    /// One per region.
    pub(crate) histories: Vec<History>,
    /// Of each region's branches over a step of the length beside them.
    pub(crate) factors: (f64, Vec<Vec<Factors>>),
    pub(crate) lagged: Option<Lagged>,
    /// By region, at the end of the last step; nothing before the first.
    pub(crate) stresses: Vec<Stresses>,
    pub(crate) work: Work,
}

/// Past values, newest first.
#[derive(Debug, Clone)]
pub(crate) struct Past {
    pub times: VecDeque<f64>,
    pub coordinates: VecDeque<Vec<f64>>,
    pub velocities: VecDeque<Vec<f64>>,
    /// Of the water, J s.
    pub momenta: VecDeque<Vec<f64>>,
    /// Number of states that the next initial guess goes through.
    pub(crate) order: usize,
}

/// The inverse of a tangent, and the γ that it was made with.
#[derive(Debug, Clone)]
pub(crate) struct Lagged {
    pub inverse: Vec<f64>,
    pub gamma: f64,
}

/// ẋ = γ x + Σ w x_past.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil {
    pub gamma: f64,
    pub weights: [f64; 2],
}

/// Past states that are kept for the initial guess.
const KEPT: usize = 5;
/// A polynomial is the next initial guess where it came this much nearer in the last step than the last state did.
// What a guess that is not near strains the stiff sheet by is of second order in its distance, and spoils the first tangents. Measured on a
// flapping tail, residuals and tangents a step: always the parabola 6.0 and 2.5 in air, 5.2 and 1.5 in water; the nearest
// polynomial 5.8 and 2.4, 3.9 and 1.0; always the last state 4.6 and 1.3, 5.8 and 1.6; with this limit 4.4 and 1.5, 3.3 and 1.0.
const NEARER: f64 = 0.005;

impl TwinState {
    /// s since the start.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// q.
    pub fn coordinates(&self) -> &[f64] {
        &self.past.coordinates[0]
    }

    /// q̇, 1/s.
    pub fn velocity(&self) -> &[f64] {
        &self.past.velocities[0]
    }

    /// What its steps have cost.
    pub fn work(&self) -> Work {
        self.work
    }
}

impl Past {
    pub fn at_rest(r: usize) -> Self {
        let zero = || VecDeque::from([vec![0.0; r]]);
        Self { times: VecDeque::from([0.0]), coordinates: zero(), velocities: zero(), momenta: zero(), order: 1 }
    }

    /// Of saved values; none where a step cannot go on from them.
    pub(crate) fn restored(
        times: VecDeque<f64>,
        [coordinates, velocities, momenta]: [VecDeque<Vec<f64>>; 3],
        order: usize,
    ) -> Option<Self> {
        let falls = times.iter().zip(times.iter().skip(1)).all(|(newer, older)| newer > older);
        let is_whole = falls && (1..=KEPT).contains(&times.len()) && (1..=times.len()).contains(&order);
        is_whole.then_some(Self { times, coordinates, velocities, momenta, order })
    }

    /// Implicit Euler in the first step, then BDF2 [hairer1993], section III.5.
    pub(crate) fn step_stencil(&self, step: f64) -> Stencil {
        match self.times.get(1).map(|then| step / (self.times[0] - then)) {
            None => Stencil { gamma: 1.0 / step, weights: [-1.0 / step, 0.0] },
            Some(r) => Stencil {
                gamma: (1.0 + 2.0 * r) / ((1.0 + r) * step),
                weights: [-(1.0 + r) / step, r * r / ((1.0 + r) * step)],
            },
        }
    }

    /// The polynomial through the newest `count` coordinates at `time`, by Lagrange's weights.
    fn extrapolated_coordinates(&self, count: usize, time: f64) -> Vec<f64> {
        let times: Vec<f64> = self.times.iter().take(count).copied().collect();
        let other_times = |i: usize| (0..times.len()).filter(move |j| *j != i);
        let weight = |i: usize| other_times(i).map(|j| (time - times[j]) / (times[i] - times[j])).product::<f64>();
        let mut sum = vec![0.0; self.coordinates[0].len()];
        for (i, q) in self.coordinates.iter().take(count).enumerate() {
            crate::chambers::add(&mut sum, weight(i), q);
        }
        sum
    }

    /// The initial guess of a step that ends at `time`.
    // In air a tail's walls tremble, and the last state is the best guess; in water it moves smoothly, and the quartic is.
    pub fn initial_guess(&self, time: f64) -> Vec<f64> {
        self.extrapolated_coordinates(self.order, time)
    }

    /// Number of states whose polynomial would have been the guess of the step that ended at `time` in q.
    fn best_order(&self, time: f64, q: &[f64]) -> usize {
        let miss = |count: usize| {
            let guess = self.extrapolated_coordinates(count, time);
            guess.iter().zip(q).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let misses: Vec<f64> = (1..=self.times.len()).map(miss).collect();
        let best = (0..misses.len()).min_by(|a, b| misses[*a].total_cmp(&misses[*b])).unwrap_or(0);
        if misses[best] < NEARER * misses[0] { best + 1 } else { 1 }
    }

    pub fn push_state(&mut self, time: f64, [q, v, momentum]: [Vec<f64>; 3]) {
        self.order = self.best_order(time, &q);
        self.times.push_front(time);
        self.times.truncate(KEPT);
        for (past, now) in [(&mut self.coordinates, q), (&mut self.velocities, v), (&mut self.momenta, momentum)] {
            past.push_front(now);
            past.truncate(KEPT);
        }
    }
}

impl Stencil {
    /// Σ w x_past.
    pub fn weighted_history(&self, past: &VecDeque<Vec<f64>>) -> Vec<f64> {
        let mut sum = vec![0.0; past[0].len()];
        self.weights.iter().zip(past).for_each(|(weight, x)| crate::chambers::add(&mut sum, *weight, x));
        sum
    }
}
