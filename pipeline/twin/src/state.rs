//! The state of a reduced tail: what the next step needs of the past.

use crate::chambers::add;
use crate::elastic::{Solid, Stresses};
use crate::history::{Factors, History};
use crate::workspace::Workspace;

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
    pub(crate) lagged: Lagged,
    /// By region, at the end of the last step; nothing before the first.
    pub(crate) stresses: Vec<Stresses>,
    pub(crate) work: Work,
    /// Buffers of the next step, which say nothing of the past.
    pub(crate) workspace: Workspace,
}

/// Past values, newest first, in places that are kept: a step takes no memory.
#[derive(Debug, Clone)]
pub(crate) struct Past {
    /// Number of values that there are.
    pub count: usize,
    pub times: [f64; KEPT],
    pub coordinates: [Vec<f64>; KEPT],
    pub velocities: [Vec<f64>; KEPT],
    /// Of the water, J s.
    pub momenta: [Vec<f64>; KEPT],
    /// Number of states that the next initial guess goes through.
    pub order: usize,
}

/// The inverse of a tangent, and the γ that it was made with; not a number where there is none.
#[derive(Debug, Clone)]
pub(crate) struct Lagged {
    pub inverse: Vec<f64>,
    pub gamma: f64,
}

impl Lagged {
    /// None yet, of `r` coordinates.
    pub(crate) fn none(r: usize) -> Self {
        Self { inverse: vec![0.0; r * r], gamma: f64::NAN }
    }
}

/// ẋ = γ x + Σ w x_past.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil {
    pub gamma: f64,
    pub weights: [f64; 2],
}

/// Past states that are kept for the initial guess.
pub(crate) const KEPT: usize = 5;
/// Steps, and γ, that differ by less than this, relative, are equal: times are sums that round.
pub(crate) const SAME: f64 = 1e-9;
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

    /// Makes the factors of the `solids`' branches those of a step of `duration` seconds.
    pub(crate) fn prepare_factors(&mut self, solids: &[Solid], duration: f64) {
        if (self.factors.0 / duration - 1.0).abs() <= SAME {
            return;
        }
        self.factors.0 = duration;
        for (solid, factors) in solids.iter().zip(&mut self.factors.1) {
            factors.clear();
            factors.extend(solid.branches.iter().map(|branch| Factors::new(*branch, duration)));
        }
    }

    /// What its steps have cost.
    pub fn work(&self) -> Work {
        self.work
    }
}

impl Past {
    pub fn at_rest(r: usize) -> Self {
        let zero = || std::array::from_fn(|_| vec![0.0; r]);
        Self { count: 1, times: [0.0; KEPT], coordinates: zero(), velocities: zero(), momenta: zero(), order: 1 }
    }

    /// Implicit Euler in the first step, then BDF2 [hairer1993], section III.5.
    pub(crate) fn step_stencil(&self, step: f64) -> Stencil {
        match self.times[..self.count].get(1).map(|then| step / (self.times[0] - then)) {
            // One step of first order leaves an error of second order in the step, so that the motion keeps the order
            // two.
            None => Stencil { gamma: 1.0 / step, weights: [-1.0 / step, 0.0] },
            // BDF2 is L-stable: vibrations of the stiff sheet far above the rate of the steps die out. Newmark's
            // trapezoidal rule would keep them for ever, and Euler's damps the flapping too.
            Some(r) => Stencil {
                gamma: (1.0 + 2.0 * r) / ((1.0 + r) * step),
                weights: [-(1.0 + r) / step, r * r / ((1.0 + r) * step)],
            },
        }
    }

    /// Fills `sum` with the polynomial through the newest `count` coordinates at `time`, by Lagrange's weights.
    fn extrapolate(&self, count: usize, time: f64, sum: &mut [f64]) {
        let times = &self.times[..count];
        let other_times = |i: usize| (0..count).filter(move |j| *j != i);
        let weight = |i: usize| other_times(i).map(|j| (time - times[j]) / (times[i] - times[j])).product::<f64>();
        sum.fill(0.0);
        for (i, q) in self.coordinates[..count].iter().enumerate() {
            add(sum, weight(i), q);
        }
    }

    /// Fills `q` with the initial guess of a step that ends at `time`.
    // In air a tail's walls tremble, and the last state is the best guess; in water it moves smoothly, and the quartic is.
    pub fn initial_guess(&self, time: f64, q: &mut [f64]) {
        self.extrapolate(self.order, time, q);
    }

    /// Number of states whose polynomial would have been the guess of the step that ended at `time` in q; `guess` is for the guesses.
    fn best_order(&self, time: f64, q: &[f64], guess: &mut [f64]) -> usize {
        let mut miss = |count: usize| {
            self.extrapolate(count, time, guess);
            guess.iter().zip(q).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let misses: [f64; KEPT] = std::array::from_fn(|i| if i < self.count { miss(i + 1) } else { f64::INFINITY });
        let best = (0..self.count).min_by(|a, b| misses[*a].total_cmp(&misses[*b])).unwrap_or(0);
        if misses[best] < NEARER * misses[0] { best + 1 } else { 1 }
    }

    /// Takes the state at `time`: q, q̇ and the water's momentum; `guess` is for guesses.
    pub fn push_state(&mut self, time: f64, [q, v, momentum]: [&[f64]; 3], guess: &mut [f64]) {
        self.order = self.best_order(time, q, guess);
        self.count = (self.count + 1).min(KEPT);
        self.times.rotate_right(1);
        self.times[0] = time;
        for (past, now) in [(&mut self.coordinates, q), (&mut self.velocities, v), (&mut self.momenta, momentum)] {
            past.rotate_right(1);
            past[0].copy_from_slice(now);
        }
    }
}

impl Stencil {
    /// Fills `sum` with Σ w x_past.
    pub(crate) fn weigh_history(&self, past: &[Vec<f64>; KEPT], sum: &mut [f64]) {
        sum.fill(0.0);
        self.weights.iter().zip(past).for_each(|(weight, x)| add(sum, *weight, x));
    }
}
