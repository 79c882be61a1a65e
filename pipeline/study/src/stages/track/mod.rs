//! Track: positions of the markers of a film in pixels, with a covariance each. Paper: section IV, KLT.

mod search;

use std::path::Path as FilePath;

use lab::card::Led;
use serde::{Deserialize, Serialize};
use si::{Hertz, Point2, Second};
use track::imported::{self, ImportedTrack, Limits};
use track::klt::{self, Observation, Tracker};
use track::led;
use track::video::{DecodedAhead, Frame};

use diagnostics::{Diagnostic, Result};
use records::subject::Trial;
use records::{Path, Tracks};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Track;

/// `[track]` in `study.toml`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Radius of the disc that holds a whole marker with a margin of light ground, px.
    radius: f64,
    /// How far a clicked position may lie from the marker's centre, px.
    click_radius: f64,
    /// Least difference between ground and marker, grey levels.
    contrast_limit: f64,
    /// Largest mean difference from the marker of the first frame, grey levels a pixel.
    residual_limit: f64,
    /// Largest step between two frames, of a marker by itself or against its neighbour, px.
    jump_limit: f64,
    /// Largest distance between flow and centroid, px.
    flow_centroid_limit: f64,
    /// Largest forward-backward error of the flow, px.
    forward_backward_limit: f64,
    /// Largest change of the distance between neighbouring markers from frame to frame, as a share of it.
    neighbour_distance_limit: f64,
    /// Least correlation with its first view at which an occluded marker is accepted again, no unit.
    correlation_limit: f64,
    /// Longest occlusion of a marker, s.
    longest_occlusion: Second,
    /// Quantiser of the films' H.264, which determines the error of small motions; 0 for uncompressed pictures.
    quantiser: u8,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    pub(super) markers: Vec<Clicked>,
    /// None where nothing was filmed.
    led: Option<Led>,
    pub(super) search: Option<lab::card::Search>,
    /// Tracks of another program or instrument.
    pub(super) elsewhere: Option<Elsewhere>,
    pub(super) first_frame: usize,
    last_frame: Option<usize>,
}

/// A marker, and where it was clicked in the first frame, px.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Clicked {
    pub(super) name: String,
    pub(super) clicked: Option<Point2>,
}

/// Imported tracks.
#[derive(Debug, Clone, Serialize)]
pub(super) enum Elsewhere {
    /// In the film's own pixels, with their standard deviation, px.
    Pixels(f64),
    /// In space, without a camera model.
    Space,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        let elsewhere = |tracks: &lab::card::Tracks| match tracks.space {
            None => Elsewhere::Pixels(tracks.sigma),
            Some(_) => Elsewhere::Space,
        };
        let clicked = |m: &lab::card::Marker| Clicked { name: m.name.clone(), clicked: m.clicked };
        Self {
            markers: of.card.marker.iter().map(clicked).collect(),
            led: of.card.led.clone(),
            search: of.card.search.clone(),
            elsewhere: of.made_elsewhere().map(elsewhere),
            first_frame: of.trial.first_frame,
            last_frame: of.trial.last_frame,
        }
    }
}

impl Stage for Track {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = Tracks;
    const DESCRIPTION: &'static str = "markers are tracked in pixels";
    const VERSION: u32 = 7;

    fn raw(of: &Trial) -> Vec<RawFile> {
        let foreign = in_pixels(of).map(|tracks| RawFile::new("tracks", &of.card.name, &tracks.file));
        of.film().into_iter().chain(foreign).collect()
    }

    fn run(card: &Self::Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<Tracks> {
        let film = DecodedAhead::open(&context.path("video")?)?;
        let info = film.info();
        let length = info.frames.max(1) as f64;
        let mut log = Log::new(card, set.tracker(info.rate));
        for frame in film {
            let frame = frame?;
            if card.last_frame.is_some_and(|last| frame.index > last) {
                break;
            }
            if frame.index >= card.first_frame {
                log.add_frame(&frame, context)?;
                context.progress(frame.index as f64 / length, "tracking the markers");
            }
        }
        if log.tracks.time.is_empty() {
            return Err(no_frames(card, context));
        }
        let tracks = log.finished_tracks().map_err(|lost| tracking_failure(card, context, lost))?;
        match card.elsewhere {
            None => Ok(tracks),
            _ => imported_paths(card, set.tracker(info.rate), tracks.time.len(), context)
                .map(|markers| Tracks { markers, ..tracks }),
        }
    }
}

/// The positions of all markers in one frame, px, when each passes the checks of a first frame; `set` is of [`Settings::tracker`].
///
/// # Errors
/// A [`Diagnostic`] that names the first marker that does not, or gives the number found.
pub fn first_look(card: &Card, set: klt::Settings, frame: &Frame, context: &dyn StageContext) -> Result<Vec<Point2>> {
    let tracker = first_tracker(card, set, frame, context)?;
    Ok(tracker.observations().iter().map(|observation| observation.at).collect())
}

/// The tracker of a trial on its first frame.
fn first_tracker(card: &Card, set: klt::Settings, frame: &Frame, context: &dyn StageContext) -> Result<Tracker> {
    let starts = search::initial_positions(card, &frame.gray, &set, &context.display_path("video"))?;
    Tracker::new(&frame.gray, &starts, set).map_err(|lost| tracking_failure(card, context, lost))
}

/// Imported tracks in the film's own pixels.
fn in_pixels(trial: &Trial) -> Option<&lab::card::Tracks> {
    trial.made_elsewhere().filter(|tracks| tracks.space.is_none())
}

/// The imported tracks of a film of so many frames and this rate, as the card names them.
///
/// # Errors
/// A [`Diagnostic`] when they cannot be read, or a marker moves as none of this tracker may.
pub fn imported_paths(card: &Card, set: klt::Settings, frames: usize, context: &dyn StageContext) -> Result<Vec<Path>> {
    let Some(Elsewhere::Pixels(sigma)) = card.elsewhere else { return Ok(Vec::new()) };
    let tracks_path = context.display_path("tracks");
    let in_file = |refused: Diagnostic| refused.in_file(FilePath::new(&tracks_path));
    let names: Vec<String> = card.markers.iter().map(|m| m.name.clone()).collect();
    let read = lab::pixels::read(&context.bytes("tracks")?, &names, frames, sigma).map_err(in_file)?;
    // length: a covariance for each place
    let places = |t: &lab::pixels::PixelTrack| t.at.clone().into_iter().zip(t.covariance.clone());
    let mut tracks: Vec<_> = read.iter().map(|t| ImportedTrack::new(&t.name, places(t))).collect();
    imported::check_tracks(&mut tracks, &Limits::from_settings(&set)).map_err(|e| in_file(e.into()))?;
    Ok(tracks.iter().map(Path::from_import).collect())
}

/// Tracks up to the current frame.
struct Log<'a> {
    card: &'a Card,
    set: klt::Settings,
    tracker: Option<Tracker>,
    tracks: Tracks,
    /// Markers × frames.
    seen: Vec<Vec<Observation>>,
}

