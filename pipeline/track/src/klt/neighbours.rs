//! Gates between markers: minimum separation and the frame-to-frame change of neighbour distances.
//!
//! On one body the distance of two neighbours changes little from one frame to the next. The gates of a single marker do not see a swap:
//! a marker that jumps onto an identical neighbour passes them all. The distance is compared with the previous frame, not with the
//! first, so that the body may stretch.

use super::error::{Expected, FailedGate, TrackingError};
use super::{Accepted, Track, Tracker, distance};
use crate::Gray;
use si::Point2;

/// Number of neighbours that a marker is compared with.
const NEAREST: usize = 2;

impl Tracker {
    /// Of two markers at one place, the one farther from its prediction is rejected.
    pub(super) fn check_separation(&self, picture: &Gray, frame: usize, found: &mut [Result<Accepted, TrackingError>]) {
        let limit = self.settings.radius;
        for one in 0..found.len() {
            for other in 0..one {
                let (Ok(a), Ok(b)) = (&found[one], &found[other]) else { continue };
                let measured = distance(a.observation.at, b.observation.at);
                if measured < limit {
                    let prediction_error = |k: usize, at: Point2| distance(at, self.tracks[k].expected_place());
                    let farther = prediction_error(one, a.observation.at) >= prediction_error(other, b.observation.at);
                    let (marker, other) = if farther { (one, other) } else { (other, one) };
                    let why = FailedGate::Merged { other, measured, limit };
                    let expected = Expected { marker, frame, near: self.tracks[marker].at };
                    found[marker] = Err(TrackingError::with_crop(picture, expected, why));
                }
            }
        }
    }

    /// Neighbour-distance gate: of two neighbours whose distance changes too much, the one farther from its prediction is rejected.
    pub(super) fn check_neighbours(&self, picture: &Gray, frame: usize, found: &mut [Result<Accepted, TrackingError>]) {
        // The largest change first: one stray marker changes the distances from all its neighbours, and without it they
        // agree again.
        while let Some((one, other, measured)) = self.largest_change(found) {
            let prediction_error = |k: usize| {
                found[k].as_ref().map_or(0.0, |s| distance(s.observation.at, self.tracks[k].expected_place()))
            };
            let (marker, other) =
                if prediction_error(one) >= prediction_error(other) { (one, other) } else { (other, one) };
            let why = FailedGate::NeighbourDistance { other, measured, limit: self.settings.neighbour_distance_limit };
            let expected = Expected { marker, frame, near: self.tracks[marker].at };
            found[marker] = Err(TrackingError::with_crop(picture, expected, why));
        }
    }

    /// The two neighbours whose distance changed most since the frame before, and by which share, where that is too much.
    fn largest_change(&self, found: &[Result<Accepted, TrackingError>]) -> Option<(usize, usize, f64)> {
        let spot_of = |k: usize| found[k].as_ref().ok().map(|s| s.observation.at);
        let each = (0..found.len()).filter_map(|one| Some((one, spot_of(one)?)));
        let pairs = each.flat_map(|(one, spot)| {
            let neighbour_spots =
                self.nearest_neighbours(one).into_iter().filter_map(move |other| Some((other, spot_of(other)?)));
            neighbour_spots.filter_map(move |(other, neighbour_spot)| {
                Some((one, other, self.distance_change([one, other], [spot, neighbour_spot])?))
            })
        });
        pairs.filter(|pair| pair.2 > self.settings.neighbour_distance_limit).max_by(|a, b| a.2.total_cmp(&b.2))
    }

    /// By which share the distance of two markers changed since the frame before; `None` when one was hidden then.
    fn distance_change(&self, [one, other]: [usize; 2], now: [Point2; 2]) -> Option<f64> {
        let (one, other) = (&self.tracks[one], &self.tracks[other]);
        let both_seen = one.hidden.is_none() && other.hidden.is_none();
        both_seen.then(|| (distance(now[0], now[1]) / distance(one.at, other.at) - 1.0).abs())
    }

    /// The markers nearest to one, nearest first.
    fn nearest_neighbours(&self, marker: usize) -> Vec<usize> {
        let distance_from = |k: &usize| distance(self.tracks[*k].at, self.tracks[marker].at);
        let mut candidates: Vec<usize> = (0..self.tracks.len()).filter(|k| *k != marker).collect();
        candidates.sort_by(|a, b| distance_from(a).total_cmp(&distance_from(b)));
        candidates.truncate(NEAREST);
        candidates
    }

    /// Measures rejected markers again where they are if they moved and rotated rigidly with their neighbours.
    ///
    /// A marker whose own prediction failed is recovered in the same frame, before it counts as hidden.
    pub(super) fn relocate(&self, picture: &Gray, found: &mut [Result<Accepted, TrackingError>]) {
        for marker in 0..found.len() {
            let track = &self.tracks[marker];
            if found[marker].is_ok() || track.hidden.is_some() {
                continue;
            }
            let visible =
                found.iter().zip(&self.tracks).filter_map(|(f, t)| Some((f.as_ref().ok()?.observation.at, t)));
            let mut visible: Vec<(Point2, &Track)> = visible.filter(|(_, t)| t.hidden.is_none()).collect();
            visible.sort_by(|a, b| distance(a.1.at, track.at).total_cmp(&distance(b.1.at, track.at)));
            let Some(guess) = rigid_guess(track, &visible) else { continue };
            let Ok(again) = self.locate_marker(picture, track, guess) else { continue };
            let new_point = again.observation.at;
            let is_free = visible.iter().all(|(at, _)| distance(*at, new_point) >= self.settings.radius);
            let neighbours = self.nearest_neighbours(marker).into_iter();
            let mut neighbours = neighbours
                .filter_map(|k| self.distance_change([marker, k], [new_point, found[k].as_ref().ok()?.observation.at]));
            if is_free && neighbours.all(|change| change <= self.settings.neighbour_distance_limit) {
                found[marker] = Ok(again);
            }
        }
    }

