//! Markers tracked through a film by itself: no card says how many there are, and no trial when it begins.
//!
//! [`track()`] follows them and writes `tracks.csv`, `strip.png` and, when requested, `overlay.mp4` where a folder is given. A lost marker
//! ends it with a diagnostic and, in the folder, `lost.png`.

mod overlay;
mod tracks;

use std::fs;
use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use si::{Point2, Second};
use track::klt::{self, Tracker, TrackingError};
use track::scene::SceneCuts;
use track::video::{DecodedAhead, Frame, Info};

use crate::Interrupt;
use overlay::Overlay;
pub use tracks::Tracks;

/// Where the markers are in the first frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Starts {
    /// Near these places, px.
    At(Vec<Point2>),
    /// The most distinct dark spots, from left to right.
    Find {
        /// So many.
        count: usize,
        /// Left, top, right, bottom, px; the whole picture where none is given.
        region: Option<[f64; 4]>,
    },
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// H.264 in MP4, a folder of PNG or JPEG pictures with times.csv, or any format read by an ffmpeg on the PATH.
    pub film: PathBuf,
    /// The markers in the first frame.
    pub starts: Starts,
    /// First and last frame, from 0; the last of the film where none is given.
    pub frames: (usize, Option<usize>),
    /// Of the disc that holds a marker and a margin of light ground, px.
    pub radius: f64,
    /// Longest occlusion of a marker.
    pub hidden: Second,
    /// Whether the film with its tracks drawn over it is written too.
    pub overlay: bool,
    /// Folder for the results; nothing is written where none is given.
    pub out: Option<PathBuf>,
}

/// The folder of a film's results beside it.
pub fn beside(film: &Path) -> PathBuf {
    let mut name = film.file_name().unwrap_or_default().to_owned();
    name.push(".tracks");
    film.with_file_name(name)
}

/// Tracks markers through a film. `interrupt` is asked before every frame whether to end.
///
/// # Errors
/// A [`Diagnostic`] when the film cannot be read, its scene is cut, there is no marker at a start, one is lost, or it was interrupted.
pub fn track(request: &Request, interrupt: Interrupt<'_>) -> Result<Tracks> {
    let film = DecodedAhead::open(&request.film)?;
    let info = film.info();
    let mut run = Run::begin(request, info)?;
    for frame in film {
        let frame = frame?;
        if request.includes_frame(frame.index) {
            crate::check_interrupt(interrupt)?;
            run.process_frame(&frame)?;
        }
    }
    run.end(info)
}

impl Request {
    fn includes_frame(&self, frame: usize) -> bool {
        frame >= self.frames.0 && self.frames.1.is_none_or(|last| frame <= last)
    }

    fn tracker_settings(&self, rate: f64) -> klt::Settings {
        let patience = (self.hidden * rate).round().max(0.0) as usize;
        klt::Settings { radius: self.radius, patience, jump_limit: 40.0, ..klt::Settings::default() }
    }

    /// Where the markers are in the first frame, clicked or found.
    fn start_positions(&self, frame: &Frame, settings: &klt::Settings) -> Result<Vec<Point2>> {
        let (count, region) = match &self.starts {
            Starts::At(positions) => return Ok(positions.clone()),
            Starts::Find { count, region } => (*count, region),
        };
        let whole_picture = [0.0, 0.0, frame.gray.width as f64, frame.gray.height as f64];
        let blobs = klt::find_blobs(&frame.gray, region.unwrap_or(whole_picture), count, settings);
        if blobs.len() == count {
            return Ok(blobs);
        }
        Err(Diagnostic::new(
            format!("{} of {count} markers are found in the first frame of {}", blobs.len(), self.film.display()),
            format!("a marker is a dark spot within a disc of {} px with light ground around it", settings.radius),
            "narrow --region, set --radius to hold a marker and its margin, or click them with --at U,V",
        ))
    }

    /// A film of two scenes: markers of one are not those of the other.
    fn cut_diagnostic(&self, frame: &Frame) -> Diagnostic {
        let defect = format!("the scene is cut at frame {} ({:.3} s)", frame.index, frame.time);
        let reason = "it has nothing in common with the frame before, so that no marker can be followed";
        let previous = frame.index.saturating_sub(1);
        let action =
            format!("track the parts by themselves: --last {previous}, and --first {} with another --out", frame.index);
        Diagnostic::file(&self.film, defect, reason, action)
    }

