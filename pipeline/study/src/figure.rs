//! A figure: it needs records and draws them; it computes nothing but units.
//!
//! The contract of `figures/`. Stands on: needs, plot. Never knows: file names, fonts, colours of its own.

use serde_json::Value;

use crate::fault::Outcome;
use crate::needs::Needs;
use crate::subject::Study;

/// One figure of the paper.
pub trait Figure {
    /// The records it shows.
    type Needs: Needs<Study>;
    /// Its name: `figures/NAME.svg`.
    const NAME: &'static str;
    /// What a reader learns from it, one sentence.
    const SHOWS: &'static str;
    /// Counted up when the same records give another picture than before.
    const EDITION: u32;

    /// Whether there is anything to show: a study without a load cell has no such figure.
    fn is_made_for(study: &Study) -> bool {
        let _ = study;
        true
    }

    /// What it shows of the cards and of the pipeline itself, beside records: a change of it makes the figure stale.
    fn card(study: &Study) -> Value {
        let _ = study;
        Value::Null
    }

    /// Draws it.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when the records hold nothing to show.
    fn draw(needs: Self::Needs) -> Outcome<plot::Figure>;
}
