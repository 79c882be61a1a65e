//! Markers through a film: dark crosses or discs on a light ground, to a hundredth of a pixel, never lost in silence.
//!
//! Optical flow says where a marker went; the centroid of its darkness then says where it is, without a memory that could
//! drift. The two must agree, and the marker must still look as it did in the first frame.
//!
//! Stands on: kornia's pyramidal flow, grey pictures. Never knows: which material point a marker is. Paper: section IV.

mod blob;
mod flow;
mod ground;
mod lost;
mod scatter;
mod template;

use crate::Gray;
use blob::{Blob, Miss};
pub use lost::{Lost, Why};
use si::{Point2, Radian};
use template::Template;

/// What the tracker expects of markers and what it refuses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Radius of the disc that holds a whole marker with a margin of light ground, px.
    pub radius: f64,
    /// How far a clicked position may lie from the marker's centre, px.
    pub reach: f64,
    /// Least difference between ground and marker, grey levels.
    pub contrast_limit: f64,
    /// Largest mean difference from the marker of the first frame, grey levels a pixel.
    pub residual_limit: f64,
    /// Largest step between two frames, px.
    pub jump_limit: f64,
    /// Largest distance between flow and centroid, px.
    pub agreement_limit: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            radius: 18.0,
            reach: 9.0,
            contrast_limit: 25.0,
            residual_limit: 12.0,
            jump_limit: 20.0,
            agreement_limit: 2.0,
        }
    }
}

/// One marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Its centre, px.
    pub at: Point2,
    /// Covariance of its centre, px².
    pub covariance: [[f64; 2]; 2],
    /// Mean difference from the marker of the first frame, grey levels a pixel.
    pub residual: f64,
}

/// Follows markers from frame to frame.
pub struct Tracker {
    settings: Settings,
    before: Gray,
    frame: usize,
    tracks: Vec<Track>,
    sightings: Vec<Sighting>,
}

/// What is remembered of one marker.
struct Track {
    template: Template,
    at: Point2,
    step: Point2,
    turn: Radian,
    /// Covariance of late, px², once there was a second frame.
    scatter: Option<[[f64; 2]; 2]>,
}

/// One marker in the next frame, past all gates.
struct Seen {
    sighting: Sighting,
    turn: Radian,
    scatter: [[f64; 2]; 2],
}

/// The least radius of a window, px.
pub const LEAST_RADIUS: f64 = 4.0;
/// Share of a window's rim that may be dark: noise, but no other object.
const SPREAD_LIMIT: f64 = 0.1;

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
        let mut new = Self { settings, before: first.clone(), frame: 0, tracks: Vec::new(), sightings: Vec::new() };
        for (marker, &near) in clicked.iter().enumerate() {
            let lost = |why| Lost { marker, frame: 0, near, why };
            let blob = new.spot(first, near).map_err(lost)?;
            let away = distance(blob.at, near);
            if away > settings.reach {
                return Err(lost(Why::Far { measured: away, limit: settings.reach }));
            }
            let template = Template::cut(first, &blob, settings.radius);
            let sighting = Sighting { at: blob.at, covariance: scatter::of_pixels(&blob), residual: 0.0 };
            new.tracks.push(Track { template, at: blob.at, step: [0.0; 2], turn: 0.0, scatter: None });
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
    /// [`Lost`] when a marker fails a gate; the tracker then still stands at the frame before.
    pub fn step(&mut self, picture: &Gray) -> Result<Vec<Sighting>, Lost> {
        let mut seen = Vec::with_capacity(self.tracks.len());
        for (marker, track) in self.tracks.iter().enumerate() {
            let near = [track.at[0] + track.step[0], track.at[1] + track.step[1]];
            let found = self.sight(picture, track, near);
            seen.push(found.map_err(|why| Lost { marker, frame: self.frame + 1, near, why })?);
        }
        self.frame += 1;
        for (track, Seen { sighting, turn, scatter }) in self.tracks.iter_mut().zip(&seen) {
            track.step = [sighting.at[0] - track.at[0], sighting.at[1] - track.at[1]];
            (track.at, track.turn, track.scatter) = (sighting.at, *turn, Some(*scatter));
        }
        self.before.clone_from(picture);
        self.sightings = seen.into_iter().map(|seen| seen.sighting).collect();
        self.apart()?;
        Ok(self.sightings.clone())
    }

    /// Looks for one marker near the place (px) where it is expected and lets it pass the gates.
    fn sight(&self, picture: &Gray, track: &Track, near: Point2) -> Result<Seen, Why> {
        let (width, height) = (picture.width, picture.height);
        if (width, height) != (self.before.width, self.before.height) {
            return Err(Why::Resized { width, height });
        }
        let flow = flow::follow(&self.before, picture, track.at, near);
        let limit = self.settings.jump_limit;
        let guess = flow.filter(|&place| distance(place, track.at) <= limit).unwrap_or(near);
        let blob = self.spot(picture, guess)?;
        within(distance(blob.at, track.at), limit, |measured, limit| Why::Jumped { measured, limit })?;
        let apart = flow.map_or(f64::INFINITY, |place| distance(place, blob.at));
        within(apart, self.settings.agreement_limit, |measured, limit| Why::Disagrees { measured, limit })?;
        let difference = track.template.compare(picture, &blob, track.turn);
        within(difference.mean, self.settings.residual_limit, |measured, limit| Why::Changed { measured, limit })?;
        let now = scatter::of_sectors(picture, &blob, &track.template, difference.turn);
        let scatter = track.scatter.map_or(now, |old| mix(old, now));
        let covariance = sum(scatter, scatter::of_pixels(&blob));
        let sighting = Sighting { at: blob.at, covariance, residual: difference.mean };
        Ok(Seen { sighting, turn: difference.turn, scatter })
    }

    /// The dark spot near a place, when it is one.
    fn spot(&self, picture: &Gray, near: Point2) -> Result<Blob, Why> {
        let radius = self.settings.radius;
        let limit = self.settings.contrast_limit;
        let blob = blob::find(picture, near, radius).map_err(|miss| match miss {
            Miss::Outside => Why::LeavesFrame { radius, width: picture.width, height: picture.height },
            Miss::Empty => Why::Faint { measured: 0.0, limit },
        })?;
        if blob.contrast < limit {
            return Err(Why::Faint { measured: blob.contrast, limit });
        }
        within(blob.spread, SPREAD_LIMIT, |measured, limit| Why::Spreads { measured, limit })?;
        Ok(blob)
    }

    /// Refuses two tracks on one marker.
    fn apart(&self) -> Result<(), Lost> {
        for (marker, track) in self.tracks.iter().enumerate() {
            for (other, before) in self.tracks[..marker].iter().enumerate() {
                let (measured, limit) = (distance(track.at, before.at), self.settings.radius);
                if measured < limit {
                    let why = Why::Merged { other, measured, limit };
                    return Err(Lost { marker, frame: self.frame, near: track.at, why });
                }
            }
        }
        Ok(())
    }
}

/// Share of the last frames' scatter that is kept in each new one: a covariance from one frame alone is itself noisy.
const KEPT: f64 = 0.9;

fn within(measured: f64, limit: f64, why: fn(f64, f64) -> Why) -> Result<(), Why> {
    if measured <= limit { Ok(()) } else { Err(why(measured, limit)) }
}

/// The scatter of late with a new frame in it.
fn mix(old: [[f64; 2]; 2], new: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| KEPT * old[i][j] + (1.0 - KEPT) * new[i][j]))
}

fn sum(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| a[i][j] + b[i][j]))
}

fn distance(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
