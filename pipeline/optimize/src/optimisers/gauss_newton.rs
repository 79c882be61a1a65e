//! Gauss–Newton with Levenberg–Marquardt damping inside of bounds [marquardt1963; madsen2004, eq. 2.21].
//!
//! Each iteration solves (JᵀJ + λ diag JᵀJ) δ = −Jᵀr and tries θ + δ. A step that lowers ½ ‖r‖² is accepted and λ falls with the gain
//! ratio; any other is rejected and λ rises. A step to a point of infinite loss, where the model has no answer, is halved instead: λ says
//! how far the linearisation holds, not how far the model exists, and a rise of a small λ would ask for nearly the same point. A parameter on its bound whose gradient points outwards is fixed for the step.

use crate::optimiser::{check_evaluations, checked_gradient};
use crate::{Evaluation, Finished, Needs, OptimiseError, Optimiser, Problem, Residuals};

/// Its name.
pub const NAME: &str = "gauss_newton";

/// A fall of ½ ‖r‖² of residuals in standard deviations that leaves the parameters within 0.045 of their own.
pub const FALL: f64 = 1e-3;

/// Settings of Gauss–Newton.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// λ at the start; small where the start is good.
    pub damping: f64,
    /// It has converged when no parameter moves by more than this, in units of the parameters.
    pub step_tolerance: f64,
    /// It has converged when a step is predicted to lower ½ ‖r‖² by less than this as well ([`FALL`]); 0 asks for the step alone.
    pub fall_tolerance: f64,
    /// At most so many evaluations, rejected steps included.
    pub iterations: usize,
    /// The farthest that each parameter may move in a step, in its unit; empty where steps are as long as they are. Where a model is strongly
    /// nonlinear, the linearisation of a poorly determined parameter asks for steps that it does not describe.
    pub longest_step: Vec<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { damping: 1e-3, step_tolerance: 1e-6, fall_tolerance: 0.0, iterations: 50, longest_step: Vec::new() }
    }
}

/// Beyond this damping the step is shorter than any useful tolerance: the loss and its derivative are inconsistent.
const DAMPING_LIMIT: f64 = 1e12;

/// Gauss–Newton between two evaluations.
pub struct GaussNewton {
    problem: Problem,
    set: Settings,
    asked: Vec<f64>,
    best: Option<Evaluation>,
    damping: f64,
    rise: f64,
    /// The part of the step that is tried.
    part: f64,
    evaluations: usize,
    finished: Option<Finished>,
}

impl GaussNewton {
    /// Gauss–Newton at the initial guess of a problem.
    ///
    /// # Errors
    /// [`OptimiseError::Setting`] when a setting leaves no step to make.
    pub fn new(problem: &Problem, set: &Settings) -> Result<Self, OptimiseError> {
        let refuse = |setting, value, needed| Err(OptimiseError::Setting { optimiser: NAME, setting, value, needed });
        if !(set.damping > 0.0 && set.damping.is_finite()) {
            return refuse("damping", set.damping, "above 0");
        }
        if set.iterations == 0 {
            return refuse("iterations", 0.0, "at least 1");
        }
        Ok(Self {
            asked: problem.start().to_vec(),
            problem: problem.clone(),
            set: set.clone(),
            best: None,
            damping: set.damping,
            rise: 2.0,
            part: 1.0,
            evaluations: 0,
            finished: None,
        })
    }

    /// Accepts the trial and lowers the damping, or rejects it and raises the damping.
    fn update(&mut self, trial: &Evaluation) {
        let (Some(base), Some(new)) = (&self.best, &trial.residuals) else {
            self.best = Some(trial.clone());
            return;
        };
        let Some(old) = &base.residuals else { return };
        let step: Vec<f64> = trial.at.iter().zip(&base.at).map(|(a, b)| a - b).collect();
        let fall = old.half_sum_of_squares() - new.half_sum_of_squares();
        let gain_ratio = fall / old.predicted_reduction(&step);
        if fall > 0.0 && gain_ratio > 0.0 {
            // Nielsen's rule: λ changes continuously with the gain ratio, so that it does not alternate between two values as with
            // Marquardt's fixed factor. Every evaluation saved here is a whole set of simulations.
            self.damping *= (1.0 - (2.0 * gain_ratio - 1.0).powi(3)).max(1.0 / 3.0);
            self.rise = 2.0;
            self.best = Some(trial.clone());
        } else {
            self.reject_step();
        }
    }

    fn reject_step(&mut self) {
        self.damping *= self.rise;
        self.rise *= 2.0;
    }

