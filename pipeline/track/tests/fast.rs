//! Markers that look alike and move between two frames by about their spacing keep their names.

#![allow(clippy::unwrap_used)] // a test may unwrap

mod noise;

use noise::Noise;
use si::Point2;
use track::Gray;
use track::klt::{FailedGate, Observation, Settings, Tracker, TrackingError};

/// Distance of neighbouring markers, px.
const SPACING: f64 = 42.0;

/// Settings of the study: a step may be longer than the spacing.
fn settings() -> Settings {
    Settings { jump_limit: 60.0, patience: 30, quantiser: 0, ..Settings::default() }
}

/// Six discs in a row that is turned by an angle (rad) about its first one and bends by as much again over its length.
fn tail([x, y]: Point2, turn: f64) -> Vec<Point2> {
    let mut at = [x, y];
    let next = |k: i32| {
        let here = at;
        let angle = turn * (1.0 + f64::from(k) / 5.0);
        at = [at[0] + SPACING * angle.cos(), at[1] + SPACING * angle.sin()];
        here
    };
    (0..6).map(next).collect()
}

/// A film of dark discs on light ground.
struct Scene(Box<dyn Fn(usize) -> Vec<Point2>>);

fn scene(marks: impl Fn(usize) -> Vec<Point2> + 'static) -> Scene {
    Scene(Box::new(marks))
}

impl Scene {
    fn places(&self, k: usize) -> Vec<Point2> {
        (self.0)(k)
    }

    /// Frame `k`; what `covered` names is not drawn.
    fn picture(&self, k: usize, covered: Option<usize>) -> Gray {
        let mut random = Noise(k as u64 + 1);
        let shown = |(marker, at)| (Some(marker) != covered).then_some(at);
        let marks: Vec<Point2> = self.places(k).into_iter().enumerate().filter_map(shown).collect();
        Gray::from_fn(480, 400, |x, y| {
            let share = |p: &Point2| (10.5 - (x as f64 - p[0]).hypot(y as f64 - p[1])).clamp(0.0, 1.0);
            178.0 * (1.0 - 0.75 * marks.iter().map(share).fold(0.0, f64::max)) + 1.4 * random.next()
        })
    }
}

/// The largest distance from the truth over `frames` frames, px; `None` where a marker was hidden.
fn worst(scene: &Scene, frames: usize) -> Result<Option<f64>, TrackingError> {
    let mut tracker = Tracker::new(&scene.picture(0, None), &scene.places(0), settings())?;
    let mut worst = Some(0.0_f64);
    for k in 1..frames {
        let seen: Vec<Observation> = tracker.step(&scene.picture(k, None))?;
        for (s, p) in seen.iter().zip(scene.places(k)) {
            let off = (s.at[0] - p[0]).hypot(s.at[1] - p[1]);
            worst = worst.filter(|_| s.seen).map(|w| w.max(off));
        }
    }
    tracker.finish()?;
    Ok(worst)
}

fn is_followed(scene: &Scene, frames: usize) {
    let worst = worst(scene, frames);
    assert!(worst.as_ref().is_ok_and(|w| w.is_some_and(|w| w < 0.15)), "{worst:?}");
}

#[test]
fn a_row_that_moves_along_itself_by_its_spacing_is_followed_either_way() {
    for way in [-1.0, 1.0] {
        is_followed(&scene(move |k| tail([135.3 + way * SPACING * f64::from(u8::from(k >= 5)), 150.2], 0.0)), 10);
    }
}

#[test]
fn a_row_that_moves_by_its_spacing_in_each_frame_from_rest_is_followed() {
    is_followed(&scene(|k| tail([60.3 + SPACING * k.saturating_sub(3) as f64, 150.2], 0.0)), 7);
}

#[test]
fn a_bent_tail_that_is_released_keeps_its_markers_though_its_end_moves_by_twice_their_spacing() {
    // the end swings by 104 px from frame 4 to 5, and back over the next ones as it rings
    let turn =
        |k: usize| if k < 5 { 0.25 } else { 0.25 * (2.2 * (k as f64 - 4.0)).cos() * (-0.3 * (k as f64 - 4.0)).exp() };
    let scene = scene(move |k| tail([80.3, 150.2], turn(k)));
    let end = [4, 5].map(|k| scene.places(k)[5]);
    assert!((end[0][0] - end[1][0]).hypot(end[0][1] - end[1][1]) > 2.0 * SPACING);
    is_followed(&scene, 20);
}

/// Frames in which the third marker of the row is covered.
const COVERED: std::ops::Range<usize> = 5..8;

/// Follows the row, which moves along itself by its spacing in frame `moved`; the third marker alone may be hidden, while it is covered.
fn is_followed_past_a_cover(moved: usize) {
    let shift = move |k: usize| SPACING * f64::from(u8::from(k >= moved));
    let scene = scene(move |k| tail([90.3 + shift(k), 150.2], 0.0));
    let picture = |k: usize| scene.picture(k, COVERED.contains(&k).then_some(2));
    let mut tracker = Tracker::new(&picture(0), &scene.places(0), settings()).unwrap();
    for k in 1..12 {
        let seen = tracker.step(&picture(k)).unwrap();
        let off = |(s, p): (&Observation, &Point2)| (s.at[0] - p[0]).hypot(s.at[1] - p[1]);
        assert!(seen.iter().zip(&scene.places(k)).all(|pair| !pair.0.seen || off(pair) < 0.15), "{k}: {seen:?}");
        let hidden: Vec<usize> = (0..6).filter(|m| !seen[*m].seen).collect();
        assert_eq!(hidden, if COVERED.contains(&k) { vec![2] } else { vec![] }, "{k}");
    }
}

#[test]
fn a_marker_that_is_covered_takes_no_other_place_as_its_row_moves_by_its_spacing() {
    // as it is covered first, while it is covered, and as it comes back
    [5, 6, 8].into_iter().for_each(is_followed_past_a_cover);
}

#[test]
fn a_step_beyond_the_reach_of_all_markers_together_is_refused() {
    let leap = |by: f64| worst(&scene(move |k| tail([60.3, 90.2 + if k < 5 { 0.0 } else { by }], 0.0)), 10);
    assert!(matches!(leap(110.0), Ok(Some(off)) if off < 0.15), "{:?}", leap(110.0));
    assert!(matches!(leap(130.0), Ok(None) | Err(TrackingError { frame: 5, .. })), "{:?}", leap(130.0));
}

#[test]
fn a_marker_that_leaves_the_motion_of_its_neighbours_is_refused() {
    // the last one alone moves on by more than the largest step
    let marks = |k: usize| {
        let mut row = tail([60.3, 150.2], 0.0);
        row[5][1] += if k < 5 { 0.0 } else { 70.0 };
        row
    };
    let set = Settings { patience: 0, ..settings() };
    let scene = scene(marks);
    let mut tracker = Tracker::new(&scene.picture(0, None), &scene.places(0), set).unwrap();
    let lost = (1..8).find_map(|k| tracker.step(&scene.picture(k, None)).err()).unwrap();
    assert_eq!((lost.marker, lost.frame), (5, 5));
    assert!(!matches!(lost.why, FailedGate::Merged { .. }), "{lost}");
}
