//! Tracks of another program: the gates of this tracker that need no picture, and the frames in which a marker was lost.
//!
//! A point that was set far away, two markers that change places and frames in another order all move a marker farther from one frame to
//! the next, or change the distance of neighbours more, than a body does.

mod error;
mod frames;

pub use error::ImportedError;

use crate::klt::{Observation, Settings, fill_gaps};
use frames::{check_frozen, check_order};
use si::Point2;

/// A marker, in pixels or in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedTrack {
    /// Its name.
    pub name: String,
    /// Where it is: frames; what is not seen is filled.
    pub seen: Vec<Observation>,
}

impl ImportedTrack {
    /// Of places with their covariances uu, uv and vv, none where the marker is lost.
    pub fn new(name: &str, places: impl Iterator<Item = (Option<Point2>, [f64; 3])>) -> Self {
        let observation = |(at, [uu, uv, vv]): (Option<Point2>, [f64; 3])| Observation {
            at: at.unwrap_or([f64::NAN; 2]),
            covariance: [[uu, uv], [uv, vv]],
            residual: 0.0,
            seen: at.is_some(),
        };
        Self { name: name.to_owned(), seen: places.map(observation).collect() }
    }

    /// Its places and their covariances.
    pub fn places_with_covariances(&self) -> (Vec<Point2>, Vec<[f64; 3]>) {
        let covariance = |seen: &Observation| [seen.covariance[0][0], seen.covariance[0][1], seen.covariance[1][1]];
        self.seen.iter().map(|seen| (seen.at, covariance(seen))).unzip()
    }
}

/// What a marker may do, in the unit of its places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest step from one frame to the next.
    pub step: f64,
    /// Largest change of the distance between neighbours from one frame to the next, as a share of it.
    pub neighbour_distance: f64,
    /// Frames in which a marker may be lost.
    pub longest_gap: usize,
    /// The unit.
    pub unit: &'static str,
    /// What the first two come from.
    pub source: &'static str,
}

impl Limits {
    /// Those of this tracker, px.
    pub fn from_settings(set: &Settings) -> Self {
        let (step, neighbour_distance, longest_gap) = (set.jump_limit, set.neighbour_distance_limit, set.patience);
        let source = "study.toml, [track] jump_limit and neighbour_distance_limit";
        Self { step, neighbour_distance, longest_gap, unit: "px", source }
    }
}

/// Checks tracks of the same frames, and fills the frames in which a marker is lost.
///
/// # Errors
/// [`ImportedError`] with marker and frame.
pub fn check_tracks(tracks: &mut [ImportedTrack], limits: &Limits) -> Result<(), ImportedError> {
    for track in tracks.iter() {
        check_gaps(track, limits.longest_gap)?;
        check_steps(track, limits)?;
    }
    for one in 0..tracks.len() {
        for other in nearest_markers(tracks, one) {
            check_distance([&tracks[one], &tracks[other]], limits)?;
        }
    }
    check_order(tracks, limits.unit)?;
    (0..tracks.len()).try_for_each(|marker| check_frozen(tracks, marker, limits.unit))?;
    tracks.iter_mut().for_each(|track| fill_gaps(&mut track.seen));
    Ok(())
}

fn check_gaps(track: &ImportedTrack, limit: usize) -> Result<(), ImportedError> {
    let mut frame = 0;
    while frame < track.seen.len() {
        let frames = track.seen[frame..].iter().take_while(|seen| !seen.seen).count();
        let at_end = frames > 0 && (frame == 0 || frame + frames == track.seen.len());
        if frames > limit || at_end {
            return Err(ImportedError::Gap { marker: track.name.clone(), frame, frames, limit });
        }
        frame += frames + 1;
    }
    Ok(())
}

