//! The gates of a single marker: forward–backward flow, contrast, step, flow–centroid agreement, residual against its first view.
//!
//! No gate catches every failure, so all must pass. Each one is cheap beside the flow itself.

use super::blob::{self, Blob, Miss};
use super::error::FailedGate;
use super::flow::Flow;
use super::reacquisition::Region;
use super::{Accepted, Observation, Track, Tracker, covariance, distance, reacquisition};
use crate::Gray;
use si::Point2;

/// Share of a window's rim that may be dark: noise, but no other object.
pub(super) const SPREAD_LIMIT: f64 = 0.1;
/// Weight of the earlier frames in the exponential mean of the covariance: one frame alone gives a noisy covariance.
const SMOOTHING: f64 = 0.9;

impl Tracker {
    /// Searches for a marker that has been hidden for some frames by correlation with its first view; contrast and residual gates apply.
    pub(super) fn reacquire_marker(
        &self,
        picture: &Gray,
        track: &Track,
        frames: usize,
        taken: &[Point2],
    ) -> Result<Accepted, FailedGate> {
        let radius = (self.settings.jump_limit * (frames + 1) as f64).min(reacquisition::MAX_RADIUS);
        let region = Region { centre: track.at, radius, excluded: taken };
        let (place, measured) = reacquisition::best_match(picture, &track.template, &region);
        let limit = self.settings.correlation_limit;
        if measured < limit {
            return Err(FailedGate::LowCorrelation { measured, limit });
        }
        let blob = self.find_spot(picture, place)?;
        self.check_residual(picture, track, blob)
    }

    /// Measures one marker near its predicted place (px); all gates of a single marker apply.
    pub(super) fn locate_marker(&self, picture: &Gray, track: &Track, near: Point2) -> Result<Accepted, FailedGate> {
        self.locate_about(picture, track, near, track.at)
    }

    /// The same, where the largest step counts from `middle` (px).
    pub(super) fn locate_about(
        &self,
        picture: &Gray,
        track: &Track,
        near: Point2,
        middle: Point2,
    ) -> Result<Accepted, FailedGate> {
        let (width, height) = (picture.width, picture.height);
        if (width, height) != (self.before.width, self.before.height) {
            return Err(FailedGate::Resized { width, height });
        }
        let forward_flow = Flow { before: &self.before, after: picture, radius: self.settings.radius };
        let flow = forward_flow.follow_point(track.at, near);
        let limit = self.settings.jump_limit;
        // Forward–backward gate: flow that slid along an edge or onto another structure does not lead back to its start.
        let backward_flow = Flow { before: picture, after: &self.before, radius: self.settings.radius };
        let back = flow.and_then(|place| backward_flow.follow_point(place, track.at));
        let error = back.map_or(f64::INFINITY, |back| distance(back, track.at));
        check_limit(error, self.settings.forward_backward_limit, |measured, limit| FailedGate::ForwardBackward {
            measured,
            limit,
        })?;
        // Flow only predicts. A prediction beyond the largest step is dropped, and the spot is searched where the marker's last step
        // leads.
        let guess = flow.filter(|&place| distance(place, middle) <= limit).unwrap_or(near);
        let blob = self.find_spot(picture, guess)?;
        check_limit(distance(blob.at, middle), limit, |measured, limit| FailedGate::Jump { measured, limit })?;
        // Flow–centroid gate: two independent measurements of one marker. They differ when a reflection, another dark object or an
        // occluding edge shifts the centroid, or when flow followed something else.
        let flow_distance = flow.map_or(f64::INFINITY, |place| distance(place, blob.at));
        check_limit(flow_distance, self.settings.flow_centroid_limit, |measured, limit| FailedGate::FlowCentroid {
            measured,
            limit,
        })?;
        self.check_residual(picture, track, blob)
    }

    /// Residual gate: a spot must look as the marker did in the first frame.
    ///
    /// The template is that of the first frame and is never updated: an updated one drifts off with every small error and makes the
    /// gate blind to it. The turn of the marker and the level of the background are fitted instead. The limit depends on the scene: at
    /// the edge of a thin tail a window sees the grid pass behind the marker, so its residual is larger than amid the back.
    fn check_residual(&self, picture: &Gray, track: &Track, blob: Blob) -> Result<Accepted, FailedGate> {
        let difference = track.template.compare_spot(picture, &blob, track.turn);
        check_limit(difference.mean, self.settings.residual_limit, |measured, limit| FailedGate::HighResidual {
            measured,
            limit,
        })?;
        let now = covariance::of_sectors(picture, &blob, &track.template, difference.turn);
        let by_sectors = track.by_sectors.map_or(now, |old| exponential_mean(old, now));
        // A shift of the whole marker that the codec leaves out shows in no comparison with the first view; its variance is computed
        // from the quantiser and the contrast.
        let coded = covariance::at_least(by_sectors, covariance::of_codec(&blob, self.settings.quantiser));
        let covariance = matrix_sum(coded, covariance::of_pixels(&blob));
        let observation = Observation { at: blob.at, covariance, residual: difference.mean, seen: true };
        Ok(Accepted { observation, turn: difference.turn, by_sectors })
    }

    /// The dark spot near a place, with enough contrast and a light rim.
    pub(super) fn find_spot(&self, picture: &Gray, near: Point2) -> Result<Blob, FailedGate> {
        let radius = self.settings.radius;
        let limit = self.settings.contrast_limit;
        let blob = blob::find_blob(picture, near, radius).map_err(|miss| match miss {
            Miss::Outside => FailedGate::LeavesFrame { radius, width: picture.width, height: picture.height },
            Miss::Empty => FailedGate::LowContrast { measured: 0.0, limit },
        })?;
        if blob.contrast < limit {
            return Err(FailedGate::LowContrast { measured: blob.contrast, limit });
        }
        // Rim gate: a dark region that continues beyond the window is no marker, and its centroid is that of the window.
        check_limit(blob.spread, SPREAD_LIMIT, |measured, limit| FailedGate::DarkRim { measured, limit })?;
        Ok(blob)
    }
}

fn check_limit(measured: f64, limit: f64, why: fn(f64, f64) -> FailedGate) -> Result<(), FailedGate> {
    if measured <= limit { Ok(()) } else { Err(why(measured, limit)) }
}

/// The exponential mean with a new frame.
fn exponential_mean(old: [[f64; 2]; 2], new: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| SMOOTHING * old[i][j] + (1.0 - SMOOTHING) * new[i][j]))
}

pub(super) fn matrix_sum(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| a[i][j] + b[i][j]))
}
