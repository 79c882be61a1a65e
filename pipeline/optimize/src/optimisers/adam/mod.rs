//! Adam [kingma2015, algorithm 1] inside of bounds: first-order descent with the moments of the gradient.
//!
//! The step length α may decay as α / (1 + decay · k). Points are clamped to the bounds. From a point without a solution it goes
//! half the way back to the last point that had one. Paper, section IV.

mod update;

pub(crate) use update::{Adam as Update, BiasCorrection};

use crate::optimiser::{check_evaluations, checked_gradient, keep_better};
use crate::{Evaluation, Finished, Needs, OptimiseError, Optimiser, Problem};

/// Its name.
pub const NAME: &str = "adam";

/// Settings of Adam.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// α, the length of a step on each axis while the gradient keeps its sign, in units of the parameters.
    pub step: f64,
    /// How fast the step shrinks, 1/iterations; 0 keeps it.
    pub step_decay: f64,
    /// β₁, decay of the first moment, 0 to 1.
    pub mean_decay: f64,
    /// β₂, decay of the second moment, 0 to 1.
    pub square_decay: f64,
    /// It has converged when no parameter moves by more than this, in units of the parameters.
    pub step_tolerance: f64,
    /// At most so many iterations, one evaluation each.
    pub iterations: usize,
}

impl Default for Settings {
    /// The published decays; a step of a tenth suits logarithms of moduli.
    fn default() -> Self {
        Self { step: 0.1, step_decay: 0.0, mean_decay: 0.9, square_decay: 0.999, step_tolerance: 1e-4, iterations: 100 }
    }
}

/// Adam between two evaluations.
pub struct Adam {
    problem: Problem,
    set: Settings,
    at: Vec<f64>,
    /// The last point that had a solution.
    last_solved: Vec<f64>,
    update: Update<f64>,
    iteration: usize,
    best: Option<Evaluation>,
    finished: Option<Finished>,
}

impl Adam {
    /// Adam at the initial guess of a problem.
    ///
    /// # Errors
    /// [`OptimiseError::Setting`] when a setting leaves no step to make.
    pub fn new(problem: &Problem, set: &Settings) -> Result<Self, OptimiseError> {
        let setting_error =
            |setting, value, needed| Err(OptimiseError::Setting { optimiser: NAME, setting, value, needed });
        match *set {
            Settings { step, .. } if !(step > 0.0 && step.is_finite()) => {
                return setting_error("step", step, "above 0");
            }
            Settings { step_decay: d, .. } if !(d >= 0.0 && d.is_finite()) => {
                return setting_error("step_decay", d, "0 or more");
            }
            Settings { mean_decay: b, .. } if !(0.0..1.0).contains(&b) => {
                return setting_error("mean_decay", b, "in [0, 1)");
            }
            Settings { square_decay: b, .. } if !(0.0..1.0).contains(&b) => {
                return setting_error("square_decay", b, "in [0, 1)");
            }
            Settings { iterations: 0, .. } => return setting_error("iterations", 0.0, "at least 1"),
            _ => {}
        }
        Ok(Self {
            at: problem.start().to_vec(),
            last_solved: problem.start().to_vec(),
            problem: problem.clone(),
            set: set.clone(),
            update: Update::new(problem.dimension(), [set.mean_decay, set.square_decay], BiasCorrection::OfMoments),
            iteration: 0,
            best: None,
            finished: None,
        })
    }

