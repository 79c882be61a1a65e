//! The contract of an optimiser, in the ask/tell form.
//!
//! The optimiser is asked for points and told their evaluations. The caller may evaluate a batch in parallel and in any order,
//! save it, or stop in between; an optimiser that called the simulator itself would permit none of this. An optimiser is
//! deterministic: the same evaluations lead to the same points.

use crate::{OptimiseError, Problem, Residuals};

/// What an optimiser needs beside the loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// The loss alone.
    Loss,
    /// The loss and its gradient.
    Gradient,
    /// The residuals whose sum of squares is minimised, and their Jacobian.
    Residuals,
}

/// One evaluated point.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The parameters.
    pub at: Vec<f64>,
    /// The loss there; infinite where there is no solution, never NaN.
    pub loss: f64,
    /// ∂loss/∂parameter, when asked for.
    pub gradient: Option<Vec<f64>>,
    /// Residuals and Jacobian, when asked for.
    pub residuals: Option<Residuals>,
}

impl Evaluation {
    /// A point and its loss alone.
    pub fn of_loss(at: Vec<f64>, loss: f64) -> Self {
        Self { at, loss, gradient: None, residuals: None }
    }
}

/// Why an optimiser has finished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finished {
    /// A convergence criterion is met.
    Converged {
        /// The criterion.
        because: &'static str,
    },
    /// The limit of evaluations or iterations is reached.
    Budget,
}

/// An optimiser in the ask/tell form.
pub trait Optimiser: Send {
    /// Its name in settings and figures.
    fn name(&self) -> &'static str;

    /// What each evaluation must hold.
    fn needs(&self) -> Needs;

    /// The points of the next iteration, all within the bounds; none when it has finished.
    fn ask(&mut self) -> Vec<Vec<f64>>;

    /// Takes the evaluations, in the order of the points that were asked for.
    ///
    /// # Errors
    /// [`OptimiseError`] when an evaluation is missing, is not a number, or permits no step.
    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), OptimiseError>;

    /// Why it has finished, or `None` while it has not.
    fn finished(&self) -> Option<Finished>;

    /// The best point so far, in the measure that this optimiser minimises.
    fn best(&self) -> Option<&Evaluation>;
}

/// Refuses evaluations at other points than those asked for, or with a loss that is NaN.
///
/// # Errors
/// [`OptimiseError::Length`], [`OptimiseError::OtherPoint`] or [`OptimiseError::Loss`].
pub(crate) fn check_evaluations(
    optimiser: &'static str,
    problem: &Problem,
    requested: &[Vec<f64>],
    evaluations: &[Evaluation],
) -> Result<(), OptimiseError> {
    if evaluations.len() != requested.len() {
        return Err(OptimiseError::Length {
            what: "the batch of evaluations",
            found: evaluations.len(),
            expected: requested.len(),
        });
    }
    for (requested, evaluation) in requested.iter().zip(evaluations) {
        if &evaluation.at != requested {
            let (evaluated, requested) = (problem.described_point(&evaluation.at), problem.described_point(requested));
            return Err(OptimiseError::OtherPoint { optimiser, evaluated, asked: requested });
        }
        if evaluation.loss.is_nan() {
            return Err(OptimiseError::Loss { loss: evaluation.loss, at: problem.described_point(&evaluation.at) });
        }
    }
    Ok(())
}

/// The gradient of an evaluation, refused when it permits no step.
///
/// A component that is exactly zero at the very first point (`first`) is refused too: it is an error in the derivative far more often
/// than a stationary point.
///
/// # Errors
/// [`OptimiseError::Missing`], [`OptimiseError::Length`] or [`OptimiseError::Gradient`], which names the parameter.
pub(crate) fn checked_gradient<'a>(
    optimiser: &'static str,
    problem: &Problem,
    evaluation: &'a Evaluation,
    first: bool,
) -> Result<&'a [f64], OptimiseError> {
    let described_point = || problem.described_point(&evaluation.at);
    let Some(gradient) = evaluation.gradient.as_deref() else {
        return Err(OptimiseError::Missing { optimiser, missing: "gradient", at: described_point() });
    };
    if gradient.len() != problem.dimension() {
        let (found, expected) = (gradient.len(), problem.dimension());
        return Err(OptimiseError::Length { what: "the gradient", found, expected });
    }
    for (name, &value) in problem.names().iter().zip(gradient) {
        let reason = match value {
            v if !v.is_finite() => "a step needs a finite gradient",
            v if first && v == 0.0 => "an exact zero at the start means that the loss does not depend on the parameter",
            _ => continue,
        };
        return Err(OptimiseError::Gradient { parameter: name.clone(), value, at: described_point(), why: reason });
    }
    Ok(gradient)
}

/// Keeps the evaluation with the lower loss; the earlier one when they are equal.
pub(crate) fn keep_better(best: &mut Option<Evaluation>, evaluation: &Evaluation) {
    if best.as_ref().is_none_or(|best| evaluation.loss < best.loss) {
        *best = Some(evaluation.clone());
    }
}
