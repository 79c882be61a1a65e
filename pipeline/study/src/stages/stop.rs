//! Stop: a fault on its way through an optimiser.
//!
//! Stands on: the fault, fit. Never knows: which optimiser.

use fit::FitError;

use crate::fault::Fault;

/// Why a search stops.
pub struct Stop(pub Fault);

impl From<FitError> for Stop {
    fn from(error: FitError) -> Self {
        Self(Fault::from_tool(error))
    }
}
