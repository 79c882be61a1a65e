//! Joint matching: all markers are assigned at once to all dark spots near them.
//!
//! A marker is otherwise tracked by itself, which fails where it moves between two frames by about the distance to its neighbour: flow
//! then leads to the neighbour or nowhere. A body that deforms moves neighbours alike, turns their connecting line by little and keeps
//! its length. The assignment of least cost is that of a pictorial structure (`spanning_tree`) on the shortest tree through the markers;
//! what it finds passes the same gates as any other observation, but the largest step counts from the assigned spot.
//!
//! It is called for where a marker fails its gates, or the line between two neighbours turns or stretches so much that they may have been
//! exchanged. All other frames are tracked as without it.

use super::error::{Expected, FailedGate, TrackingError};
use super::find_blobs::find_blobs;
use super::spanning_tree::{Cost, SpanningTree};
use super::{Accepted, Tracker, distance};
use crate::Gray;
use si::Point2;

/// How far all markers together may move between two frames, in largest steps of one against its neighbour.
const REACH: f64 = 2.0;
/// Cost of a marker without a spot: that of two largest steps of all markers together, so that any motion within reach costs less.
const MISSING: f64 = REACH * REACH;
/// Cost of the line between two neighbours above which they may have been exchanged: that of a turn by one radian.
const DOUBTFUL: f64 = 1.0;
/// Largest cosine of a turn of two neighbours about each other that is refused: a quarter turn and more puts one past the other.
const PAST: f64 = 0.0;
/// A spot that is found twice is one when its middles agree to this, px.
const SAME: f64 = 2.0;

/// Markers that were seen in the frame before, and spots in this one.
struct Matching<'a> {
    tracker: &'a Tracker,
    markers: Vec<usize>,
    spots: Vec<Point2>,
    /// Residual of each spot against the first view of each marker, grey levels a pixel; infinite for no marker. Markers × spots.
    residuals: Vec<Vec<f64>>,
}

impl Tracker {
    /// Corrects what was found of each marker by itself, in place, where it may belong to another or was not found.
    pub(super) fn match_jointly(&self, picture: &Gray, frame: usize, found: &mut [Result<Accepted, TrackingError>]) {
        let markers: Vec<usize> = (0..found.len()).filter(|k| self.tracks[*k].hidden.is_none()).collect();
        let previous_places: Vec<Point2> = markers.iter().map(|k| self.tracks[*k].at).collect();
        let tree = SpanningTree::of_least_length(&previous_places);
        if markers.len() < 2 || !self.is_doubtful(&markers, &tree, found) {
            return;
        }
        // Without it the mark at the end of a tail that was released from 250 mbar was 2.97 px off (root mean square
        // over the film): 65 px a frame exceed its largest step, and it counted as hidden. With it: 0.03 px.
        let matching = Matching::of_markers(self, picture, markers, found);
        let chosen = tree.cheapest_assignment(&matching);
        for (k, &marker) in matching.markers.iter().enumerate() {
            let spot = chosen[k].map(|spot| matching.spots[spot]);
            let alone = found[marker].as_ref().ok().map(|s| s.observation.at);
            let again = match (spot, alone) {
                (Some(spot), Some(alone)) if distance(spot, alone) < SAME => continue,
                (Some(spot), _) => self.locate_about(picture, &self.tracks[marker], spot, spot),
                (None, Some(alone)) => match matching.marker_at(&chosen, alone) {
                    Some(other) => Err(FailedGate::Merged { other, measured: 0.0, limit: self.settings.radius }),
                    None => continue,
                },
                (None, None) => continue,
            };
            let near = self.tracks[marker].expected_place();
            found[marker] =
                again.map_err(|why| TrackingError::with_crop(picture, Expected { marker, frame, near }, why));
        }
        self.check_separation(picture, frame, found);
        self.check_neighbours(picture, frame, found);
    }

    /// Where a marker is if it moves on, and if it stays: a release begins at rest, and what swings turns round.
    fn position_guesses(&self, marker: usize) -> [Point2; 2] {
        [self.tracks[marker].expected_place(), self.tracks[marker].at]
    }

    /// Left, top, right and bottom (px) of where markers may be.
    fn search_region(&self, markers: &[usize]) -> [f64; 4] {
        let reach = REACH * self.settings.jump_limit;
        let coordinates =
            |axis: usize| markers.iter().flat_map(|k| self.position_guesses(*k)).map(move |near| near[axis]);
        let low = |axis: usize| coordinates(axis).fold(f64::INFINITY, f64::min) - reach;
        let high = |axis: usize| coordinates(axis).fold(f64::NEG_INFINITY, f64::max) + reach;
        [low(0), low(1), high(0), high(1)]
    }

