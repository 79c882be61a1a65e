//! Markers are tracked to a small part of a pixel, and a lost marker is always an error.

#![allow(clippy::unwrap_used)]

mod noise;

use noise::Noise;
use si::Point2;
use track::Gray;
use track::klt::{FailedGate, Observation, Settings, Tracker, TrackingError};
use track::video::{Quality, Reader, Writer};

/// Samples along each side of a pixel at a marker's edge.
const FINE: usize = 8;

/// The shape of a marker, dark on light.
#[derive(Clone, Copy)]
enum Shape {
    /// Radius, px.
    Disc(f64),
    /// Half length and half width of its arms, px.
    Cross(f64, f64),
}

/// One marker as it lies in a frame.
#[derive(Clone, Copy)]
struct Mark {
    shape: Shape,
    at: Point2,
    turn: f64,
}

impl Mark {
    fn covers(&self, x: f64, y: f64) -> bool {
        let (dx, dy) = (x - self.at[0], y - self.at[1]);
        let (sine, cosine) = self.turn.sin_cos();
        let (u, v) = ((cosine * dx + sine * dy).abs(), (cosine * dy - sine * dx).abs());
        match self.shape {
            Shape::Disc(radius) => dx.hypot(dy) < radius,
            Shape::Cross(length, width) => (u < length && v < width) || (v < length && u < width),
        }
    }

    /// Share of the pixel (x, y) that it covers.
    fn share(&self, x: usize, y: usize) -> f64 {
        let fine = |v: usize, i: usize| v as f64 + (i as f64 + 0.5) / FINE as f64 - 0.5;
        let covered = (0..FINE * FINE).filter(|k| self.covers(fine(x, k % FINE), fine(y, k / FINE))).count();
        covered as f64 / (FINE * FINE) as f64
    }
}

/// A light ground that is unevenly lit, with the marks on it, light times `light`, and sensor noise (grey levels).
fn picture(size: (usize, usize), marks: &[Mark], light: f64, noise: f64, seed: u64) -> Gray {
    let mut random = Noise(seed);
    Gray::from_fn(size.0, size.1, |x, y| {
        let ground =
            175.0 + 0.03 * x as f64 - 0.04 * y as f64 + 3.0 * (x as f64 * 0.02).sin() * (y as f64 * 0.03).cos();
        let near = |m: &&Mark| (x as f64 - m.at[0]).abs() < 24.0 && (y as f64 - m.at[1]).abs() < 24.0;
        let dark: f64 = marks.iter().filter(near).map(|m| m.share(x, y)).sum();
        let deviate = if noise > 0.0 { noise * random.next() } else { 0.0 };
        light * ground * (1.0 - 0.75 * dark) + deviate
    })
}

const SMALL: (usize, usize) = (320, 240);

fn disc(at: Point2) -> Mark {
    Mark { shape: Shape::Disc(11.0), at, turn: 0.0 }
}

fn cross(at: Point2, turn: f64) -> Mark {
    Mark { shape: Shape::Cross(13.0, 3.0), at, turn }
}

