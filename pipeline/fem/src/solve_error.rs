//! Errors of a solve, with the last converged state where there is one.

use crate::newton::options::NonConvergence;
use crate::statics::equilibrium::Equilibrium;
use si::{Pascal, Second};
use sparse::FactorError;

/// Why a solve failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A list of the wrong length.
    #[error(
        "{what} has {given} numbers\n  why: this system requires {required}\n  do:  give one pressure per chamber, and 3 numbers per node"
    )]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        given: usize,
        /// The length required.
        required: usize,
    },
    /// An input that is NaN or infinite.
    #[error("{what} contains {value}\n  why: every number must be finite\n  do:  check the source of this input")]
    NotFinite {
        /// Which input.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A setting out of range.
    #[error("{what} is {value:e}\n  why: it must be {range}\n  do:  change the setting")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// No equilibrium was found beyond part of the load.
    #[error("no equilibrium is found beyond {:.1} % of the load (largest pressure {pressure:.4e} Pa)\n  why: {cause}, in load steps of {:.2} %\n  do:  look at the last converged state; give a smaller load, a stiffer material or a finer mesh", 100.0 * .load_factor, 100.0 * .load_step)]
    NoEquilibrium {
        /// Load factor of the last converged state, 0 to 1.
        load_factor: f64,
        /// Load step that failed, as a fraction of the load.
        load_step: f64,
        /// Largest pressure applied, Pa.
        pressure: Pascal,
        /// Why the load step failed.
        #[source]
        cause: NonConvergence,
        /// The equilibrium at `load_factor`, converged to 1e-5 of the body's size; none when the first load step
        /// failed.
        last_converged: Option<Box<Equilibrium>>,
    },
    /// A tangent that is not positive definite.
    #[error(
        "the equilibrium is not stable\n  why: its tangent is not positive definite\n  do:  pass the equilibrium that this solver found with its current properties"
    )]
    NotStable,
    /// A tangent that is too large with the couplings of walls in contact.
    #[error("the couplings of walls in contact make the tangent too large\n  why: {0}\n  do:  take a coarser mesh")]
    TooLarge(#[from] FactorError),
    /// Modes whose search was ended.
    #[error(
        "the search for modes ended after {iterations} iterations\n  why: it was asked to end\n  do:  ask for fewer modes, or give more time"
    )]
    Interrupted {
        /// Iterations of the subspace until then.
        iterations: usize,
    },
    /// A time step without a solution.
    #[error(
        "no time step is found beyond {time:.6} s\n  why: {cause}, in a step of {step:.3e} s\n  do:  take a smaller time step or smoother pressures"
    )]
    TimeStep {
        /// Time of the last state, s.
        time: Second,
        /// The time step, s.
        step: Second,
        /// Why the step failed.
        #[source]
        cause: NonConvergence,
    },
}

impl SolveError {
    /// The last equilibrium before the failure, when there is one.
    pub fn last_converged(&self) -> Option<&Equilibrium> {
        match self {
            Self::NoEquilibrium { last_converged, .. } => last_converged.as_deref(),
            _ => None,
        }
    }
}