    /// Whether a marker was not found, or two neighbours may have been exchanged.
    fn is_doubtful(&self, markers: &[usize], tree: &SpanningTree, found: &[Result<Accepted, TrackingError>]) -> bool {
        let spot_of = |part: usize| found[markers[part]].as_ref().ok().map(|s| s.observation.at);
        let bent = |pair: [usize; 2]| match pair.map(spot_of) {
            [Some(a), Some(b)] => self.pair_bending(pair.map(|part| markers[part]), [a, b]) > DOUBTFUL,
            _ => true,
        };
        tree.joined_pairs().any(bent)
    }

    /// Turn (rad) and change of length (as a share of its limit) of the line between two markers that are `now` there, squared;
    /// infinite where a limit is exceeded.
    fn pair_bending(&self, markers: [usize; 2], now: [Point2; 2]) -> f64 {
        let line = |[a, b]: [Point2; 2]| [a[0] - b[0], a[1] - b[1]];
        let (before, now) = (line(markers.map(|k| self.tracks[k].at)), line(now));
        let [long, longer] = [before, now].map(|l| l[0].hypot(l[1]));
        let stretch = (longer / long - 1.0) / self.settings.neighbour_distance_limit;
        let (cosine, sine) = (before[0] * now[0] + before[1] * now[1], before[0] * now[1] - before[1] * now[0]);
        if stretch.abs() > 1.0 || distance(before, now) > self.settings.jump_limit || cosine <= PAST {
            return f64::INFINITY;
        }
        stretch * stretch + sine.atan2(cosine).powi(2)
    }
}

impl<'a> Matching<'a> {
    fn of_markers(
        tracker: &'a Tracker,
        picture: &Gray,
        markers: Vec<usize>,
        found: &[Result<Accepted, TrackingError>],
    ) -> Self {
        let mut spots: Vec<Point2> = found.iter().flatten().map(|s| s.observation.at).collect();
        // where all were found, only an exchange is in question
        if markers.iter().any(|k| found[*k].is_err()) {
            let own_spots = spots.clone();
            let candidates =
                find_blobs(picture, tracker.search_region(&markers), usize::MAX, &tracker.settings).into_iter();
            spots.extend(
                candidates.filter(|spot| own_spots.iter().all(|own_spots| distance(*own_spots, *spot) >= SAME)),
            );
        }
        let residual = |marker: &usize, spot: &Point2| {
            let track = &tracker.tracks[*marker];
            let blob = tracker.find_spot(picture, *spot);
            blob.map_or(f64::INFINITY, |blob| track.template.compare_spot(picture, &blob, track.turn).mean)
        };
        let residuals = markers.iter().map(|k| spots.iter().map(|spot| residual(k, spot)).collect()).collect();
        Self { tracker, markers, spots, residuals }
    }

    /// The marker that is assigned to a spot.
    fn marker_at(&self, chosen: &[Option<usize>], at: Point2) -> Option<usize> {
        let owns = |spot: &Option<usize>| spot.is_some_and(|spot| distance(self.spots[spot], at) < SAME);
        chosen.iter().position(owns).map(|k| self.markers[k])
    }
}

