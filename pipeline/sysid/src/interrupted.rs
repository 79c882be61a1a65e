//! A diagnostic passed through an optimiser.

use optimize::OptimiseError;

use diagnostics::Diagnostic;

/// Why a search stops.
pub struct Interrupted(pub Diagnostic);

impl From<OptimiseError> for Interrupted {
    fn from(error: OptimiseError) -> Self {
        Self(Diagnostic::from(error))
    }
}
