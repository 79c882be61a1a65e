//! `study track`: tracks markers in any film, or in many, without a project.
//!
//! Writes `<film>.tracks/` beside the film with `tracks.csv`, `strip.png` and, when requested, `overlay.mp4`. A lost marker
//! ends it with a diagnostic and `lost.png`.

mod overlay;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use si::{Point2, Second};
use track::klt::{self, Observation, Tracker, TrackingError};
use track::scene::SceneCuts;
use track::video::{DecodedAhead, Frame};

use crate::options::TrackFilm;
use diagnostics::{Diagnostic, Result};
use overlay::Overlay;

/// One of the films, with the options of all.
struct OneFilm<'a> {
    film: &'a Path,
    out: Option<PathBuf>,
    all: &'a TrackFilm,
}

impl std::ops::Deref for OneFilm<'_> {
    type Target = TrackFilm;

    fn deref(&self) -> &TrackFilm {
        self.all
    }
}

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
        let summary = tracked(&OneFilm { film, out: asked.out.clone(), all: asked })?;
        return Ok(Tracked { summary, complete: true });
    }
    let out = |film: &Path| {
        let mut name = film.file_name().unwrap_or_default().to_owned();
        name.push(".tracks");
        asked.out.as_ref().map(|folder| folder.join(name))
    };
    let one = |film: &PathBuf| tracked(&OneFilm { film, out: out(film), all: asked });
    let all: Vec<(&PathBuf, Result<String>)> = asked.films.iter().map(|film| (film, one(film))).collect();
    let beside = asked.films[0].parent().unwrap_or(Path::new("")).to_owned();
    let table = asked.out.clone().unwrap_or(beside).join("tracked.csv");
    write(&table, outcomes(&all).as_bytes())?;
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

/// Tracks one film; returns a summary line.
fn tracked(asked: &OneFilm) -> Result<String> {
    let film = DecodedAhead::open(asked.film)?;
    let info = film.info();
    let patience = (asked.hidden * info.rate).round().max(0.0) as usize;
    let set = klt::Settings { radius: asked.radius, patience, jump_limit: 40.0, ..klt::Settings::default() };
    let folder = folder(asked);
    fs::create_dir_all(&folder).map_err(|e| cannot_write(&folder, &e))?;
    let mut seen = Seen { asked, folder: &folder, tracker: None, time: Vec::new(), tracks: Vec::new() };
    let mut overlay = Overlay::begin(&folder, info, asked.overlay)?;
    let mut cuts = SceneCuts::default();
    for frame in film {
        let frame = frame?;
        if frame.index < asked.first || asked.last.is_some_and(|last| frame.index > last) {
            continue;
        }
        if cuts.is_cut(&frame.gray) {
            return Err(cut(asked, &frame));
        }
        seen.look(&frame, set)?;
        overlay.frame(&frame.gray, seen.tracks.iter().filter_map(|t| t.last()))?;
    }
    if seen.tracker.is_none() {
        return Err(nothing(asked, info.frames));
    }
    let (time, tracks) = seen.end()?;
    overlay.end()?;
    remove(&folder, &["lost.png"]);
    write(&folder.join("tracks.csv"), csv(asked.first, &time, &tracks).as_bytes())?;
    let hidden = tracks.iter().flatten().filter(|s| !s.seen).count();
    let (markers, frames) = (tracks.len(), time.len());
    Ok(format!("{markers} markers × {frames} frames, occluded in {hidden}; results in {}", folder.display()))
}

/// A film of two scenes: markers of one are not those of the other.
fn cut(asked: &OneFilm, frame: &Frame) -> Diagnostic {
    let what = format!("the scene is cut at frame {} ({:.3} s)", frame.index, frame.time);
    let why = "it has nothing in common with the frame before, so that no marker can be followed";
    let before = frame.index.saturating_sub(1);
    let action =
        format!("track the parts by themselves: --last {before}, and --first {} with another --out", frame.index);
    Diagnostic::file(asked.film, what, why, action)
}

fn nothing(asked: &OneFilm, frames: usize) -> Diagnostic {
    let what = format!("no frame is tracked from --first {}", asked.first);
    let last = asked.last.map_or(String::new(), |last| format!("; --last is {last}"));
    Diagnostic::file(
        asked.film,
        what,
        format!("the film has {frames} frames, from 0{last}"),
        "correct --first or --last",
    )
}

fn folder(asked: &OneFilm) -> PathBuf {
    let mut name = asked.film.file_name().unwrap_or_default().to_owned();
    name.push(".tracks");
    asked.out.clone().unwrap_or_else(|| asked.film.with_file_name(name))
}