impl<'a> Log<'a> {
    fn new(card: &'a Card, set: klt::Settings) -> Self {
        let tracks = Tracks { time: Vec::new(), led: Vec::new(), worst_residual: 0.0, markers: Vec::new() };
        Self { card, set, tracker: None, tracks, seen: vec![Vec::new(); card.markers.len()] }
    }

    fn add_frame(&mut self, frame: &Frame, context: &dyn StageContext) -> Result<()> {
        let card = self.card;
        let observations = match &mut self.tracker {
            Some(tracker) => tracker.step(&frame.gray).map_err(|lost| tracking_failure(card, context, lost))?,
            None => {
                let tracker = first_tracker(card, self.set, frame, context)?;
                let first = tracker.observations().to_vec();
                self.tracker = Some(tracker);
                first
            }
        };
        let brightness = |lamp: &Led| led::brightness(&frame.gray, lamp.centre, lamp.radius);
        self.tracks.time.push(frame.time);
        self.tracks.led.push(card.led.as_ref().map_or(0.0, brightness));
        self.seen.iter_mut().zip(observations).for_each(|(track, observation)| track.push(observation));
        Ok(())
    }

    /// The finished tracks, with gaps filled.
    fn finished_tracks(self) -> Result<Tracks, klt::TrackingError> {
        self.tracker.map_or(Ok(()), Tracker::finish)?;
        let mut tracks = self.tracks;
        if self.card.elsewhere.is_some() {
            return Ok(tracks);
        }
        for (marker, mut seen) in self.card.markers.iter().zip(self.seen) {
            klt::fill_gaps(&mut seen);
            let spread = |s: &Observation| [s.covariance[0][0], s.covariance[0][1], s.covariance[1][1]];
            tracks.worst_residual = seen.iter().map(|s| s.residual).fold(tracks.worst_residual, f64::max);
            let (at, spread) = seen.iter().map(|s| (s.at, spread(s))).unzip();
            tracks.markers.push(Path { name: marker.name.clone(), at, spread });
        }
        Ok(tracks)
    }
}

impl Settings {
    /// Radius of a marker's window, px.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Settings of the tracker for a film of this rate.
    pub fn tracker(&self, rate: Hertz) -> klt::Settings {
        klt::Settings {
            radius: self.radius,
            click_radius: self.click_radius,
            contrast_limit: self.contrast_limit,
            residual_limit: self.residual_limit,
            jump_limit: self.jump_limit,
            flow_centroid_limit: self.flow_centroid_limit,
            forward_backward_limit: self.forward_backward_limit,
            neighbour_distance_limit: self.neighbour_distance_limit,
            correlation_limit: self.correlation_limit,
            quantiser: self.quantiser,
            patience: (self.longest_occlusion * rate).round() as usize,
        }
    }
}

fn tracking_failure(card: &Card, context: &dyn StageContext, lost: klt::TrackingError) -> Diagnostic {
    let name = card.markers.get(lost.marker).map_or("?", |m| m.name.as_str());
    let (marker_place, picture) = (format!("{}, marker `{name}`", context.display_path("video")), lost.crop.to_png());
    let diagnostic = Diagnostic::from(lost).while_doing(marker_place);
    match picture {
        Ok(png) => diagnostic.showing(png),
        Err(_) => diagnostic,
    }
}

fn no_frames(card: &Card, context: &dyn StageContext) -> Diagnostic {
    Diagnostic::new(
        format!("{} has no frame to use", context.display_path("video")),
        format!("the card lets the trial begin at frame {}", card.first_frame),
        "correct first_frame and last_frame of this trial on the card",
    )
}
