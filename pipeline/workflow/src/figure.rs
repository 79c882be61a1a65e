//! A figure: it reads records and draws them; it computes nothing but units.

use diagnostics::Result;

use crate::needs::Needs;
use crate::subject::Universe;

/// One figure of the paper.
pub trait Figure {
    /// The project's type.
    type Of: Universe;
    /// The records and the parts of their subjects that it reads.
    type Needs: Needs<Self::Of>;
    /// Its name: `figures/NAME.svg`.
    const NAME: &'static str;
    /// Its caption, one phrase.
    const CAPTION: &'static str;
    /// Increased when the same records give another picture.
    const VERSION: u32;

    /// Whether there is anything to show.
    fn is_made_for(subject: &Self::Of) -> bool {
        let _ = subject;
        true
    }

    /// Draws it.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the records have no data to show.
    fn draw(needs: Self::Needs) -> Result<plot::Figure>;
}
