//! Markers through a film: dark crosses or discs on a light ground, to a hundredth of a pixel, never lost in silence.
//!
//! Optical flow says where a marker went, and must lead back to where it came from; the centroid of its darkness then says
//! where it is, without a memory that could drift. The two must agree, and the marker must still look as it did in the first
//! frame. A marker that something covers is looked for again by how it looked, for as long as the settings are patient; what
//! stays hidden is an error with its first hidden frame.
//!
//! Stands on: kornia's pyramidal flow, grey pictures. Never knows: which material point a marker is. Paper: section IV.

pub(crate) mod blob;
mod company;
mod corners;
mod find;
mod flow;
mod gaps;
mod gates;
mod ground;
mod lane;
mod lost;
mod scatter;
mod search;
mod settings;
mod template;

use crate::Gray;
pub use blob::beside;
pub use corners::corners;
pub use find::find;
pub use gaps::fill;
use gates::sum;
use lane::Lane;
pub use lost::{Lost, Why};
pub use settings::Settings;
use si::{Point2, Radian};
use template::Template;

/// One marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Its centre, px.
    pub at: Point2,
    /// Covariance of its centre, px².
    pub covariance: [[f64; 2]; 2],
    /// Mean difference from the marker of the first frame, grey levels a pixel.
    pub residual: f64,
    /// False while the marker is hidden: the rest then tells where it was seen last, and waits for [`fill`].
    pub seen: bool,
}

/// Follows markers from frame to frame.
pub struct Tracker {
    settings: Settings,
    before: Gray,
    frame: usize,
    tracks: Vec<Track>,
    sightings: Vec<Sighting>,
    lane: Lane,
}

/// What is remembered of one marker.
struct Track {
    template: Template,
    at: Point2,
    step: Point2,
    turn: Radian,
    /// Covariance of late, px², once there was a second frame.
    scatter: Option<[[f64; 2]; 2]>,
    /// Why and since which frame it is hidden.
    hidden: Option<Lost>,
}

/// One marker in the next frame, past all gates.
struct Seen {
    sighting: Sighting,
    turn: Radian,
    scatter: [[f64; 2]; 2],
}

/// The least radius of a window, px.
pub const LEAST_RADIUS: f64 = 4.0;

impl Tracker {
    /// Begins with the first frame: each clicked position (px) is moved to the middle of the dark spot within reach.
    ///
    /// # Errors
    /// [`Lost`] at frame 0 when there is no dark spot within reach.
    ///
    /// # Panics
    /// When the window's radius is under [`LEAST_RADIUS`]: no marker and its ground fit into that.
    pub fn new(first: &Gray, clicked: &[Point2], settings: Settings) -> Result<Self, Lost> {
        assert!(settings.radius >= LEAST_RADIUS, "a window of radius {} px holds no marker", settings.radius);
        let (tracks, sightings, lane) = (Vec::new(), Vec::new(), Lane::new());
        let mut new = Self { settings, before: first.clone(), frame: 0, tracks, sightings, lane };
        for (marker, &near) in clicked.iter().enumerate() {
            let lost = |why| Lost::at(first, marker, 0, near, why);
            let blob = new.spot(first, near).map_err(lost)?;
            let away = distance(blob.at, near);
            if away > settings.reach {
                return Err(lost(Why::Far { measured: away, limit: settings.reach }));
            }
            let template = Template::cut(first, &blob, settings.radius);
            let coded = scatter::at_least([[0.0; 2]; 2], scatter::of_codec(&blob, settings.quantiser));
            let covariance = sum(coded, scatter::of_pixels(&blob));
            let sighting = Sighting { at: blob.at, covariance, residual: 0.0, seen: true };
            let (at, step, hidden) = (blob.at, [0.0; 2], None);
            new.tracks.push(Track { template, at, step, turn: 0.0, scatter: None, hidden });
            new.sightings.push(sighting);
        }
        new.apart()?;
        Ok(new)
    }

    /// Where the markers are in the frame that was looked at last.
    pub fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// Looks at the next frame; one sighting a marker, in the order of the clicks.
    ///
    /// # Errors
    /// [`Lost`] when a marker fails a gate for longer than the settings are patient, with the first frame in which it did.
    pub fn step(&mut self, picture: &Gray) -> Result<Vec<Sighting>, Lost> {
        let frame = self.frame + 1;
        let mut found = self.lane.run(|| self.look(picture, frame));
        self.part(picture, frame, &mut found);
        self.keep_company(picture, frame, &mut found);
        self.retry(picture, &mut found);
        for (track, found) in self.tracks.iter().zip(&found) {
            let Err(lost) = found else { continue };
            let since = track.hidden.as_ref().unwrap_or(lost);
            if frame - since.frame >= self.settings.patience {
                return Err(since.clone());
            }
        }
        self.frame = frame;
        let pairs = self.tracks.iter_mut().zip(&mut self.sightings);
        pairs.zip(found).for_each(|((track, sighting), found)| track.take(frame, found, sighting));
        self.before.clone_from(picture);
        self.apart()?;
        Ok(self.sightings.clone())
    }

    /// Every marker by itself, past its own gates.
    fn look(&self, picture: &Gray, frame: usize) -> Vec<Result<Seen, Lost>> {
        let look = |(marker, track): (usize, &Track)| {
            let near = track.expected();
            let seen = match &track.hidden {
                None => self.sight(picture, track, near),
                Some(since) => self.sight_again(picture, marker, track, frame - since.frame),
            };
            seen.map_err(|why| Lost::at(picture, marker, frame, near, why))
        };
        self.tracks.iter().enumerate().map(look).collect()
    }

    /// Ends the film.
    ///
    /// # Errors
    /// [`Lost`] when a marker is hidden to its end.
    pub fn finish(self) -> Result<(), Lost> {
        self.tracks.into_iter().find_map(|track| track.hidden).map_or(Ok(()), Err)
    }
}

impl Track {
    /// Where it is expected in the next frame, px.
    fn expected(&self) -> Point2 {
        [self.at[0] + self.step[0], self.at[1] + self.step[1]]
    }

    /// Takes in what a frame showed of it.
    fn take(&mut self, frame: usize, found: Result<Seen, Lost>, sighting: &mut Sighting) {
        match found {
            Ok(seen) => {
                let at = seen.sighting.at;
                let frames = self.hidden.take().map_or(1, |since| frame - since.frame + 1) as f64;
                self.step = [0, 1].map(|k| (at[k] - self.at[k]) / frames);
                (self.at, self.turn, self.scatter) = (at, seen.turn, Some(seen.scatter));
                *sighting = seen.sighting;
            }
            Err(lost) => {
                self.hidden.get_or_insert(lost);
                sighting.seen = false;
            }
        }
    }
}

fn distance(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