    /// One step; returns the largest change of a parameter, after clamping.
    fn take_step(&mut self, gradient: &[f64]) -> f64 {
        let alpha = self.set.step / (1.0 + self.set.step_decay * self.iteration as f64);
        self.iteration += 1;
        let mut unbounded = self.at.clone();
        self.update.update_parameters(&mut unbounded, gradient, alpha, self.iteration as i32);
        // The moments are those of the unclamped gradient: on a face of the box only the normal component is cut off, and the
        // convergence test below sees the clamped step, so a minimum on a face is recognised.
        let bounded = self.problem.bounds().clamp(&unbounded);
        let largest_change = bounded.iter().zip(&self.at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        self.at = bounded;
        largest_change
    }

    /// Half the way back to the last point that had a solution.
    fn halve_step(&mut self) {
        // Without a loss there is no gradient to update the moments by; they stay, and the point alone is moved.
        self.at = self.at.iter().zip(&self.last_solved).map(|(a, b)| 0.5 * (a + b)).collect();
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

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), OptimiseError> {
        check_evaluations(NAME, &self.problem, std::slice::from_ref(&self.at), evaluations)?;
        if evaluations[0].loss == f64::INFINITY && self.best.is_some() {
            self.halve_step();
            return Ok(());
        }
        self.last_solved.clone_from(&self.at);
        let gradient = checked_gradient(NAME, &self.problem, &evaluations[0], self.iteration == 0)?;
        keep_better(&mut self.best, &evaluations[0]);
        let largest_change = self.take_step(gradient);
        if largest_change < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "no parameter changes by more than the tolerance" });
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

    fn problem(start: f64) -> Problem {
        let bounds = Bounds { low: vec![-1.0], high: vec![1.0] };
        Problem::new(&["body"], vec![start], bounds).unwrap()
    }

    fn evaluations(at: f64, gradient: f64) -> Evaluation {
        Evaluation { gradient: Some(vec![gradient]), ..Evaluation::of_loss(vec![at], 1.0) }
    }

    #[test]
    fn the_first_step_has_the_length_of_the_setting_whatever_the_gradient() {
        for gradient in [1e-3, 1.0, 1e6] {
            let mut adam = Adam::new(&problem(0.0), &Settings::default()).unwrap();
            adam.tell(&[evaluations(0.0, gradient)]).unwrap();
            // ε = 1e-8 shortens it by 1e-8 / 1e-3
            assert!((adam.ask()[0][0] + 0.1).abs() < 2e-6);
        }
    }

    #[test]
    fn a_gradient_that_points_out_of_the_box_converges_on_its_face() {
        let mut adam = Adam::new(&problem(0.95), &Settings::default()).unwrap();
        adam.tell(&[evaluations(0.95, -1.0)]).unwrap();
        assert_eq!(adam.ask(), vec![vec![1.0]]);
        adam.tell(&[evaluations(1.0, -1.0)]).unwrap();
        assert!(matches!(adam.finished(), Some(Finished::Converged { .. })));
    }

    #[test]
    fn a_gradient_that_is_nan_infinite_or_zero_is_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, 0.0] {
            let mut adam = Adam::new(&problem(0.0), &Settings::default()).unwrap();
            let error = adam.tell(&[evaluations(0.0, bad)]).unwrap_err().to_string();
            assert!(error.starts_with("the gradient of the loss by `body` is"), "{error}");
        }
    }

    #[test]
    fn an_evaluation_without_a_gradient_is_refused() {
        let mut adam = Adam::new(&problem(0.0), &Settings::default()).unwrap();
        let error = adam.tell(&[Evaluation::of_loss(vec![0.0], 1.0)]).unwrap_err();
        assert!(matches!(error, OptimiseError::Missing { missing: "gradient", .. }), "{error}");
    }

    #[test]
    fn from_a_point_without_a_solution_it_goes_half_the_way_back() {
        let mut adam = Adam::new(&problem(0.0), &Settings::default()).unwrap();
        adam.tell(&[evaluations(0.0, -1.0)]).unwrap();
        let far = adam.ask()[0][0];
        adam.tell(&[Evaluation::of_loss(vec![far], f64::INFINITY)]).unwrap();
        assert_eq!(adam.ask(), vec![vec![0.5 * far]]);
        assert_eq!(adam.best().unwrap().at, vec![0.0]);
    }

    #[test]
    fn a_step_of_zero_is_refused() {
        let set = Settings { step: 0.0, ..Settings::default() };
        assert!(Adam::new(&problem(0.0), &set).is_err());
    }
}
