//! `study track`: tracks markers in any film, or in many, without a project.
//!
//! Writes `<film>.tracks/` beside each film; of several films, a table says what was lost where.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use instruments::film::{self, Request, Starts};

use crate::options::TrackFilm;

/// What became of the films.
pub struct Tracked {
    /// A summary, a line a film.
    pub summary: String,
    /// Whether every marker was tracked through every film.
    pub complete: bool,
}

/// Tracks the markers of one film or of each of several, and writes the results. Of several films, one that is refused or in which a marker
/// is lost does not keep the others; a table, `tracked.csv` in `--out` or beside the first, says what was lost where.
///
/// # Errors
/// A [`Diagnostic`] when the one film cannot be read, there is no marker at a clicked position, or one is lost.
pub fn run(options: &TrackFilm) -> Result<Tracked> {
    if let [film] = &options.films[..] {
        let folder = options.out.clone().unwrap_or_else(|| film::beside(film));
        return Ok(Tracked { summary: track_film(options, film, folder)?, complete: true });
    }
    let track_beside = |film: &PathBuf| track_film(options, film, folder_of_many(options, film));
    let outcomes: Vec<(&PathBuf, Result<String>)> =
        options.films.iter().map(|film| (film, track_beside(film))).collect();
    let film_folder = options.films[0].parent().unwrap_or(Path::new("")).to_owned();
    let table_path = options.out.clone().unwrap_or(film_folder).join("tracked.csv");
    std::fs::write(&table_path, outcome_table(&outcomes))
        .map_err(|e| Diagnostic::io(&table_path, e, "choose another folder with --out"))?;
    let line = |(film, outcome): &(&PathBuf, Result<String>)| match outcome {
        Ok(summary) => format!("{}: {summary}\n", film.display()),
        Err(lost) => format!("{}: error: {lost}\n", film.display()),
    };
    let lost = outcomes.iter().filter(|(_, outcome)| outcome.is_err()).count();
    let summary: String = outcomes.iter().map(line).collect();
    let film_count = outcomes.len();
    let summary =
        format!("{summary}{film_count} films, {lost} not tracked to their end; table: {}", table_path.display());
    Ok(Tracked { summary, complete: lost == 0 })
}

/// The folder of one of many films: in `--out`, or beside it.
fn folder_of_many(options: &TrackFilm, film: &Path) -> PathBuf {
    let default_folder = film::beside(film);
    match (&options.out, default_folder.file_name()) {
        (Some(out), Some(name)) => out.join(name),
        _ => default_folder,
    }
}

/// Tracks one film; returns a summary line.
fn track_film(options: &TrackFilm, film: &Path, folder: PathBuf) -> Result<String> {
    let starts = match options.find {
        Some(count) => Starts::Find { count, region: options.region },
        None => Starts::At(options.at.clone()),
    };
    let request = Request {
        film: film.to_owned(),
        starts,
        frames: (options.first, options.last),
        radius: options.radius,
        hidden: options.hidden,
        overlay: options.overlay,
        out: Some(folder.clone()),
    };
    Ok(film::track(&request, None)?.summary(&folder))
}

/// A line a film: whether it was tracked, and what was lost where, and why.
fn outcome_table(films: &[(&PathBuf, Result<String>)]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let line = |(film, outcome): &(&PathBuf, Result<String>)| {
        let film = quoted(&film.display().to_string());
        match outcome {
            Ok(summary) => format!("{film},1,{},\n", quoted(summary)),
            Err(lost) => format!("{film},0,{},{}\n", quoted(&lost.what), quoted(&lost.why)),
        }
    };
    "film,tracked,what,why\n".to_owned() + &films.iter().map(line).collect::<String>()
}