    /// Searches for the markers that are hidden, past those that were found in this frame.
    ///
    /// Their places of the frame before do not do: a neighbour that moves by the spacing lies where the hidden marker is searched.
    pub(super) fn reacquire_hidden(&self, picture: &Gray, frame: usize, found: &mut [Result<Accepted, TrackingError>]) {
        for (marker, track) in self.tracks.iter().enumerate() {
            let Some(since) = &track.hidden else { continue };
            let known_point = |(seen, other): (&Result<Accepted, TrackingError>, &Track)| match seen {
                Ok(seen) => Some(seen.observation.at),
                Err(_) => other.hidden.is_none().then_some(other.at),
            };
            let taken: Vec<Point2> = found.iter().zip(&self.tracks).filter_map(known_point).collect();
            let expected = Expected { marker, frame, near: track.expected_place() };
            let again = self.reacquire_marker(picture, track, frame - since.frame, &taken);
            found[marker] = again.map_err(|why| TrackingError::with_crop(picture, expected, why));
        }
        self.check_separation(picture, frame, found);
    }

    /// Refuses two tracks on one marker.
    pub(super) fn check_tracks_apart(&self) -> Result<(), TrackingError> {
        let is_visible = |(_, track): &(usize, &Track)| track.hidden.is_none();
        for (marker, track) in self.tracks.iter().enumerate().filter(is_visible) {
            for (other, before) in self.tracks[..marker].iter().enumerate().filter(is_visible) {
                let (measured, limit) = (distance(track.at, before.at), self.settings.radius);
                if measured < limit {
                    let why = FailedGate::Merged { other, measured, limit };
                    let expected = Expected { marker, frame: self.frame, near: track.at };
                    return Err(TrackingError::with_crop(&self.before, expected, why));
                }
            }
        }
        Ok(())
    }
}

/// Where a marker is if it moved with the nearest of those seen (px now, and as it was before), and turned about it as the next did.
fn rigid_guess(track: &Track, seen: &[(Point2, &Track)]) -> Option<Point2> {
    let (there, near) = seen.first()?;
    let towards = |from: Point2, to: Point2| (to[1] - from[1]).atan2(to[0] - from[0]);
    let turn = seen.get(1).map_or(0.0, |(place, next)| towards(*there, *place) - towards(near.at, next.at));
    let (sine, cosine) = turn.sin_cos();
    let arm = [0, 1].map(|k| track.at[k] - near.at[k]);
    Some([there[0] + cosine * arm[0] - sine * arm[1], there[1] + sine * arm[0] + cosine * arm[1]])
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;

    /// Three dark discs in a row.
    fn three() -> Gray {
        Gray::from_fn(260, 100, |x, y| {
            let near = |at: f64| (x as f64 - at).hypot(y as f64 - 50.0) < 9.0;
            if [50.0, 110.0, 170.0].into_iter().any(near) { 40.0 } else { 200.0 }
        })
    }

    #[test]
    fn a_marker_whose_neighbour_distance_jumps_is_rejected_and_the_others_are_not() {
        let picture = three();
        let tracker =
            Tracker::new(&picture, &[[50.0, 50.0], [110.0, 50.0], [170.0, 50.0]], Settings::default()).unwrap();
        let found = |by: f64| {
            let seen = |(k, track): (usize, &Track)| {
                let mut seen = tracker.locate_marker(&picture, track, track.at).unwrap();
                seen.observation.at[0] += if k == 2 { by } else { 0.0 };
                Ok(seen)
            };
            let mut found: Vec<Result<Accepted, TrackingError>> = tracker.tracks.iter().enumerate().map(seen).collect();
            tracker.check_neighbours(&picture, 1, &mut found);
            found.iter().map(Result::is_ok).collect::<Vec<_>>()
        };
        // 60 px apart: a third of that may come or go, more may not
        assert_eq!((found(15.0), found(30.0)), (vec![true; 3], vec![true, true, false]));
    }

    #[test]
    fn a_rejected_marker_is_searched_where_the_rigid_motion_of_its_neighbours_leads() {
        let picture = three();
        let tracker =
            Tracker::new(&picture, &[[50.0, 50.0], [110.0, 50.0], [170.0, 50.0]], Settings::default()).unwrap();
        let [first, second, third] = &tracker.tracks[..] else { panic!("three were clicked") };
        // a quarter turn about the first, which moved by (5, 7)
        let turned = |track: &Track| [first.at[0] + 5.0, first.at[1] + 7.0 + track.at[0] - first.at[0]];
        let guess = rigid_guess(third, &[(turned(second), second), (turned(first), first)]).unwrap();
        assert!(distance(guess, turned(third)) < 0.1, "{guess:?}");
        assert!(rigid_guess(third, &[]).is_none());
    }
}
