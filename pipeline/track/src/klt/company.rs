//! Markers keep company: on one body, two that are near each other neither meet nor part from one frame to the next.
//!
//! Stands on: the gates of one marker. Never knows: what a marker looks like.

use super::lost::{Lost, Why};
use super::{Seen, Track, Tracker, distance};
use crate::Gray;
use si::Point2;

/// How many of a marker's nearest it keeps company with.
const NEAREST: usize = 2;

impl Tracker {
    /// Of two markers that were found in one place, the one that came farther from where it was expected is not there.
    pub(super) fn part(&self, picture: &Gray, frame: usize, found: &mut [Result<Seen, Lost>]) {
        let limit = self.settings.radius;
        for one in 0..found.len() {
            for other in 0..one {
                let (Ok(a), Ok(b)) = (&found[one], &found[other]) else { continue };
                let measured = distance(a.sighting.at, b.sighting.at);
                if measured < limit {
                    let strayed = |k: usize, at: Point2| distance(at, self.tracks[k].expected());
                    let farther = strayed(one, a.sighting.at) >= strayed(other, b.sighting.at);
                    let (marker, other) = if farther { (one, other) } else { (other, one) };
                    let why = Why::Merged { other, measured, limit };
                    found[marker] = Err(Lost::at(picture, marker, frame, self.tracks[marker].at, why));
                }
            }
        }
    }

    /// Of two neighbours whose distance leaps, the one that came farther from where it was expected is not there.
    pub(super) fn keep_company(&self, picture: &Gray, frame: usize, found: &mut [Result<Seen, Lost>]) {
        while let Some((one, other, measured)) = self.leap(found) {
            let strayed =
                |k: usize| found[k].as_ref().map_or(0.0, |s| distance(s.sighting.at, self.tracks[k].expected()));
            let (marker, other) = if strayed(one) >= strayed(other) { (one, other) } else { (other, one) };
            let why = Why::Strayed { other, measured, limit: self.settings.company_limit };
            found[marker] = Err(Lost::at(picture, marker, frame, self.tracks[marker].at, why));
        }
    }

    /// The two neighbours whose distance changed most since the frame before, and by which share, where that is too much.
    fn leap(&self, found: &[Result<Seen, Lost>]) -> Option<(usize, usize, f64)> {
        let at = |k: usize| found[k].as_ref().ok().map(|s| s.sighting.at);
        let each = (0..found.len()).filter_map(|one| Some((one, at(one)?)));
        let pairs = each.flat_map(|(one, there)| {
            let near = self.neighbours(one).into_iter().filter_map(move |other| Some((other, at(other)?)));
            near.filter_map(move |(other, place)| Some((one, other, self.change([one, other], [there, place])?)))
        });
        pairs.filter(|pair| pair.2 > self.settings.company_limit).max_by(|a, b| a.2.total_cmp(&b.2))
    }

    /// By which share the distance of two markers changed since the frame before; nothing to say when one was hidden then.
    fn change(&self, [one, other]: [usize; 2], now: [Point2; 2]) -> Option<f64> {
        let (one, other) = (&self.tracks[one], &self.tracks[other]);
        let known = one.hidden.is_none() && other.hidden.is_none();
        known.then(|| (distance(now[0], now[1]) / distance(one.at, other.at) - 1.0).abs())
    }

    /// The markers nearest to one, nearest first.
    fn neighbours(&self, marker: usize) -> Vec<usize> {
        let away = |k: &usize| distance(self.tracks[*k].at, self.tracks[marker].at);
        let mut others: Vec<usize> = (0..self.tracks.len()).filter(|k| *k != marker).collect();
        others.sort_by(|a, b| away(a).total_cmp(&away(b)));
        others.truncate(NEAREST);
        others
    }

    /// Looks again for markers that were missed, where they are if they moved and turned as their neighbours did.
    pub(super) fn retry(&self, picture: &Gray, found: &mut [Result<Seen, Lost>]) {
        for marker in 0..found.len() {
            let track = &self.tracks[marker];
            if found[marker].is_ok() || track.hidden.is_some() {
                continue;
            }
            let seen = found.iter().zip(&self.tracks).filter_map(|(f, t)| Some((f.as_ref().ok()?.sighting.at, t)));
            let mut seen: Vec<(Point2, &Track)> = seen.filter(|(_, t)| t.hidden.is_none()).collect();
            seen.sort_by(|a, b| distance(a.1.at, track.at).total_cmp(&distance(b.1.at, track.at)));
            let Some(guess) = carried(track, &seen) else { continue };
            let Ok(again) = self.sight(picture, track, guess) else { continue };
            let place = again.sighting.at;
            let free = seen.iter().all(|(at, _)| distance(*at, place) >= self.settings.radius);
            let near = self.neighbours(marker).into_iter();
            let mut near = near.filter_map(|k| self.change([marker, k], [place, found[k].as_ref().ok()?.sighting.at]));
            if free && near.all(|change| change <= self.settings.company_limit) {
                found[marker] = Ok(again);
            }
        }
    }

    /// Refuses two tracks on one marker.
    pub(super) fn apart(&self) -> Result<(), Lost> {
        let seen = |(_, track): &(usize, &Track)| track.hidden.is_none();
        for (marker, track) in self.tracks.iter().enumerate().filter(seen) {
            for (other, before) in self.tracks[..marker].iter().enumerate().filter(seen) {
                let (measured, limit) = (distance(track.at, before.at), self.settings.radius);
                if measured < limit {
                    let why = Why::Merged { other, measured, limit };
                    return Err(Lost::at(&self.before, marker, self.frame, track.at, why));
                }
            }
        }
        Ok(())
    }
}

/// Where a marker is if it moved with the nearest of those seen (px now, and as it was before), and turned about it as the next did.
fn carried(track: &Track, seen: &[(Point2, &Track)]) -> Option<Point2> {
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
    fn a_marker_that_leaps_from_its_neighbours_is_not_there_and_the_others_are() {
        let picture = three();
        let tracker =
            Tracker::new(&picture, &[[50.0, 50.0], [110.0, 50.0], [170.0, 50.0]], Settings::default()).unwrap();
        let found = |by: f64| {
            let seen = |(k, track): (usize, &Track)| {
                let mut seen = tracker.sight(&picture, track, track.at).unwrap();
                seen.sighting.at[0] += if k == 2 { by } else { 0.0 };
                Ok(seen)
            };
            let mut found: Vec<Result<Seen, Lost>> = tracker.tracks.iter().enumerate().map(seen).collect();
            tracker.keep_company(&picture, 1, &mut found);
            found.iter().map(Result::is_ok).collect::<Vec<_>>()
        };
        // 60 px apart: a third of that may come or go, more may not
        assert_eq!((found(15.0), found(30.0)), (vec![true; 3], vec![true, true, false]));
    }

    #[test]
    fn a_missed_marker_is_sought_where_its_neighbours_turn_and_motion_carry_it() {
        let picture = three();
        let tracker =
            Tracker::new(&picture, &[[50.0, 50.0], [110.0, 50.0], [170.0, 50.0]], Settings::default()).unwrap();
        let [first, second, third] = &tracker.tracks[..] else { panic!("three were clicked") };
        // a quarter turn about the first, which moved by (5, 7)
        let turned = |track: &Track| [first.at[0] + 5.0, first.at[1] + 7.0 + track.at[0] - first.at[0]];
        let guess = carried(third, &[(turned(second), second), (turned(first), first)]).unwrap();
        assert!(distance(guess, turned(third)) < 0.1, "{guess:?}");
        assert!(carried(third, &[]).is_none());
    }
}
