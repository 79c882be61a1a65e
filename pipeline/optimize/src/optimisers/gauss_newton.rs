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
        let setting_error =
            |setting, value, needed| Err(OptimiseError::Setting { optimiser: NAME, setting, value, needed });
        if !(set.damping > 0.0 && set.damping.is_finite()) {
            return setting_error("damping", set.damping, "above 0");
        }
        if set.iterations == 0 {
            return setting_error("iterations", 0.0, "at least 1");
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
    fn update_best(&mut self, trial: &Evaluation) {
        let (Some(best), Some(trial_residuals)) = (&self.best, &trial.residuals) else {
            self.best = Some(trial.clone());
            return;
        };
        let Some(base_residuals) = &best.residuals else { return };
        let step: Vec<f64> = trial.at.iter().zip(&best.at).map(|(a, b)| a - b).collect();
        let decrease = base_residuals.half_sum_of_squares() - trial_residuals.half_sum_of_squares();
        let gain_ratio = decrease / base_residuals.predicted_reduction(&step);
        if decrease > 0.0 && gain_ratio > 0.0 {
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
    fn plan_step(&mut self) -> Result<(), OptimiseError> {
        let Some(Evaluation { at: point, residuals: Some(residuals), .. }) = &self.best else { return Ok(()) };
        let free = self.free_axes(point, residuals);
        if free.iter().all(|f| !f) {
            self.finished = Some(Finished::Converged { because: "every parameter is fixed by its bound" });
            return Ok(());
        }
        let Some(step) = residuals.damped_step(self.damping, &free) else {
            let reason =
                "JᵀJ is singular: the residuals do not change along some direction of the parameters".to_owned();
            return Err(OptimiseError::Undetermined { parameters: self.problem.dimension(), why: reason });
        };
        let step_limit = |(s, limit): (&f64, &f64)| limit / s.abs().max(f64::MIN_POSITIVE);
        let step_fraction = self.part * step.iter().zip(&self.set.longest_step).map(step_limit).fold(1.0, f64::min);
        let target: Vec<f64> = point.iter().zip(&step).map(|(x, s)| x + step_fraction * s).collect();
        let next_point = self.problem.bounds().clamp(&target);
        let step: Vec<f64> = next_point.iter().zip(point).map(|(a, b)| a - b).collect();
        let largest_change = step.iter().fold(0.0, |largest_change: f64, s| largest_change.max(s.abs()));
        // near the minimum of a simulated loss its own error decides whether a step lowers it: rejected steps would then use up the budget
        let is_stalled = (0.0..self.set.fall_tolerance).contains(&residuals.predicted_reduction(&step));
        self.asked = next_point;
        if largest_change < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "no parameter moves any more" });
        } else if is_stalled {
            self.finished = Some(Finished::Converged { because: "no step lowers the loss any more" });
        } else if self.damping > DAMPING_LIMIT || self.evaluations == self.set.iterations {
            self.finished = Some(Finished::Budget);
        }
        Ok(())
    }

    fn free_axes(&self, point: &[f64], residuals: &Residuals) -> Vec<bool> {
        let bounds = self.problem.bounds();
        let gradient = residuals.gradient(point.len());
        let is_blocked = |i: usize| {
            (point[i] <= bounds.low[i] && gradient[i] > 0.0) || (point[i] >= bounds.high[i] && gradient[i] < 0.0)
        };
        (0..point.len()).map(|i| !is_blocked(i)).collect()
    }

    /// Refuses residuals of a wrong shape, or a Jacobian that permits no step.
    fn check_evaluation(&self, evaluation: &Evaluation) -> Result<(), OptimiseError> {
        let described_point = || self.problem.described_point(&evaluation.at);
        let Some(residuals) = &evaluation.residuals else {
            return Err(OptimiseError::Missing {
                optimiser: NAME,
                missing: "residuals and Jacobian",
                at: described_point(),
            });
        };
        let expected = residuals.values.len() * self.problem.dimension();
        if residuals.jacobian.len() != expected {
            return Err(OptimiseError::Length { what: "the Jacobian", found: residuals.jacobian.len(), expected });
        }
        let half_squares = residuals.half_sum_of_squares();
        if !half_squares.is_finite() {
            return Err(OptimiseError::Loss { loss: half_squares, at: described_point() });
        }
        let column_norms = column_norms(residuals, self.problem.dimension());
        let norm_evaluation =
            Evaluation { gradient: Some(column_norms), ..Evaluation::of_loss(evaluation.at.clone(), evaluation.loss) };
        checked_gradient(NAME, &self.problem, &norm_evaluation, true).map(drop)
    }
}

/// The length of each column of the Jacobian (parameters): zero where no residual depends on the parameter.
fn column_norms(residuals: &Residuals, parameters: usize) -> Vec<f64> {
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
            self.check_evaluation(&evaluations[0])?;
            self.update_best(&evaluations[0]);
        }
        self.plan_step()
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.best.as_ref()
    }
}
