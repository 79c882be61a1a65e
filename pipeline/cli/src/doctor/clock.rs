//! Checks of the clocks: the lamp's edges in film and log match, and the film has frames at rest before the first command.

use records::Motion;

use super::Project;
use super::film::DecodedFilm;
use super::finding::Finding;
use records::subject::Trial;
use study::stages::clock::{Clock, Settings, Synchronisation};
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// Whether film and log of a trial match; where they do, the pressures on the film's clock.
pub(crate) fn clock_findings(
    project: &Project,
    subject: &Trial,
    film: &DecodedFilm,
    settings: &Settings,
) -> (Option<Motion>, Vec<Finding>) {
    let raw = Clock::raw(subject);
    let context = inspection_context(project.folders, &raw);
    let synchronisation = Synchronisation { card: &Part::part_of(subject), set: settings, context: &context };
    match synchronisation.check(&film.tracks, film.height) {
        Ok(motion) => (Some(motion), Vec::new()),
        Err(diagnostic) => (None, vec![diagnostic.into()]),
    }
}
