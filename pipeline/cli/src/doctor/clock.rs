//! Checks of the clocks: the lamp's edges in film and log match, and the film has frames at rest before the first command.

use super::Look;
use super::film::Seen;
use super::finding::Finding;
use study::stages::clock::{Clock, Settings, Synchronisation};
use study::subject::Trial;
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// Whether film and log of a trial match.
pub fn look(look: &Look, of: &Trial, seen: &Seen, set: &Settings) -> Vec<Finding> {
    let raw = Clock::raw(of);
    let context = inspection_context(look.folders, &raw);
    let synchronisation = Synchronisation { card: &Part::part_of(of), set, context: &context };
    synchronisation.check(&seen.tracks, seen.height).err().map(Finding::from).into_iter().collect()
}
