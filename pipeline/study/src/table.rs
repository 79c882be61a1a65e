//! A table: it needs records and sets their numbers beside the published ones.
//!
//! The contract of `tables/`. Stands on: needs, plot. Never knows: file names, how a number was computed.

use crate::fault::Outcome;
use crate::needs::Needs;
use crate::subject::Study;

/// One table of the paper.
pub trait Table {
    /// The records it shows.
    type Needs: Needs<Study>;
    /// Its name: `paper/tables/NAME.{csv,tex,svg}`.
    const NAME: &'static str;
    /// What a reader learns from it, one sentence.
    const SHOWS: &'static str;
    /// Counted up when the same records give another table than before.
    const EDITION: u32;

    /// Whether there is anything to show: a study without a load cell has no such table.
    fn is_made_for(study: &Study) -> bool {
        let _ = study;
        true
    }

    /// Fills it in.
    ///
    /// # Errors
    /// A [`crate::fault::Fault`] when the records hold nothing to show.
    fn fill(needs: Self::Needs) -> Outcome<plot::Table>;
}