    fn no_frame_diagnostic(&self, frames: usize) -> Diagnostic {
        let defect = format!("no frame is tracked from --first {}", self.frames.0);
        let last = self.frames.1.map_or(String::new(), |last| format!("; --last is {last}"));
        let reason = format!("the film has {frames} frames, from 0{last}");
        Diagnostic::file(&self.film, defect, reason, "correct --first or --last")
    }
}

/// Tracks up to the current frame, with what is written of them.
struct Run<'a> {
    request: &'a Request,
    settings: klt::Settings,
    cuts: SceneCuts,
    tracker: Option<Tracker>,
    tracks: Tracks,
    overlay: Option<Overlay>,
}

impl<'a> Run<'a> {
    fn begin(request: &'a Request, info: Info) -> Result<Self> {
        let begin = |folder: &PathBuf| {
            fs::create_dir_all(folder).map_err(|e| crate::cannot_write(folder, &e))?;
            Overlay::begin(folder, info, request.overlay)
        };
        let overlay = request.out.as_ref().map(begin).transpose()?;
        let (settings, tracks) = (request.tracker_settings(info.rate), Tracks::begin(request.frames.0));
        Ok(Self { request, settings, cuts: SceneCuts::default(), tracker: None, tracks, overlay })
    }

    fn process_frame(&mut self, frame: &Frame) -> Result<()> {
        if self.cuts.is_cut(&frame.gray) {
            return Err(self.request.cut_diagnostic(frame));
        }
        let observations = match &mut self.tracker {
            Some(tracker) => tracker.step(&frame.gray).map_err(|lost| lost_in(self.request, lost))?,
            None => self.first_observations(frame)?,
        };
        if let Some(overlay) = &mut self.overlay {
            overlay.draw_frame(&frame.gray, &observations)?;
        }
        self.tracks.push_frame(frame.time, observations);
        Ok(())
    }

    fn first_observations(&mut self, frame: &Frame) -> Result<Vec<klt::Observation>> {
        let starts = self.request.start_positions(frame, &self.settings)?;
        let tracker = Tracker::new(&frame.gray, &starts, self.settings).map_err(|lost| lost_in(self.request, lost))?;
        Ok(self.tracker.insert(tracker).observations().to_vec())
    }

    fn end(mut self, info: Info) -> Result<Tracks> {
        let tracker = self.tracker.ok_or_else(|| self.request.no_frame_diagnostic(info.frames))?;
        tracker.finish().map_err(|lost| lost_in(self.request, lost))?;
        self.tracks.markers.iter_mut().for_each(|track| klt::fill_gaps(track));
        if let (Some(overlay), Some(folder)) = (self.overlay, &self.request.out) {
            overlay.end()?;
            remove_results(folder, &["lost.png"]);
            crate::write_result(folder, "tracks.csv", self.tracks.to_csv())?;
        }
        Ok(self.tracks)
    }
}

/// Removes results of an earlier run: beside those of another run they would be taken for one.
fn remove_results(folder: &Path, names: &[&str]) {
    // What is not there needs not be removed.
    names.iter().for_each(|name| drop(fs::remove_file(folder.join(name))));
}

/// The diagnostic of a lost marker, its frame counted from the film's first, with its picture written.
fn lost_in(request: &Request, lost: TrackingError) -> Diagnostic {
    let lost = TrackingError { frame: lost.frame + request.frames.0, ..lost };
    let picture = request.out.as_ref().and_then(|folder| write_picture(folder, &lost));
    let diagnostic = Diagnostic::from(lost).in_file(&request.film);
    match picture {
        Some(path) => diagnostic.noting(format!("see: {}", path.display())),
        None => diagnostic,
    }
}

/// Where the picture of a lost marker was written.
fn write_picture(folder: &Path, lost: &TrackingError) -> Option<PathBuf> {
    remove_results(folder, &["tracks.csv", "strip.png", overlay::FILM]);
    let path = folder.join("lost.png");
    let png = lost.crop.to_png().ok()?;
    fs::write(&path, png).is_ok().then_some(path)
}
