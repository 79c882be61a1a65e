//! Checks of markers in space: the file can be read, its markers begin at their places on the card, and the log has its clock.

use super::Project;
use super::film::DecodedFilm;
use super::finding::Finding;
use diagnostics::Result;
use records::Motion;
use records::subject::Trial;
use study::stages::clock::Clock;
use study::stages::markers::Markers;
use workflow::needs::Maybe;
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// How the markers of a trial in space are read, what is wrong with them, and without a film the trial's motion; `logged` is whether its
/// pressure log can be read, `film` its film where there is one.
///
/// # Errors
/// A diagnostic when the settings of a stage are invalid.
pub(crate) fn space_findings(
    project: &Project,
    subject: &Trial,
    (logged, film): (bool, Option<&DecodedFilm>),
) -> Result<(Option<Motion>, Vec<Finding>)> {
    let Some((tracks, axes)) = subject.in_space() else { return Ok((None, Vec::new())) };
    if !project.file_path(&subject.card.name, &tracks.file).exists() {
        return Ok((None, Vec::new()));
    }
    let (raw, settings) = (Markers::raw(subject), project.settings.section("markers")?);
    let context = inspection_context(project.folders, &raw);
    let of_film = film.map(|film| film.tracks.clone());
    let markers = match Markers::run(&Part::part_of(subject), &settings, (Maybe(None), Maybe(of_film)), &context) {
        Err(diagnostic) => return Ok((None, vec![diagnostic.into()])),
        Ok(markers) => markers,
    };
    let tracks_path = project.display_path(&subject.card.name, &tracks.file);
    let [from, to] = [markers.time.first(), markers.time.last()].map(|time| time.copied().unwrap_or_default());
    let (count, frames) = (markers.markers.len(), markers.time.len());
    let summary = format!(
        "{tracks_path}: {count} markers in space × {frames} frames at {:.1} Hz",
        (frames - 1) as f64 / (to - from)
    );
    let is_filmed = subject.trial.video.is_some();
    let owner = if is_filmed { "they are on the film's" } else { "without a film they are on the log's" };
    let clock = format!("{owner} clock from {from:.3} to {to:.3} s, by start = {} s", axes.start);
    let mut findings = vec![Finding::log(summary, clock)];
    // with a film the clock is checked by its lamp
    let mut trial_motion = None;
    if logged && !is_filmed {
        let (raw, settings) = (Clock::raw(subject), project.settings.section("clock")?);
        let context = inspection_context(project.folders, &raw);
        let motion = Clock::run(&Part::part_of(subject), &settings, (Maybe(None), Maybe(None), markers), &context);
        match motion {
            Ok(motion) => trial_motion = Some(motion),
            Err(diagnostic) => findings.push(diagnostic.into()),
        }
    }
    Ok((trial_motion, findings))
}
