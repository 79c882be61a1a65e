//! Why no solution was found, with what was reached before.
//!
//! Stands on: `thiserror`, `search`, `equilibrium`. Never knows: how it was sought.

use crate::descent::search::Stall;
use crate::statics::equilibrium::Equilibrium;
use si::{Pascal, Second};

/// Why no solution was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A list of the wrong length.
    #[error(
        "{what} has {given} numbers\n  why: this system asks for {asked}\n  do:  give one pressure a chamber, and 3 numbers a node"
    )]
    Length {
        /// What was given.
        what: &'static str,
        /// How many numbers.
        given: usize,
        /// How many are needed.
        asked: usize,
    },
    /// An input that is NaN or infinite.
    #[error("{what} holds {value}\n  why: every number must be finite\n  do:  check where it comes from")]
    NotANumber {
        /// What was given.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A setting that cannot be followed.
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
    #[error("no equilibrium is found beyond {:.1} % of the load (largest pressure {pressure:.4e} Pa)\n  why: {stall}, in load steps of {:.2} %\n  do:  look at the last converged state; give a smaller load, a stiffer material or a finer mesh", 100.0 * .reached, 100.0 * .stride)]
    NoEquilibrium {
        /// Part of the load that was reached, 0 to 1.
        reached: f64,
        /// Load step that failed, as a part.
        stride: f64,
        /// Largest pressure asked for, Pa.
        pressure: Pascal,
        /// What went wrong in it.
        stall: Stall,
        /// The equilibrium at `reached`, converged to 1e-5 of the body's size; none when not even a first step was.
        last_converged: Option<Box<Equilibrium>>,
    },
    /// A tangent that is not positive definite.
    #[error(
        "the equilibrium is not stable\n  why: its tangent is not positive definite\n  do:  pass the equilibrium that this solver found with these very properties"
    )]
    NotStable,
    /// No time step was found.
    #[error(
        "no motion is found beyond {time:.6} s\n  why: {stall}, in a step of {step:.3e} s\n  do:  take a smaller time step or smoother pressures"
    )]
    NoMotion {
        /// The last time that was reached, s.
        time: Second,
        /// The time step, s.
        step: Second,
        /// What went wrong.
        stall: Stall,
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
