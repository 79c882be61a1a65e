//! A table: it reads records and prints their numbers beside published ones.

use diagnostics::Result;

use crate::needs::Needs;
use crate::subject::Universe;

/// One table of the paper.
pub trait Table {
    /// The project's type.
    type Of: Universe;
    /// The records and the parts of their subjects that it reads.
    type Needs: Needs<Self::Of>;
    /// Its name: `paper/tables/NAME.{csv,tex,svg}`.
    const NAME: &'static str;
    /// Its caption, one phrase.
    const CAPTION: &'static str;
    /// Increased when the same records give another table.
    const VERSION: u32;

    /// Whether there is anything to show.
    fn is_made_for(subject: &Self::Of) -> bool {
        let _ = subject;
        true
    }

    /// Fills it in.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the records have no data to show.
    fn fill(needs: Self::Needs) -> Result<plot::Table>;
}
