//! What an optimiser is: it asks for points, is told their losses, and knows when it has finished.
//!
//! Asking and telling leave the evaluation to the caller, who may work on a whole batch in parallel, save it, or
//! stop in between. An optimiser is deterministic: the same answers bring the same questions.
//!
//! Stands on: [`Search`] and the error type. Never knows: its members (`optimisers/`), or how a loss is computed.

use crate::{FitError, Residuals, Search};

/// What an optimiser needs to be told beside the loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// The loss alone.
    Loss,
    /// The loss and its gradient.
    Gradient,
    /// The residuals whose sum of squares is minimised, and their Jacobian.
    Residuals,
}

/// One point that was tried.
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

/// Why an optimiser asks no more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finished {
    /// It has what it looked for.
    Converged {
        /// The rule that was met.
        because: &'static str,
    },
    /// It has used what it was given.
    Budget,
}

/// An optimiser: asks for points, is told what they are worth.
pub trait Optimiser: Send {
    /// Its name, as settings and figures call it.
    fn name(&self) -> &'static str;

    /// What it must be told.
    fn needs(&self) -> Needs;

    /// The points of the next iteration, all inside of the bounds; none when it has finished.
    fn ask(&mut self) -> Vec<Vec<f64>>;

    /// The answers, in the order of the points that were asked for.
    ///
    /// # Errors
    /// [`FitError`] when an answer is missing, is not a number, or no step can be made from it.
    fn tell(&mut self, told: &[Evaluation]) -> Result<(), FitError>;

    /// Why it has finished, or `None` while it has not.
    fn finished(&self) -> Option<Finished>;

    /// The best point so far, in the measure that this optimiser minimises.
    fn best(&self) -> Option<&Evaluation>;
}

/// Refuses answers that do not belong to the questions, or whose loss is NaN.
///
/// # Errors
/// [`FitError::Length`], [`FitError::OtherPoint`] or [`FitError::Loss`].
pub fn answers_fit(
    optimiser: &'static str,
    search: &Search,
    asked: &[Vec<f64>],
    told: &[Evaluation],
) -> Result<(), FitError> {
    if told.len() != asked.len() {
        return Err(FitError::Length { what: "the told batch", found: told.len(), expected: asked.len() });
    }
    for (asked, told) in asked.iter().zip(told) {
        if &told.at != asked {
            let (told, asked) = (search.describe(&told.at), search.describe(asked));
            return Err(FitError::OtherPoint { optimiser, told, asked });
        }
        if told.loss.is_nan() {
            return Err(FitError::Loss { loss: told.loss, at: search.describe(&told.at) });
        }
    }
    Ok(())
}

/// The gradient of an evaluation, refused when no step can be made from it.
///
/// A component that is exactly zero at the very first point (`first`) means that the loss does not feel the
/// parameter, which is a slip in the derivative far more often than a minimum.
///
/// # Errors
/// [`FitError::Missing`], [`FitError::Length`] or [`FitError::Gradient`], which names the parameter.
pub fn sound_gradient<'a>(
    optimiser: &'static str,
    search: &Search,
    told: &'a Evaluation,
    first: bool,
) -> Result<&'a [f64], FitError> {
    let at = || search.describe(&told.at);
    let Some(gradient) = told.gradient.as_deref() else {
        return Err(FitError::Missing { optimiser, missing: "gradient", at: at() });
    };
    if gradient.len() != search.dimension() {
        let (found, expected) = (gradient.len(), search.dimension());
        return Err(FitError::Length { what: "the gradient", found, expected });
    }
    for (name, &value) in search.names().iter().zip(gradient) {
        let why = match value {
            v if !v.is_finite() => "a step needs a finite gradient",
            v if first && v == 0.0 => "an exact zero at the start means that the loss does not feel the parameter",
            _ => continue,
        };
        return Err(FitError::Gradient { parameter: name.clone(), value, at: at(), why });
    }
    Ok(gradient)
}

/// Keeps the evaluation with the lower loss; the earlier one when they are equal.
pub fn keep_better(best: &mut Option<Evaluation>, told: &Evaluation) {
    if best.as_ref().is_none_or(|best| told.loss < best.loss) {
        *best = Some(told.clone());
    }
}