impl Cost for Matching<'_> {
    fn place_count(&self) -> usize {
        self.spots.len()
    }

    /// Departure from the prediction and difference from the first view, squared, as shares of their limits.
    ///
    /// The departures are averaged over the markers: where prediction fails, it fails for all of them together.
    fn part_cost(&self, part: usize, place: Option<usize>) -> f64 {
        let Some(place) = place else { return MISSING };
        let set = &self.tracker.settings;
        let guesses = self.tracker.position_guesses(self.markers[part]);
        let [moved, stayed] = guesses.map(|near| distance(self.spots[place], near) / set.jump_limit);
        let departure = moved.min(stayed);
        let residual = self.residuals[part][place] / set.residual_limit;
        if departure > REACH || residual > 1.0 {
            return f64::INFINITY;
        }
        departure * departure / self.markers.len() as f64 + residual * residual
    }

    fn pair_cost(&self, parts: [usize; 2], places: [usize; 2]) -> f64 {
        self.tracker.pair_bending(parts.map(|part| self.markers[part]), places.map(|place| self.spots[place]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;

    const CLICKED: [Point2; 3] = [[50.0, 50.0], [92.0, 50.0], [134.0, 50.0]];

    /// Equal dark discs.
    fn discs(at: &[Point2]) -> Gray {
        Gray::from_fn(260, 100, |x, y| {
            let near = |p: &Point2| (x as f64 - p[0]).hypot(y as f64 - p[1]) < 9.0;
            if at.iter().any(near) { 40.0 } else { 200.0 }
        })
    }

    fn tracker() -> Tracker {
        Tracker::new(&discs(&CLICKED), &CLICKED, Settings { jump_limit: 60.0, ..Settings::default() }).unwrap()
    }

    /// What marker `k` would be found as at these places.
    fn found(tracker: &Tracker, picture: &Gray, at: [Point2; 3]) -> Vec<Result<Accepted, TrackingError>> {
        let one = |k: usize| {
            let expected = Expected { marker: k, frame: 1, near: at[k] };
            tracker
                .locate_marker(picture, &tracker.tracks[k], at[k])
                .map_err(|why| TrackingError::with_crop(picture, expected, why))
        };
        (0..3).map(one).collect()
    }

    fn places(found: &[Result<Accepted, TrackingError>]) -> Vec<Option<[i64; 2]>> {
        found.iter().map(|f| f.as_ref().ok().map(|s| s.observation.at.map(|c| c.round() as i64))).collect()
    }

    #[test]
    fn two_markers_that_were_exchanged_are_put_back() {
        let (tracker, picture) = (tracker(), discs(&CLICKED));
        for exchanged in [[0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0]] {
            let mut found = found(&tracker, &picture, exchanged.map(|k| CLICKED[k]));
            found.iter_mut().zip(exchanged).for_each(|(f, k)| {
                let seen = tracker.locate_marker(&picture, &tracker.tracks[k], CLICKED[k]).unwrap();
                *f = Ok(seen);
            });
            tracker.match_jointly(&picture, 1, &mut found);
            assert_eq!(places(&found), [50, 92, 134].map(|x| Some([x, 50])), "{exchanged:?}");
        }
    }

    #[test]
    fn where_no_neighbours_turn_about_each_other_nothing_is_measured_again() {
        let (tracker, picture) = (tracker(), discs(&CLICKED));
        let mut found = found(&tracker, &picture, CLICKED);
        // no spot lies there, so that a second measurement would change it
        found.iter_mut().flatten().for_each(|s| s.observation.at[1] += 25.0);
        tracker.match_jointly(&picture, 1, &mut found);
        assert_eq!(places(&found), [50, 92, 134].map(|x| Some([x, 75])));
    }

    #[test]
    fn the_place_that_belongs_to_another_is_given_back_to_it() {
        // all moved to the right by their distance; the first was found where the second belongs, the others were not found
        let tracker = tracker();
        let picture = discs(&[[92.0, 50.0], [134.0, 50.0], [176.0, 50.0]]);
        let mut found = found(&tracker, &picture, [[134.0, 50.0], [20.0, 20.0], [20.0, 20.0]]);
        tracker.match_jointly(&picture, 1, &mut found);
        assert_eq!(places(&found), [92, 134, 176].map(|x| Some([x, 50])));
    }

    #[test]
    fn a_marker_without_a_spot_does_not_keep_that_of_its_neighbour() {
        // the first is covered and was found in the second, which was not found
        let tracker = tracker();
        let picture = discs(&CLICKED[1..]);
        let mut found = found(&tracker, &picture, [CLICKED[1], [20.0, 20.0], CLICKED[2]]);
        assert!(found[0].is_ok() && found[1].is_err());
        tracker.match_jointly(&picture, 1, &mut found);
        assert_eq!(places(&found), [None, Some([92, 50]), Some([134, 50])]);
        assert!(matches!(found[0], Err(TrackingError { why: FailedGate::Merged { other: 1, .. }, .. })));
    }

    #[test]
    fn a_line_costs_its_turn_and_its_stretch_up_to_their_limits() {
        let tracker = tracker();
        let line = |length: f64, turn: f64| {
            let end = [50.0 + length * turn.cos(), 50.0 + length * turn.sin()];
            tracker.pair_bending([1, 0], [end, [50.0, 50.0]])
        };
        assert!(line(42.0, 0.0) < 1e-6);
        assert!((line(42.0, 0.8) - 0.64).abs() < 1e-3 && (line(42.0, -0.8) - 0.64).abs() < 1e-3);
        // a fifth longer or shorter, of a limit of 0.35
        for length in [0.8 * 42.0, 1.2 * 42.0] {
            assert!((line(length, 0.0) - (0.2_f64 / 0.35).powi(2)).abs() < 5e-3);
        }
        assert!([line(57.0, 0.0), line(27.0, 0.0), line(42.0, 1.6), line(42.0, 3.1)].iter().all(|c| c.is_infinite()));
    }
}
