//! Errors of path following.

use fem::SolveError;
use si::Metre;
use sparse::FactorError;

/// Why a step along a path failed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StepFailure {
    /// The residual is not defined, as with an inverted element.
    #[error("the residual is not defined there: an element is inverted or a force is not finite")]
    NotDefined,
    /// The tangent is singular to working precision.
    #[error("the tangent is singular to working precision")]
    Singular,
    /// Newton's method does not converge.
    #[error("the last Newton step is still {step:.2e} m after {iterations} iterations")]
    IterationLimit {
        /// Size of the last Newton step.
        step: Metre,
        /// Iterations made.
        iterations: usize,
    },
    /// The step ends far from where the tangent leads.
    #[error("the step turns away from its tangent: the cosine of the angle between them is {cosine:.2}")]
    Turned {
        /// Cosine of the angle between step and tangent.
        cosine: f64,
    },
}

/// Why a path was not followed to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ContinuationError {
    /// A setting out of range.
    #[error("{what} is {value:e}\n  why: it must be between {least:e} and {most:e}\n  do:  change the setting")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its least value.
        least: f64,
        /// Its largest value.
        most: f64,
    },
    /// A load that does not fit the body.
    #[error("{what}\n  why: {why}\n  do:  correct the load")]
    Load {
        /// What is wrong.
        what: String,
        /// Why it is.
        why: &'static str,
    },
    /// A load that the solver refuses.
    #[error(transparent)]
    Solver(#[from] SolveError),
    /// A mesh that is too large for its factor.
    #[error("the body cannot be factorised\n  why: {0}\n  do:  take a coarser mesh")]
    Factor(#[from] FactorError),
    /// There is no equilibrium to begin with.
    #[error(
        "no equilibrium is found at the load factor {load_factor}, where the path begins\n  why: {cause}\n  do:  begin at a smaller load"
    )]
    Start {
        /// Load factor at which the path begins.
        load_factor: f64,
        /// Why it is not found.
        #[source]
        cause: StepFailure,
    },
    /// The path cannot be continued.
    #[error(
        "the path ends at the load factor {load_factor:.6}\n  why: {cause}, in a step of {step:.2e} of the body's size\n  do:  allow shorter steps, or look at the last point: the material may give way there"
    )]
    Stalled {
        /// Load factor of the last point.
        load_factor: f64,
        /// Length of the step that failed, over the body's size.
        step: f64,
        /// Why it failed.
        #[source]
        cause: StepFailure,
    },
}