/// Tracks up to the current frame.
struct Seen<'a> {
    asked: &'a OneFilm<'a>,
    folder: &'a Path,
    tracker: Option<Tracker>,
    time: Vec<Second>,
    /// Markers × frames.
    tracks: Vec<Vec<Observation>>,
}

impl Seen<'_> {
    fn look(&mut self, frame: &Frame, set: klt::Settings) -> Result<()> {
        let (asked, folder) = (self.asked, self.folder);
        let lost = |lost: TrackingError| shown(folder, counted(lost, asked.first)).in_file(asked.film);
        let sightings = match &mut self.tracker {
            Some(tracker) => tracker.step(&frame.gray).map_err(lost)?,
            None => {
                let tracker = Tracker::new(&frame.gray, &starts(frame, asked, &set)?, set).map_err(lost)?;
                let first = tracker.observations().to_vec();
                self.tracks = vec![Vec::new(); first.len()];
                self.tracker = Some(tracker);
                first
            }
        };
        self.time.push(frame.time);
        self.tracks.iter_mut().zip(sightings).for_each(|(track, sighting)| track.push(sighting));
        Ok(())
    }

    fn end(mut self) -> Result<(Vec<Second>, Vec<Vec<Observation>>)> {
        let (folder, asked) = (self.folder, self.asked);
        let lost = |lost: TrackingError| shown(folder, counted(lost, asked.first)).in_file(asked.film);
        self.tracker.map_or(Ok(()), Tracker::finish).map_err(lost)?;
        self.tracks.iter_mut().for_each(|track| klt::fill_gaps(track));
        Ok((self.time, self.tracks))
    }
}

/// Where the markers are in the first frame, clicked or found.
fn starts(frame: &Frame, asked: &OneFilm, set: &klt::Settings) -> Result<Vec<Point2>> {
    let Some(count) = asked.find else { return Ok(asked.at.clone()) };
    let whole = [0.0, 0.0, frame.gray.width as f64, frame.gray.height as f64];
    let found = klt::find_blobs(&frame.gray, asked.region.unwrap_or(whole), count, set);
    if found.len() == count {
        return Ok(found);
    }
    Err(Diagnostic::new(
        format!("{} of {count} markers are found in the first frame of {}", found.len(), asked.film.display()),
        format!("a marker is a dark spot within a disc of {} px with light ground around it", set.radius),
        "narrow --region, set --radius to hold a marker and its margin, or click them with --at U,V",
    ))
}

/// One line a frame and marker.
fn csv(first: usize, time: &[Second], tracks: &[Vec<Observation>]) -> String {
    let mut text = String::from("frame,time_s,marker,u_px,v_px,uu_px2,uv_px2,vv_px2,residual,seen\n");
    for (frame, t) in time.iter().enumerate() {
        for (marker, track) in tracks.iter().enumerate() {
            let s = &track[frame];
            let ([u, v], [[uu, uv], [_, vv]]) = (s.at, s.covariance);
            let (frame, name, seen) = (first + frame, marker + 1, u8::from(s.seen));
            let line = format_args!(
                "{frame},{t:.6},m{name},{u:.4},{v:.4},{uu:.3e},{uv:.3e},{vv:.3e},{:.2},{seen}",
                s.residual
            );
            writeln!(text, "{line}").expect("a string takes any text");
        }
    }
    text
}

/// Removes results of an earlier run: beside those of another run they would be taken for one.
fn remove(folder: &Path, names: &[&str]) {
    // What is not there needs not be removed.
    names.iter().for_each(|name| drop(fs::remove_file(folder.join(name))));
}

/// The same error with its frame counted from the film's first.
fn counted(lost: TrackingError, first: usize) -> TrackingError {
    TrackingError { frame: lost.frame + first, ..lost }
}

/// The diagnostic of a lost marker, with its picture written.
fn shown(folder: &Path, lost: TrackingError) -> Diagnostic {
    let path = folder.join("lost.png");
    remove(folder, &["tracks.csv", "strip.png", overlay::FILM]);
    let written = lost.crop.to_png().is_ok_and(|png| fs::write(&path, png).is_ok());
    let diagnostic = Diagnostic::from(lost);
    if written { diagnostic.noting(format!("see: {}", path.display())) } else { diagnostic }
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).map_err(|e| cannot_write(path, &e))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::new(format!("{} cannot be written", path.display()), error, "choose another folder with --out")
}
