//! Films of another encoder: B-frames with their edit list, and trimmed films.

#![allow(clippy::unwrap_used)] // a test may unwrap

use std::path::{Path, PathBuf};
use track::video::{Frame, Reader};

fn film(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/h264").join(name)
}

/// The frames of a film; the ground of frame N of the scene has the level 40 + 10 N.
fn frames(name: &str) -> Vec<Frame> {
    Reader::open(&film(name)).unwrap().map(Result::unwrap).collect()
}

/// The frame of the scene that each frame of a film displays, from the level of its first pixels.
fn numbers(frames: &[Frame]) -> Vec<usize> {
    let level = |frame: &Frame| frame.gray.pixels[..8].iter().map(|&p| f64::from(p)).sum::<f64>() / 8.0;
    frames.iter().map(|frame| ((level(frame) - 40.0) / 10.0).round() as usize).collect()
}

#[test]
fn films_with_frames_out_of_order_begin_at_zero_and_lose_none() {
    for name in ["b_frames.mp4", "negative_shifts.mp4"] {
        let frames = frames(name);
        assert_eq!(numbers(&frames), (0..12).collect::<Vec<_>>(), "{name}");
        for (k, frame) in frames.iter().enumerate() {
            assert!(
                frame.index == k && (frame.time - k as f64 / 30.0).abs() < 1e-9,
                "{name}: frame {k} at {} s",
                frame.time
            );
        }
    }
}

#[test]
fn a_trimmed_film_begins_with_its_first_displayed_frame() {
    let frames = frames("trimmed.mp4");
    assert_eq!(numbers(&frames), [6, 7, 8, 9, 10]);
    assert!(frames[0].index == 0 && frames[0].time == 0.0);
}