fn check_steps(track: &ImportedTrack, limits: &Limits) -> Result<(), ImportedError> {
    let present: Vec<(usize, Point2)> =
        track.seen.iter().enumerate().filter(|(_, s)| s.seen).map(|(frame, s)| (frame, s.at)).collect();
    for pair in present.windows(2) {
        let [(before, a), (frame, b)] = [pair[0], pair[1]];
        let measured = distance(a, b) / (frame - before) as f64;
        if measured > limits.step {
            let (limit, unit, source_of_limit) = (limits.step, limits.unit, limits.source);
            let marker = track.name.clone();
            return Err(ImportedError::Step { marker, frame, measured, limit, unit, source_of_limit });
        }
    }
    Ok(())
}

fn check_distance([one, other]: [&ImportedTrack; 2], limits: &Limits) -> Result<(), ImportedError> {
    // length: tracks of the same frames
    let distances = one.seen.iter().zip(&other.seen).map(|(a, b)| (a.seen && b.seen).then(|| distance(a.at, b.at)));
    let distances: Vec<Option<f64>> = distances.collect();
    for (frame, pair) in distances.windows(2).enumerate() {
        let Some(measured) = pair[0].zip(pair[1]).map(|(before, now)| (now / before - 1.0).abs()) else { continue };
        // two markers at one place have no distance to change
        if measured > limits.neighbour_distance || measured.is_nan() {
            let (marker, other, limit) = (one.name.clone(), other.name.clone(), limits.neighbour_distance);
            let (frame, source_of_limit) = (frame + 1, limits.source);
            return Err(ImportedError::NeighbourDistance { marker, other, frame, measured, limit, source_of_limit });
        }
    }
    Ok(())
}

/// Number of neighbours that a marker is compared with.
const NEAREST: usize = 2;

/// The markers nearest to one in the first frame.
fn nearest_markers(tracks: &[ImportedTrack], marker: usize) -> Vec<usize> {
    let first = |k: usize| tracks[k].seen.first().map_or([f64::NAN; 2], |seen| seen.at);
    let mut candidates: Vec<usize> = (0..tracks.len()).filter(|k| *k != marker).collect();
    candidates.sort_by(|a, b| distance(first(marker), first(*a)).total_cmp(&distance(first(marker), first(*b))));
    candidates.truncate(NEAREST);
    candidates
}

