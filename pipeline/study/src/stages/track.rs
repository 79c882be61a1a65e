//! Track: a film becomes the markers' places in pixels, with a covariance each. Paper: section IV, KLT.
//!
//! Stands on: track. Never knows: metres.

mod foreign;
mod search;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Hertz, Point2, Second};
use track::klt::{self, Sighting, Tracker};
use track::led;
use track::video::Frame;

use crate::fault::{Fault, Outcome};
use crate::records::{Path, Tracks};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Trial;

/// The stage.
pub struct Track;

/// `[track]` in `study.toml`.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Radius of the disc that holds a whole marker with a margin of light ground, px.
    radius: f64,
    /// How far a clicked position may lie from the marker's centre, px.
    reach: f64,
    /// Least difference between ground and marker, grey levels.
    contrast_limit: f64,
    /// Largest mean difference from the marker of the first frame, grey levels a pixel.
    residual_limit: f64,
    /// Largest step between two frames, px.
    jump_limit: f64,
    /// Largest distance between flow and centroid, px.
    agreement_limit: f64,
    /// Largest distance from its start at which flow there and back may end, px.
    return_limit: f64,
    /// Largest change of the distance between neighbouring markers from frame to frame, as a share of it.
    company_limit: f64,
    /// Least correlation with its first view at which a hidden marker is found again, no unit.
    likeness_limit: f64,
    /// How long a marker may be hidden, s.
    hidden_limit: Second,
    /// Quantiser of the films' H.264, which tells how much of a small motion they leave out; 0 for uncoded pictures.
    quantiser: u8,
}

impl Stage for Track {
    type Settings = Settings;
    type Needs = ();
    type Makes = Tracks;
    const STORY: &'static str = "a film becomes the markers' places in pixels";
    const EDITION: u32 = 4;

    fn raw(of: &Trial) -> Vec<RawFile> {
        let foreign = in_pixels(of).map(|tracks| RawFile::new("tracks", &of.card.name, &tracks.file));
        std::iter::once(RawFile::new("video", &of.card.name, &of.trial.video)).chain(foreign).collect()
    }

    fn card(of: &Trial) -> Value {
        json!({
            "markers": of.card.marker.iter().map(|m| json!([m.name, m.clicked])).collect::<Vec<_>>(),
            "led": [of.card.led.centre[0], of.card.led.centre[1], of.card.led.radius],
            "search": of.card.search.as_ref().map(|s| json!([s.region, s.order.word(), s.by.word()])),
            "foreign": in_pixels(of).map(|tracks| tracks.sigma),
            "in_space": of.in_space().is_some(),
            "frames": [Some(of.trial.first_frame), of.trial.last_frame],
        })
    }

    fn run(of: &Trial, set: &Settings, (): (), desk: &dyn Desk) -> Outcome<Tracks> {
        let film = desk.film("video")?;
        let info = film.info();
        let length = info.frames.max(1) as f64;
        let mut log = Log::new(of, set.tracker(info.rate));
        for frame in film {
            let frame = frame.map_err(Fault::from_tool)?;
            if of.trial.last_frame.is_some_and(|last| frame.index > last) {
                break;
            }
            if frame.index >= of.trial.first_frame {
                log.see(&frame, desk)?;
                desk.progress(frame.index as f64 / length, "following the markers");
            }
        }
        if log.tracks.time.is_empty() {
            return Err(no_frames(of, desk));
        }
        let tracks = log.end().map_err(|lost| named(of, desk, &lost))?;
        match in_pixels(of) {
            Some(foreign) => taken(of, foreign, tracks, desk),
            None => Ok(tracks),
        }
    }
}

/// Looks at one frame alone: where every marker is, px, when each passes the gates with which a film is begun.
///
/// # Errors
/// A [`Fault`] that names the first marker that does not, or says how many were found.
pub(crate) fn first_look(
    of: &Trial,
    set: &Settings,
    frame: &Frame,
    rate: Hertz,
    desk: &dyn Desk,
) -> Outcome<Vec<Point2>> {
    let tracker = begin(of, set.tracker(rate), frame, desk)?;
    Ok(tracker.sightings().iter().map(|sighting| sighting.at).collect())
}

/// The tracker of a trial on its first frame.
fn begin(of: &Trial, set: klt::Settings, frame: &Frame, desk: &dyn Desk) -> Outcome<Tracker> {
    let starts = search::starts(of, &frame.gray, &set, &desk.place("video"))?;
    Tracker::new(&frame.gray, &starts, set).map_err(|lost| named(of, desk, &lost))
}

