//! Films of another encoder: B-frames with their edit list, trimmed films, and the kinds of H.264 that are not decoded.

#![allow(clippy::unwrap_used)] // a test may unwrap

use std::path::{Path, PathBuf};
use track::video::{Feature, Frame, Reader, VideoError};

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
    for name in ["b_frames.mp4", "negative_shifts.mp4", "monochrome.mp4"] {
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

#[test]
fn each_kind_that_is_not_decoded_is_named_with_its_conversion() {
    for (name, expected, words) in [
        ("bits_10.mp4", Feature::BitDepth(10), "H.264 with 10 bits a sample"),
        ("chroma_422.mp4", Feature::Chroma("4:2:2"), "4:2:2"),
        ("chroma_444.mp4", Feature::Chroma("4:4:4"), "4:4:4"),
        ("interlaced.mp4", Feature::Interlaced, "-vf yadif"),
        ("lossless.mp4", Feature::Profile(244), "lossless"),
        ("fragments.mp4", Feature::Fragments, "fragments"),
    ] {
        let error = Reader::open(&film(name)).err().unwrap();
        assert!(matches!(&error, VideoError::Unsupported { feature, .. } if *feature == expected), "{error}");
        let said = error.to_string();
        for piece in [words, name, "why:", "do:  convert it with `ffmpeg -i ", "on the PATH"] {
            assert!(said.contains(piece), "`{piece}` is not in:\n{said}");
        }
    }
}