    /// The next trial from the best point; finishes when it would lie where the best one does.
    fn plan(&mut self) -> Result<(), OptimiseError> {
        let Some(Evaluation { at, residuals: Some(residuals), .. }) = &self.best else { return Ok(()) };
        let free = self.free_axes(at, residuals);
        if free.iter().all(|f| !f) {
            self.finished = Some(Finished::Converged { because: "every parameter is fixed by its bound" });
            return Ok(());
        }
        let Some(step) = residuals.damped_step(self.damping, &free) else {
            let why = "JᵀJ is singular: the residuals do not change along some direction of the parameters".to_owned();
            return Err(OptimiseError::Undetermined { parameters: self.problem.dimension(), why });
        };
        let over = |(s, limit): (&f64, &f64)| limit / s.abs().max(f64::MIN_POSITIVE);
        let part = self.part * step.iter().zip(&self.set.longest_step).map(over).fold(1.0, f64::min);
        let wish: Vec<f64> = at.iter().zip(&step).map(|(x, s)| x + part * s).collect();
        let next = self.problem.bounds().clamp(&wish);
        let step: Vec<f64> = next.iter().zip(at).map(|(a, b)| a - b).collect();
        let longest = step.iter().fold(0.0, |longest: f64, s| longest.max(s.abs()));
        // near the minimum of a simulated loss its own error decides whether a step lowers it: rejected steps would then use up the budget
        let no_fall = (0.0..self.set.fall_tolerance).contains(&residuals.predicted_reduction(&step));
        self.asked = next;
        if longest < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "no parameter moves any more" });
        } else if no_fall {
            self.finished = Some(Finished::Converged { because: "no step lowers the loss any more" });
        } else if self.damping > DAMPING_LIMIT || self.evaluations == self.set.iterations {
            self.finished = Some(Finished::Budget);
        }
        Ok(())
    }

    fn free_axes(&self, at: &[f64], residuals: &Residuals) -> Vec<bool> {
        let bounds = self.problem.bounds();
        let gradient = residuals.gradient(at.len());
        let blocked =
            |i: usize| (at[i] <= bounds.low[i] && gradient[i] > 0.0) || (at[i] >= bounds.high[i] && gradient[i] < 0.0);
        (0..at.len()).map(|i| !blocked(i)).collect()
    }

    /// Refuses residuals of a wrong shape, or a Jacobian that permits no step.
    fn check(&self, evaluations: &Evaluation) -> Result<(), OptimiseError> {
        let at = || self.problem.describe(&evaluations.at);
        let Some(residuals) = &evaluations.residuals else {
            return Err(OptimiseError::Missing { optimiser: NAME, missing: "residuals and Jacobian", at: at() });
        };
        let expected = residuals.values.len() * self.problem.dimension();
        if residuals.jacobian.len() != expected {
            return Err(OptimiseError::Length { what: "the Jacobian", found: residuals.jacobian.len(), expected });
        }
        let square = residuals.half_sum_of_squares();
        if !square.is_finite() {
            return Err(OptimiseError::Loss { loss: square, at: at() });
        }
        let columns = column_sizes(residuals, self.problem.dimension());
        let sizes =
            Evaluation { gradient: Some(columns), ..Evaluation::of_loss(evaluations.at.clone(), evaluations.loss) };
        checked_gradient(NAME, &self.problem, &sizes, true).map(drop)
    }
}

/// The length of each column of the Jacobian (parameters): zero where no residual depends on the parameter.
fn column_sizes(residuals: &Residuals, parameters: usize) -> Vec<f64> {
    let square = |j: usize| residuals.jacobian.iter().skip(j).step_by(parameters).map(|v| v * v).sum::<f64>();
    (0..parameters).map(|j| square(j).sqrt()).collect()
}

impl Optimiser for GaussNewton {
    fn name(&self) -> &'static str {
        NAME
    }

    fn needs(&self) -> Needs {
        Needs::Residuals
    }

    fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.finished.is_some() { Vec::new() } else { vec![self.asked.clone()] }
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), OptimiseError> {
        check_evaluations(NAME, &self.problem, std::slice::from_ref(&self.asked), evaluations)?;
        self.evaluations += 1;
        if evaluations[0].loss == f64::INFINITY && self.best.is_some() {
            self.part *= 0.5;
        } else {
            self.part = 1.0;
            self.check(&evaluations[0])?;
            self.update(&evaluations[0]);
        }
        self.plan()
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.best.as_ref()
    }
}