/// Tracks in the film's own pixels that another program made of it.
fn in_pixels(of: &Trial) -> Option<&lab::card::Tracks> {
    of.made_elsewhere().filter(|tracks| tracks.space.is_none())
}

/// The lamp and times of a film with the tracks that were made elsewhere.
fn taken(of: &Trial, foreign: &lab::card::Tracks, tracks: Tracks, desk: &dyn Desk) -> Outcome<Tracks> {
    let place = desk.place("tracks");
    let told = |e: String| Fault::from_tool(format!("{place}: {e}"));
    let text = String::from_utf8(desk.bytes("tracks")?).map_err(|e| told(format!("it is not text: {e}")))?;
    let names: Vec<String> = of.card.marker.iter().map(|m| m.name.clone()).collect();
    let markers = foreign::read(&text, &names, tracks.time.len(), foreign.sigma).map_err(told)?;
    Ok(Tracks { markers, ..tracks })
}

/// What has been seen so far.
struct Log<'a> {
    of: &'a Trial,
    set: klt::Settings,
    tracker: Option<Tracker>,
    tracks: Tracks,
    /// Markers × frames.
    seen: Vec<Vec<Sighting>>,
}

impl<'a> Log<'a> {
    fn new(of: &'a Trial, set: klt::Settings) -> Self {
        let tracks = Tracks { time: Vec::new(), led: Vec::new(), worst_residual: 0.0, markers: Vec::new() };
        Self { of, set, tracker: None, tracks, seen: vec![Vec::new(); of.card.marker.len()] }
    }

    fn see(&mut self, frame: &Frame, desk: &dyn Desk) -> Outcome<()> {
        let of = self.of;
        let sightings = match &mut self.tracker {
            Some(tracker) => tracker.step(&frame.gray).map_err(|lost| named(of, desk, &lost))?,
            None => {
                let tracker = begin(of, self.set, frame, desk)?;
                let first = tracker.sightings().to_vec();
                self.tracker = Some(tracker);
                first
            }
        };
        let lamp = &self.of.card.led;
        self.tracks.time.push(frame.time);
        self.tracks.led.push(led::brightness(&frame.gray, lamp.centre, lamp.radius));
        self.seen.iter_mut().zip(sightings).for_each(|(track, sighting)| track.push(sighting));
        Ok(())
    }

    /// Everything that was seen, gaps filled.
    fn end(self) -> Result<Tracks, klt::Lost> {
        self.tracker.map_or(Ok(()), Tracker::finish)?;
        let mut tracks = self.tracks;
        if self.of.made_elsewhere().is_some() {
            return Ok(tracks);
        }
        for (marker, mut seen) in self.of.card.marker.iter().zip(self.seen) {
            klt::fill(&mut seen);
            let spread = |s: &Sighting| [s.covariance[0][0], s.covariance[0][1], s.covariance[1][1]];
            tracks.worst_residual = seen.iter().map(|s| s.residual).fold(tracks.worst_residual, f64::max);
            let (at, spread) = seen.iter().map(|s| (s.at, spread(s))).unzip();
            tracks.markers.push(Path { name: marker.name.clone(), at, spread });
        }
        Ok(tracks)
    }
}

impl Settings {
    /// Radius of a marker's window, px.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// What the tracker expects in a film of this rate.
    pub fn tracker(&self, rate: Hertz) -> klt::Settings {
        klt::Settings {
            radius: self.radius,
            reach: self.reach,
            contrast_limit: self.contrast_limit,
            residual_limit: self.residual_limit,
            jump_limit: self.jump_limit,
            agreement_limit: self.agreement_limit,
            return_limit: self.return_limit,
            company_limit: self.company_limit,
            likeness_limit: self.likeness_limit,
            quantiser: self.quantiser,
            patience: (self.hidden_limit * rate).round() as usize,
        }
    }
}

fn named(of: &Trial, desk: &dyn Desk, lost: &klt::Lost) -> Fault {
    let name = of.card.marker.get(lost.marker).map_or("?", |m| m.name.as_str());
    let fault = Fault::from_tool(format!("{}, marker `{name}`: {lost}", desk.place("video")));
    match lost.crop.to_png() {
        Ok(png) => fault.showing(png),
        Err(_) => fault,
    }
}

fn no_frames(of: &Trial, desk: &dyn Desk) -> Fault {
    Fault::new(
        format!("{} has no frame to use", desk.place("video")),
        format!("the card lets the trial begin at frame {}", of.trial.first_frame),
        "correct first_frame and last_frame of this trial on the card",
    )
}
