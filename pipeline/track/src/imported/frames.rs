//! Checks of imported tracks over many frames: their order, and places that are repeated.

use super::error::{DISORDER, ImportedError};
use super::{ImportedTrack, distance};
use crate::klt::Observation;
use si::Point2;

/// Frames that give the ratio: of sixty in random order it scatters by 0.13.
const ENOUGH: usize = 60;
/// The spread exceeds the standard deviation of a place by so many times: below, what is seen may be noise, whose order nobody knows.
const MOVED: f64 = 5.0;

/// Refuses frames of a slow motion in random order, which pass the gate of steps: their steps are as long as the motion itself.
pub(super) fn check_order(tracks: &[ImportedTrack], unit: &'static str) -> Result<(), ImportedError> {
    if tracks.iter().any(|track| track.seen.len() < ENOUGH) {
        return Ok(());
    }
    let mean_square = |values: Vec<f64>| values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64;
    let of_all = |value: &dyn Fn(&[Observation]) -> Vec<f64>| {
        tracks.iter().map(|track| mean_square(value(&track.seen))).sum::<f64>() / tracks.len().max(1) as f64
    };
    let steps = of_all(&|seen| {
        seen.windows(2).filter(|p| p[0].seen && p[1].seen).map(|p| distance(p[0].at, p[1].at)).collect()
    });
    let spread = of_all(&from_mean);
    let noise = of_all(&|seen| seen.iter().map(|s| (s.covariance[0][0] + s.covariance[1][1]).sqrt()).collect());
    let ratio = 0.5 * steps / spread.max(f64::MIN_POSITIVE);
    if spread > MOVED * MOVED * noise && ratio > DISORDER {
        return Err(ImportedError::Order { spread: spread.sqrt(), step: steps.sqrt(), unit, ratio });
    }
    Ok(())
}

/// Frames with the very same place that may be a place held: fewer are a turning point of coordinates that are rounded to pixels.
const FROZEN: usize = 8;
/// Share of its own motion that a marker misses while it is held: at a turning point a neighbour that lags by an eighth of a cycle moves by
/// less than a quarter of its own.
const MISSED: f64 = 0.5;

/// A marker that moves by fewer of the least steps in which its places are written may stand still in them.
const STEPS_OF_RESOLUTION: f64 = 8.0;

/// Refuses a marker that repeats a place while another moves so far that this one would have made half of all its motion.
pub(super) fn check_frozen(tracks: &[ImportedTrack], marker: usize, unit: &'static str) -> Result<(), ImportedError> {
    let seen = &tracks[marker].seen;
    let deviation = seen.iter().map(|s| s.covariance[0][0] + s.covariance[1][1]).fold(0.0, f64::max).sqrt();
    if extent(seen) < (MOVED * deviation).max(STEPS_OF_RESOLUTION * resolution(seen)) {
        return Ok(());
    }
    let mut frame = 0;
    while frame < seen.len() {
        let frames = seen[frame..].iter().take_while(|next| next.seen && next.at == seen[frame].at).count().max(1);
        let run = frame..frame + frames;
        let others = (0..tracks.len()).filter(|other| *other != marker && frames >= FROZEN);
        let motions = others.map(|other| (other, extent(&tracks[other].seen[run.clone()])));
        let farthest = motions.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((other, motion)) =
            farthest.filter(|(other, motion)| *motion > MISSED * extent(&tracks[*other].seen))
        {
            let (marker, other) = (tracks[marker].name.clone(), tracks[other].name.clone());
            return Err(ImportedError::Frozen { marker, frame, frames, other, motion, unit });
        }
        frame += frames;
    }
    Ok(())
}

/// The least change of a coordinate from one frame to the next: a pixel where places are rounded to pixels.
fn resolution(seen: &[Observation]) -> f64 {
    let changes = |pair: &[Observation]| [0, 1].map(|k| (pair[1].at[k] - pair[0].at[k]).abs());
    seen.windows(2).flat_map(changes).filter(|change| *change > 0.0).fold(f64::INFINITY, f64::min)
}

/// The diagonal of the box about the places that are seen.
fn extent(seen: &[Observation]) -> f64 {
    let span = |k: usize| {
        let values = || seen.iter().filter(|seen| seen.seen).map(|seen| seen.at[k]);
        (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)).max(0.0)
    };
    span(0).hypot(span(1))
}

/// Distances of the places that are seen from their mean.
fn from_mean(seen: &[Observation]) -> Vec<f64> {
    let places: Vec<Point2> = seen.iter().filter(|seen| seen.seen).map(|seen| seen.at).collect();
    let mean = [0, 1].map(|k| places.iter().map(|at| at[k]).sum::<f64>() / places.len().max(1) as f64);
    places.iter().map(|at| distance(*at, mean)).collect()
}
