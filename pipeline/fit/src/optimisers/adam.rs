//! Adam: steps along a running mean of the gradient, each axis scaled by the running size of its own gradient.
//!
//! mₖ = β₁ mₖ₋₁ + (1 − β₁) g,  vₖ = β₂ vₖ₋₁ + (1 − β₂) g²,
//! θ ← θ − α (m / (1 − β₁ᵏ)) / (√(v / (1 − β₂ᵏ)) + ε)      [kingma2015], algorithm 1; paper, section IV
//!
//! The step α may shrink as α / (1 + decay · k). Points are clamped to the bounds; from one without a solution it goes half the
//! way back.
//!
//! Stands on: the contract. Never knows: another optimiser.

use crate::optimiser::{answers_fit, keep_better, sound_gradient};
use crate::{Evaluation, Finished, FitError, Needs, Optimiser, Search};

/// Its name.
pub const NAME: &str = "adam";

/// How Adam walks.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// α, the length of a step on each axis while the gradient keeps its sign, in units of the parameters.
    pub step: f64,
    /// How fast the step shrinks, 1/iterations; 0 keeps it.
    pub step_decay: f64,
    /// β₁, how much of the mean gradient stays, 0 to 1.
    pub mean_memory: f64,
    /// β₂, how much of the mean square stays, 0 to 1.
    pub square_memory: f64,
    /// It has converged when no parameter moves by more than this, in units of the parameters.
    pub step_tolerance: f64,
    /// At most so many iterations, one evaluation each.
    pub iterations: usize,
}

impl Default for Settings {
    /// The published memories; a step of a tenth suits logarithms of moduli.
    fn default() -> Self {
        Self {
            step: 0.1,
            step_decay: 0.0,
            mean_memory: 0.9,
            square_memory: 0.999,
            step_tolerance: 1e-4,
            iterations: 100,
        }
    }
}

/// Keeps a gradient of zero from a division by zero; the published ε.
const EPSILON: f64 = 1e-8;

/// Adam on its way.
pub struct Adam {
    search: Search,
    set: Settings,
    at: Vec<f64>,
    /// The last point that had a solution.
    good: Vec<f64>,
    mean: Vec<f64>,
    square: Vec<f64>,
    iteration: usize,
    best: Option<Evaluation>,
    finished: Option<Finished>,
}

impl Adam {
    /// Adam at the start of a search.
    ///
    /// # Errors
    /// [`FitError::Setting`] when a setting leaves no step to make.
    pub fn new(search: &Search, set: &Settings) -> Result<Self, FitError> {
        let refuse = |setting, value, needed| Err(FitError::Setting { optimiser: NAME, setting, value, needed });
        match *set {
            Settings { step, .. } if !(step > 0.0 && step.is_finite()) => return refuse("step", step, "above 0"),
            Settings { step_decay: d, .. } if !(d >= 0.0 && d.is_finite()) => {
                return refuse("step_decay", d, "0 or more");
            }
            Settings { mean_memory: b, .. } if !(0.0..1.0).contains(&b) => {
                return refuse("mean_memory", b, "in [0, 1)");
            }
            Settings { square_memory: b, .. } if !(0.0..1.0).contains(&b) => {
                return refuse("square_memory", b, "in [0, 1)");
            }
            Settings { iterations: 0, .. } => return refuse("iterations", 0.0, "at least 1"),
            _ => {}
        }
        let zero = vec![0.0; search.dimension()];
        Ok(Self {
            at: search.start().to_vec(),
            good: search.start().to_vec(),
            search: search.clone(),
            set: set.clone(),
            mean: zero.clone(),
            square: zero,
            iteration: 0,
            best: None,
            finished: None,
        })
    }

    /// One step; returns the longest way that a parameter went, after clamping.
    fn step(&mut self, gradient: &[f64]) -> f64 {
        let Settings { mean_memory: beta1, square_memory: beta2, .. } = self.set;
        let alpha = self.set.step / (1.0 + self.set.step_decay * self.iteration as f64);
        self.iteration += 1;
        let k = self.iteration as i32;
        let mut wish = self.at.clone();
        for (i, g) in gradient.iter().enumerate() {
            self.mean[i] = beta1 * self.mean[i] + (1.0 - beta1) * g;
            self.square[i] = beta2 * self.square[i] + (1.0 - beta2) * g * g;
            let m = self.mean[i] / (1.0 - beta1.powi(k));
            let v = self.square[i] / (1.0 - beta2.powi(k));
            wish[i] -= alpha * m / (v.sqrt() + EPSILON);
        }
        let next = self.search.bounds().clamp(&wish);
        let longest = next.iter().zip(&self.at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        self.at = next;
        longest
    }
}

impl Adam {
    /// Half the way back to the last point that had a solution.
    fn turn_back(&mut self) {
        self.at = self.at.iter().zip(&self.good).map(|(a, b)| 0.5 * (a + b)).collect();
        self.iteration += 1;
        if self.iteration >= self.set.iterations {
            self.finished = Some(Finished::Budget);
        }
    }
}

impl Optimiser for Adam {
    fn name(&self) -> &'static str {
        NAME
    }

