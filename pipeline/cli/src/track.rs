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
pub fn run(asked: &TrackFilm) -> Result<Tracked> {
    if let [film] = &asked.films[..] {
        let folder = asked.out.clone().unwrap_or_else(|| film::beside(film));
        return Ok(Tracked { summary: tracked(asked, film, folder)?, complete: true });
    }
    let one = |film: &PathBuf| tracked(asked, film, folder_of_many(asked, film));
    let all: Vec<(&PathBuf, Result<String>)> = asked.films.iter().map(|film| (film, one(film))).collect();
    let beside = asked.films[0].parent().unwrap_or(Path::new("")).to_owned();
    let table = asked.out.clone().unwrap_or(beside).join("tracked.csv");
    std::fs::write(&table, outcomes(&all))
        .map_err(|e| Diagnostic::io(&table, e, "choose another folder with --out"))?;
    let line = |(film, outcome): &(&PathBuf, Result<String>)| match outcome {
        Ok(summary) => format!("{}: {summary}\n", film.display()),
        Err(lost) => format!("{}: error: {lost}\n", film.display()),
    };
    let lost = all.iter().filter(|(_, outcome)| outcome.is_err()).count();
    let summary: String = all.iter().map(line).collect();
    let count = all.len();
    let summary = format!("{summary}{count} films, {lost} not tracked to their end; table: {}", table.display());
    Ok(Tracked { summary, complete: lost == 0 })
}

/// The folder of one of many films: in `--out`, or beside it.
fn folder_of_many(asked: &TrackFilm, film: &Path) -> PathBuf {
    let beside = film::beside(film);
    match (&asked.out, beside.file_name()) {
        (Some(out), Some(name)) => out.join(name),
        _ => beside,
    }
}

/// Tracks one film; returns a summary line.
fn tracked(asked: &TrackFilm, film: &Path, folder: PathBuf) -> Result<String> {
    let starts = match asked.find {
        Some(count) => Starts::Find { count, region: asked.region },
        None => Starts::At(asked.at.clone()),
    };
    let request = Request {
        film: film.to_owned(),
        starts,
        frames: (asked.first, asked.last),
        radius: asked.radius,
        hidden: asked.hidden,
        overlay: asked.overlay,
        out: Some(folder.clone()),
    };
    Ok(film::track(&request, None)?.summary(&folder))
}

/// A line a film: whether it was tracked, and what was lost where, and why.
fn outcomes(all: &[(&PathBuf, Result<String>)]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let line = |(film, outcome): &(&PathBuf, Result<String>)| {
        let film = quoted(&film.display().to_string());
        match outcome {
            Ok(summary) => format!("{film},1,{},\n", quoted(summary)),
            Err(lost) => format!("{film},0,{},{}\n", quoted(&lost.what), quoted(&lost.why)),
        }
    };
    "film,tracked,what,why\n".to_owned() + &all.iter().map(line).collect::<String>()
}