fn distance(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { step: 60.0, neighbour_distance: 0.35, longest_gap: 5, unit: "px", source: "study.toml, [track]" };

    /// Three markers 40 px apart that swing by 0, 40 and 80 px, once in 30 frames.
    fn swinging() -> Vec<ImportedTrack> {
        let position =
            |k: usize, frame: usize| [100.0 + 40.0 * k as f64, 90.0 + 40.0 * k as f64 * (0.21 * frame as f64).sin()];
        let observation = |k, frame| Observation {
            at: position(k, frame),
            covariance: [[0.01, 0.0], [0.0, 0.01]],
            residual: 0.0,
            seen: true,
        };
        let track = |k: usize| ImportedTrack {
            name: format!("m{}", k + 1),
            seen: (0..60).map(|f| observation(k, f)).collect(),
        };
        (0..3).map(track).collect()
    }

    fn refused(change: impl FnOnce(&mut Vec<ImportedTrack>)) -> String {
        let mut tracks = swinging();
        change(&mut tracks);
        check_tracks(&mut tracks, &LIMITS).unwrap_err().to_string()
    }

    #[test]
    fn a_swing_is_accepted_as_it_is() {
        let mut tracks = swinging();
        check_tracks(&mut tracks, &LIMITS).unwrap();
        assert_eq!(tracks, swinging());
    }

    #[test]
    fn a_point_far_away_and_frames_in_another_order_are_refused_with_marker_and_frame() {
        let message = refused(|tracks| tracks[1].seen[20].at[0] += 100.0);
        assert!(
            message.contains("marker `m2` moves by 100.")
                && message.contains("before frame 20")
                && message.contains("60.0"),
            "{message}"
        );
        let message = refused(|tracks| tracks.iter_mut().for_each(|track| track.seen.swap(8, 23)));
        assert!(message.contains("marker `m2`") && message.contains("before frame 8"), "{message}");
    }

    /// A motion of 20 px in 80 frames passes the gate of steps in any order.
    #[test]
    fn frames_of_a_slow_motion_in_random_order_are_refused() {
        let order = |frame: usize| frame * 37 % 80;
        let tracks = |frames: &dyn Fn(usize) -> usize, size: f64| -> Vec<ImportedTrack> {
            let position = |k: usize, frame: usize| {
                let phase = 0.06 * frames(frame) as f64;
                [100.0 + 40.0 * k as f64, 90.0 + size * (1.0 + k as f64) * phase.sin()]
            };
            let places = |k| (0..80).map(move |frame| (Some(position(k, frame)), [0.25, 0.0, 0.25]));
            (0..2).map(|k| ImportedTrack::new(&format!("m{k}"), places(k))).collect()
        };
        let check = |frames: &dyn Fn(usize) -> usize, size| check_tracks(&mut tracks(frames, size), &LIMITS);
        assert_eq!(check(&|frame| frame, 10.0), Ok(()));
        let message = check(&order, 10.0).unwrap_err().to_string();
        assert!(message.contains("do not follow each other") && message.contains("the order of the film"), "{message}");
        assert_eq!(check(&order, 0.5), Ok(()), "what may be noise has no order");
    }

    #[test]
    fn a_place_that_is_repeated_while_the_others_move_is_refused_and_turning_points_are_not() {
        let message = refused(|tracks| {
            let repeated = tracks[1].seen[20];
            tracks[1].seen[20..44].iter_mut().for_each(|seen| seen.at = repeated.at);
            let next = tracks[1].seen[44].at;
            // the gate of steps sees a leap back: it comes back slowly
            let blend = |a: f64, b: f64, share: f64| a + share * (b - a);
            (44..50).for_each(|k| tracks[1].seen[k].at[1] = blend(repeated.at[1], next[1], (k - 43) as f64 / 7.0));
        });
        assert!(message.contains("`m2` stands at the very same place in 24 frames from frame 20 on"), "{message}");
        assert!(message.contains("`m3` moves by"), "{message}");
        let mut rounded = swinging();
        rounded.iter_mut().flat_map(|track| &mut track.seen).for_each(|seen| seen.at = seen.at.map(f64::round));
        assert_eq!(check_tracks(&mut rounded, &LIMITS), Ok(()), "the first does not move, the others turn");
    }

    #[test]
    fn markers_that_change_places_are_refused_where_they_do() {
        for pair in [[0, 1], [1, 2], [0, 2]] {
            let message = refused(|tracks| {
                for frame in 30..36 {
                    let [a, b] = pair.map(|k| tracks[k].seen[frame]);
                    (tracks[pair[0]].seen[frame], tracks[pair[1]].seen[frame]) = (b, a);
                }
            });
            assert!(message.contains("frame 30"), "{message}");
        }
    }

    #[test]
    fn a_short_gap_is_filled_and_a_long_one_or_one_at_an_end_refused() {
        let lose = |tracks: &mut Vec<ImportedTrack>, frames: std::ops::Range<usize>| {
            for seen in &mut tracks[2].seen[frames] {
                (seen.seen, seen.at) = (false, [f64::NAN; 2]);
            }
        };
        let mut tracks = swinging();
        lose(&mut tracks, 20..25);
        check_tracks(&mut tracks, &LIMITS).unwrap();
        let deviation =
            tracks[2].seen.iter().zip(&swinging()[2].seen).map(|(a, b)| distance(a.at, b.at)).fold(0.0, f64::max);
        // a cubic over a fifth of a cycle of 80 px
        assert!(deviation < 2.0 && tracks[2].seen[22].covariance[1][1] > 0.02, "{deviation}");
        assert!(refused(|tracks| lose(tracks, 20..26)).contains("`m3` has no place in 6 frames from frame 20 on"));
        assert!(refused(|tracks| lose(tracks, 0..1)).contains("from frame 0 on"));
        assert!(refused(|tracks| lose(tracks, 59..60)).contains("from frame 59 on"));
    }
}