fn away(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn a_picture_shifted_by_a_third_of_a_pixel_is_tracked_to_a_hundredth() {
    for shift in [[1.0 / 3.0, 0.0], [0.0, -1.0 / 3.0], [1.0 / 3.0, 2.0 / 3.0]] {
        let starts = [[100.2, 120.7], [200.0, 99.4]];
        let marks = |d: Point2| {
            [disc([starts[0][0] + d[0], starts[0][1] + d[1]]), cross([starts[1][0] + d[0], starts[1][1] + d[1]], 0.2)]
        };
        let mut tracker =
            Tracker::new(&picture(SMALL, &marks([0.0; 2]), 1.0, 0.0, 1), &starts, Settings::default()).unwrap();
        let first = tracker.observations().to_vec();
        let next = tracker.step(&picture(SMALL, &marks(shift), 1.0, 0.0, 1)).unwrap();
        for (a, b) in first.iter().zip(&next) {
            let moved = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
            assert!(away(moved, shift) < 0.01, "{moved:?} {shift:?}");
        }
    }
}

#[test]
fn a_click_eight_pixels_off_finds_its_marker() {
    let marks = [disc([100.2, 120.7]), cross([200.0, 99.4], 0.3)];
    let first = picture(SMALL, &marks, 1.0, 2.0, 1);
    for angle in [0.0, 1.0, 2.5, 4.0, 5.5_f64] {
        let clicks = marks.map(|m| [m.at[0] + 7.9 * angle.cos(), m.at[1] + 7.9 * angle.sin()]);
        let tracker = Tracker::new(&first, &clicks, Settings::default()).unwrap();
        for (observation, mark) in tracker.observations().iter().zip(&marks) {
            assert!(away(observation.at, mark.at) < 0.05, "{angle}: {:?} {:?}", observation.at, mark.at);
        }
    }
}

#[test]
fn a_click_on_empty_ground_or_far_from_a_marker_is_refused() {
    let first = picture(SMALL, &[disc([100.0, 120.0])], 1.0, 2.0, 1);
    let refused = |click| Tracker::new(&first, &[[100.0, 120.0], click], Settings::default()).err().unwrap();
    assert!(matches!(
        refused([220.0, 80.0]),
        TrackingError { marker: 1, frame: 0, why: FailedGate::LowContrast { .. }, .. }
    ));
    assert!(matches!(refused([113.0, 120.0]).why, FailedGate::FarFromClick { .. }));
    assert!(matches!(refused([103.0, 120.0]).why, FailedGate::Merged { other: 0, .. }));
    assert!(matches!(refused([5.0, 120.0]).why, FailedGate::LeavesFrame { .. }));
}

/// Tracks marks that move by `motion` over `frames` frames; returns the root mean square miss, px, of each, and the last observations.
fn follow(
    frames: usize,
    noise: f64,
    light: impl Fn(usize) -> f64,
    motion: impl Fn(usize) -> Vec<Mark>,
) -> Result<(f64, Vec<Observation>), TrackingError> {
    let at = |k: usize| picture(SMALL, &motion(k), light(k), noise, k as u64 + 1);
    let clicks: Vec<Point2> = motion(0).iter().map(|m| m.at).collect();
    let mut tracker = Tracker::new(&at(0), &clicks, Settings::default())?;
    let (mut squares, mut number, mut last) = (0.0, 0.0, Vec::new());
    for k in 1..frames {
        last = tracker.step(&at(k))?;
        for (observation, mark) in last.iter().zip(motion(k)) {
            squares += away(observation.at, mark.at).powi(2);
            number += 1.0;
        }
    }
    Ok(((squares / number).sqrt(), last))
}

#[test]
fn nothing_drifts_over_three_hundred_frames() {
    let place = |k: usize| {
        let t = k as f64 / 60.0;
        [160.0 + 70.0 * (8.0 * t).sin(), 120.0 + 30.0 * (5.0 * t).cos()]
    };
    let (rms, last) = follow(300, 2.0, |_| 1.0, |k| vec![disc(place(k))]).unwrap();
    assert!(rms < 0.03, "{rms}");
    assert!(away(last[0].at, place(299)) < 0.1);
}

#[test]
fn a_cross_that_turns_by_seventy_degrees_keeps_its_middle_and_its_likeness() {
    let turned = |k: usize| vec![cross([160.3 + 2.0 * k as f64, 120.8], 0.61 * (k as f64 / 30.0).cos())];
    let (rms, last) = follow(50, 1.0, |_| 1.0, turned).unwrap();
    assert!(rms < 0.03, "{rms}");
    assert!(last[0].residual < 5.0, "{}", last[0].residual);
}

#[test]
fn a_change_of_brightness_moves_nothing() {
    let light = |k: usize| 1.0 + 0.3 * (k as f64 * 0.15).sin();
    let (rms, last) =
        follow(60, 1.0, light, |k| vec![disc([120.0 + k as f64, 110.4]), cross([220.0, 80.0 + k as f64], 0.1)])
            .unwrap();
    assert!(rms < 0.03, "{rms}");
    assert!(last.iter().all(|s| s.residual < 5.0));
}

#[test]
fn twelve_pixels_a_frame_are_followed() {
    let place = |k: usize| {
        vec![
            disc([160.0 + 95.0 * (0.126 * k as f64).sin(), 120.0]),
            cross([160.0, 60.0 + 20.0 * (0.2 * k as f64).sin()], 0.0),
        ]
    };
    let (rms, _) = follow(120, 1.0, |_| 1.0, place).unwrap();
    assert!(rms < 0.03, "{rms}");
}

#[test]
fn a_hidden_marker_is_lost_by_name_frame_and_limit() {
    let show = |k: usize| {
        let mut frame = picture(SMALL, &[disc([80.0, 100.0]), disc([200.0, 100.0 + k as f64])], 1.0, 1.0, k as u64);
        if k >= 7 {
            for y in 60..200 {
                frame.pixels[y * SMALL.0 + 190..y * SMALL.0 + 250].fill(190);
            }
        }
        frame
    };
    let mut tracker = Tracker::new(&show(0), &[[80.0, 100.0], [200.0, 100.0]], Settings::default()).unwrap();
    let lost = (1..20).find_map(|k| tracker.step(&show(k)).err()).unwrap();
    assert_eq!((lost.marker, lost.frame), (1, 7));
    let text = lost.to_string();
    assert!(text.starts_with("marker 1 is lost at frame 7") && text.contains("limit"), "{text}");
}

#[test]
fn a_marker_half_covered_by_glare_is_lost() {
    let show = |k: usize| {
        let mut frame = picture(SMALL, &[disc([160.0, 120.0])], 1.0, 1.0, k as u64);
        for y in 100..140 {
            let cover = (k * 2).min(22);
            frame.pixels[y * SMALL.0 + 140..y * SMALL.0 + 140 + cover].fill(250);
        }
        frame
    };
    let mut tracker = Tracker::new(&show(0), &[[160.0, 120.0]], Settings::default()).unwrap();
    let lost = (1..30).find_map(|k| tracker.step(&show(k)).err()).unwrap();
    assert!(
        matches!(
            lost.why,
            FailedGate::HighResidual { .. } | FailedGate::FlowCentroid { .. } | FailedGate::DarkRim { .. }
        ),
        "{lost}"
    );
}

#[test]
fn a_marker_that_leaves_the_frame_is_lost_there() {
    let error = follow(80, 1.0, |_| 1.0, |k| vec![disc([200.0 + 2.0 * k as f64, 120.0])]).unwrap_err();
    assert!(matches!(error.why, FailedGate::LeavesFrame { .. }), "{error}");
    assert!((40..50).contains(&error.frame), "{error}");
}

#[test]
fn a_leap_is_refused() {
    let error = follow(10, 0.0, |_| 1.0, |k| vec![disc([100.0 + if k < 5 { 0.0 } else { 28.0 }, 120.0])]).unwrap_err();
    assert_eq!(error.frame, 5);
}

/// Three markers at a tail's rear half as it flaps at 4 Hz, turning with it.
fn flapping(k: usize) -> [Mark; 3] {
    let phase = std::f64::consts::TAU * 4.0 * k as f64 / 60.0;
    let mark = |x: f64, amplitude: f64, turn: f64, lag: f64| {
        let (s, c) = ((phase - lag).sin(), (phase - lag).cos());
        cross([x + 4.0 * c, 140.3 + amplitude * s], turn * c)
    };
    [mark(120.4, 12.0, 0.2, 0.0), mark(260.1, 19.0, 0.4, 0.4), mark(403.7, 27.0, 0.61, 0.8)]
}

#[test]
fn a_flapping_tail_is_tracked_to_a_tenth_of_a_pixel_through_the_codec() {
    let file = std::env::temp_dir().join(format!("track-{}-flap.mp4", std::process::id()));
    let frames = 60;
    let mut writer = Writer::create(&file, (512, 288), 60.0, Quality::Quantiser(20)).unwrap();
    (0..frames).for_each(|k| writer.push(&picture((512, 288), &flapping(k), 1.0, 2.0, k as u64 + 1)).unwrap());
    writer.finish().unwrap();
    let mut reader = Reader::open(&file).unwrap();
    let first = reader.next().unwrap().unwrap().gray;
    let clicks = flapping(0).map(|m| [m.at[0] + 5.0, m.at[1] - 5.0]);
    let mut tracker = Tracker::new(&first, &clicks, Settings::default()).unwrap();
    let (mut squares, mut inside, mut number) = (0.0, 0, 0);
    for frame in reader {
        let frame = frame.unwrap();
        for (s, mark) in tracker.step(&frame.gray).unwrap().iter().zip(flapping(frame.index)) {
            let miss = [s.at[0] - mark.at[0], s.at[1] - mark.at[1]];
            squares += miss[0] * miss[0] + miss[1] * miss[1];
            inside += usize::from(miss[0].abs() < 1.96 * s.covariance[0][0].sqrt());
            inside += usize::from(miss[1].abs() < 1.96 * s.covariance[1][1].sqrt());
            number += 1;
        }
    }
    let _ = std::fs::remove_file(&file);
    let rms = (squares / f64::from(number)).sqrt();
    assert!(rms < 0.1, "{rms}");
    // 95 % intervals of 118 observations a marker, which share their scatter: 88 to 99.5 %
    let share = f64::from(inside as u32) / f64::from(2 * number);
    assert!((0.88..0.995).contains(&share), "{share}");
}

#[test]
fn a_window_too_small_for_a_marker_and_a_picture_that_lacks_grey_levels_are_refused() {
    let marks = [disc([100.0, 120.0])];
    let first = picture(SMALL, &marks, 1.0, 2.0, 1);
    for radius in [1.0, 0.0, -3.0, f64::NAN, f64::INFINITY] {
        let error = Tracker::new(&first, &[marks[0].at], Settings { radius, ..Settings::default() }).err().unwrap();
        assert!(matches!(error.why, FailedGate::SmallWindow { limit: 4.0, .. }), "{error}");
    }
    let mut cut = first.clone();
    cut.pixels.truncate(1000);
    let error = Tracker::new(&cut, &[marks[0].at], Settings::default()).err().unwrap();
    assert!(matches!(error.why, FailedGate::Levels { levels: 1000, .. }), "{error}");
    let mut tracker = Tracker::new(&first, &[marks[0].at], Settings::default()).unwrap();
    let error = tracker.step(&cut).unwrap_err();
    assert!(error.frame == 1 && matches!(error.why, FailedGate::Levels { .. }), "{error}");
    assert!(tracker.step(&first).is_ok(), "the next whole picture is tracked");
    let region = [0.0, 0.0, 200.0, 200.0];
    assert!(track::klt::find_blobs(&cut, region, 1, &Settings::default()).is_empty());
    assert!(track::klt::find_corners(&cut, region, 1, &Settings::default()).is_empty());
    let board = track::board::Board { columns: 9, rows: 6, square: 0.01 };
    let error = track::board::find(&cut, &board).unwrap_err();
    assert!(matches!(error, track::board::BoardError::Levels { levels: 1000, .. }), "{error}");
}