    fn needs(&self) -> Needs {
        Needs::Gradient
    }

    fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.finished.is_some() { Vec::new() } else { vec![self.at.clone()] }
    }

    fn tell(&mut self, told: &[Evaluation]) -> Result<(), FitError> {
        answers_fit(NAME, &self.search, std::slice::from_ref(&self.at), told)?;
        if told[0].loss == f64::INFINITY && self.best.is_some() {
            self.turn_back();
            return Ok(());
        }
        self.good.clone_from(&self.at);
        let gradient = sound_gradient(NAME, &self.search, &told[0], self.iteration == 0)?;
        keep_better(&mut self.best, &told[0]);
        let longest = self.step(gradient);
        if longest < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "no parameter moves any more" });
        } else if self.iteration == self.set.iterations {
            self.finished = Some(Finished::Budget);
        }
        Ok(())
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.best.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounds;

    fn search(start: f64) -> Search {
        let bounds = Bounds { low: vec![-1.0], high: vec![1.0] };
        Search::new(&["body"], vec![start], bounds).unwrap()
    }

    fn told(at: f64, gradient: f64) -> Evaluation {
        Evaluation { gradient: Some(vec![gradient]), ..Evaluation::of_loss(vec![at], 1.0) }
    }

    #[test]
    fn the_first_step_has_the_set_length_whatever_the_gradient() {
        for gradient in [1e-3, 1.0, 1e6] {
            let mut adam = Adam::new(&search(0.0), &Settings::default()).unwrap();
            adam.tell(&[told(0.0, gradient)]).unwrap();
            // ε = 1e-8 shortens it by 1e-8 / 1e-3
            assert!((adam.ask()[0][0] + 0.1).abs() < 2e-6);
        }
    }

    #[test]
    fn a_gradient_that_points_out_of_the_box_converges_on_its_face() {
        let mut adam = Adam::new(&search(0.95), &Settings::default()).unwrap();
        adam.tell(&[told(0.95, -1.0)]).unwrap();
        assert_eq!(adam.ask(), vec![vec![1.0]]);
        adam.tell(&[told(1.0, -1.0)]).unwrap();
        assert!(matches!(adam.finished(), Some(Finished::Converged { .. })));
    }

    #[test]
    fn a_gradient_that_is_nan_infinite_or_dead_is_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, 0.0] {
            let mut adam = Adam::new(&search(0.0), &Settings::default()).unwrap();
            let error = adam.tell(&[told(0.0, bad)]).unwrap_err().to_string();
            assert!(error.starts_with("the gradient of the loss by `body` is"), "{error}");
        }
    }

    #[test]
    fn an_evaluation_without_a_gradient_is_refused() {
        let mut adam = Adam::new(&search(0.0), &Settings::default()).unwrap();
        let error = adam.tell(&[Evaluation::of_loss(vec![0.0], 1.0)]).unwrap_err();
        assert!(matches!(error, FitError::Missing { missing: "gradient", .. }), "{error}");
    }

    #[test]
    fn a_point_without_a_solution_is_left_half_the_way_back() {
        let mut adam = Adam::new(&search(0.0), &Settings::default()).unwrap();
        adam.tell(&[told(0.0, -1.0)]).unwrap();
        let far = adam.ask()[0][0];
        adam.tell(&[Evaluation::of_loss(vec![far], f64::INFINITY)]).unwrap();
        assert_eq!(adam.ask(), vec![vec![0.5 * far]]);
        assert_eq!(adam.best().unwrap().at, vec![0.0]);
    }

    #[test]
    fn a_step_of_zero_is_refused() {
        let set = Settings { step: 0.0, ..Settings::default() };
        assert!(Adam::new(&search(0.0), &set).is_err());
    }
}
