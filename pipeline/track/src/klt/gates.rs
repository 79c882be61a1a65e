//! The gates that a marker passes in each frame: flow there and back, its spot, its looks.
//!
//! Stands on: flow, spots, templates, their scatter. Never knows: the other markers' gates.

use super::blob::{self, Blob, Miss};
use super::lost::Why;
use super::{Seen, Sighting, Track, Tracker, distance, flow, scatter, search};
use crate::Gray;
use si::Point2;

/// Share of a window's rim that may be dark: noise, but no other object.
pub(super) const SPREAD_LIMIT: f64 = 0.1;
/// Share of the last frames' scatter that is kept in each new one: a covariance from one frame alone is itself noisy.
const KEPT: f64 = 0.9;

impl Tracker {
    /// Looks for a marker that has been hidden for some frames, by how it looked, and lets it pass the gates of looks and leaps.
    pub(super) fn sight_again(&self, picture: &Gray, marker: usize, track: &Track, frames: usize) -> Result<Seen, Why> {
        let others = self.tracks.iter().enumerate().filter(|(other, t)| *other != marker && t.hidden.is_none());
        let taken: Vec<Point2> = others.map(|(_, t)| t.at).collect();
        let reach = (self.settings.jump_limit * (frames + 1) as f64).min(search::FARTHEST);
        let (place, likeness) = search::like(picture, &track.template, track.at, reach, &taken);
        let limit = self.settings.likeness_limit;
        if likeness < limit {
            return Err(Why::Unlike { measured: likeness, limit });
        }
        let blob = self.spot(picture, place)?;
        self.judged(picture, track, blob)
    }

    /// Looks for one marker near the place (px) where it is expected and lets it pass the gates.
    pub(super) fn sight(&self, picture: &Gray, track: &Track, near: Point2) -> Result<Seen, Why> {
        let (width, height) = (picture.width, picture.height);
        if (width, height) != (self.before.width, self.before.height) {
            return Err(Why::Resized { width, height });
        }
        let flow = flow::follow(&self.before, picture, track.at, near);
        let limit = self.settings.jump_limit;
        let back = flow.and_then(|there| flow::follow(picture, &self.before, there, track.at));
        let off = back.map_or(f64::INFINITY, |back| distance(back, track.at));
        within(off, self.settings.return_limit, |measured, limit| Why::NotBack { measured, limit })?;
        let guess = flow.filter(|&place| distance(place, track.at) <= limit).unwrap_or(near);
        let blob = self.spot(picture, guess)?;
        within(distance(blob.at, track.at), limit, |measured, limit| Why::Jumped { measured, limit })?;
        let apart = flow.map_or(f64::INFINITY, |place| distance(place, blob.at));
        within(apart, self.settings.agreement_limit, |measured, limit| Why::Disagrees { measured, limit })?;
        self.judged(picture, track, blob)
    }

    /// A spot that must look as the marker did in the first frame.
    fn judged(&self, picture: &Gray, track: &Track, blob: Blob) -> Result<Seen, Why> {
        let difference = track.template.compare(picture, &blob, track.turn);
        within(difference.mean, self.settings.residual_limit, |measured, limit| Why::Changed { measured, limit })?;
        let now = scatter::of_sectors(picture, &blob, &track.template, difference.turn);
        let scatter = track.scatter.map_or(now, |old| mix(old, now));
        let coded = scatter::at_least(scatter, scatter::of_codec(&blob, self.settings.quantiser));
        let covariance = sum(coded, scatter::of_pixels(&blob));
        let sighting = Sighting { at: blob.at, covariance, residual: difference.mean, seen: true };
        Ok(Seen { sighting, turn: difference.turn, scatter })
    }

    /// The dark spot near a place, when it is one.
    pub(super) fn spot(&self, picture: &Gray, near: Point2) -> Result<Blob, Why> {
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
}

fn within(measured: f64, limit: f64, why: fn(f64, f64) -> Why) -> Result<(), Why> {
    if measured <= limit { Ok(()) } else { Err(why(measured, limit)) }
}

/// The scatter of late with a new frame in it.
fn mix(old: [[f64; 2]; 2], new: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| KEPT * old[i][j] + (1.0 - KEPT) * new[i][j]))
}

pub(super) fn sum(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| a[i][j] + b[i][j]))
}
