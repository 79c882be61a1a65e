//! Edit lists: films that were trimmed, delayed or joined by their index alone.

#![allow(clippy::unwrap_used)] // a test may unwrap

mod patch;

use std::path::PathBuf;
use track::Gray;
use track::video::{Film, Frame, Quality, VideoError, Writer};

const FRAMES: usize = 24;
/// Ticks of one frame of the writer's clocks at 60 frames/s, which are the same for film and track.
const TICKS: u32 = 1000;
const EMPTY: u32 = u32::MAX;
const NORMAL: u32 = 1 << 16;

/// A film with an edit list of (duration, media time, rate), gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, list: &[[u32; 3]]) -> Self {
        let path = std::env::temp_dir().join(format!("edits-{}-{name}.mp4", std::process::id()));
        let mut writer = Writer::create(&path, (64, 48), 60.0, Quality::Quantiser(18)).unwrap();
        (0..FRAMES).for_each(|k| writer.push(&Gray::filled(64, 48, 40 + 8 * k as u8)).unwrap());
        writer.finish().unwrap();
        let elst = patch::boxed(b"elst", &[&[0, list.len() as u32], list.as_flattened()].concat());
        let edts = [&(elst.len() as u32 + 8).to_be_bytes(), &b"edts"[..], &elst].concat();
        let film = patch::append(std::fs::read(&path).unwrap(), &[b"moov", b"trak"], &edts);
        std::fs::write(&path, film).unwrap();
        Self(path)
    }

    fn frames(&self) -> Vec<Frame> {
        let film = Film::open(&self.0).unwrap();
        let info = film.info();
        let frames: Vec<Frame> = film.map(Result::unwrap).collect();
        assert_eq!(info.frames, frames.len());
        assert!(frames.len() < 2 || (info.rate - 60.0).abs() < 1e-6, "{} frames/s", info.rate);
        frames
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The first and last of the written pictures that a film displays; those between follow each other.
fn ends(frames: &[Frame]) -> (usize, usize) {
    let number = |frame: &Frame| ((f64::from(frame.gray.pixels[0]) - 40.0) / 8.0).round() as usize;
    let first = number(&frames[0]);
    for (k, frame) in frames.iter().enumerate() {
        assert_eq!((frame.index, number(frame)), (k, first + k));
    }
    (first, first + frames.len() - 1)
}

#[test]
fn frames_in_front_of_the_edit_are_none_of_the_film() {
    let frames = Scratch::new("start", &[[0, 7 * TICKS, NORMAL]]).frames();
    assert_eq!(ends(&frames), (7, 23));
    assert!(frames[0].time == 0.0 && (frames[16].time - 16.0 / 60.0).abs() < 1e-9);
}

#[test]
fn the_duration_of_the_edit_ends_the_film() {
    assert_eq!(ends(&Scratch::new("end", &[[10 * TICKS, 7 * TICKS, NORMAL]]).frames()), (7, 16));
    assert_eq!(ends(&Scratch::new("one", &[[TICKS, 0, NORMAL]]).frames()), (0, 0));
    assert_eq!(ends(&Scratch::new("whole", &[[24 * TICKS, 0, NORMAL]]).frames()), (0, 23));
}

#[test]
fn an_empty_edit_in_front_delays_the_film() {
    let frames = Scratch::new("delay", &[[30 * TICKS, EMPTY, NORMAL], [0, 2 * TICKS, NORMAL]]).frames();
    assert_eq!(ends(&frames), (2, 23));
    assert!((frames[0].time - 0.5).abs() < 1e-9 && (frames[1].time - 0.5 - 1.0 / 60.0).abs() < 1e-9);
}

#[test]
fn parts_that_are_joined_are_refused_with_what_to_do() {
    let film = Scratch::new("parts", &[[5 * TICKS, 0, NORMAL], [5 * TICKS, 9 * TICKS, NORMAL]]);
    let error = Film::open(&film.0).err().unwrap();
    assert!(matches!(error, VideoError::Edits { .. }), "{error}");
    assert!(error.to_string().contains("joins 2 parts") && error.to_string().contains("ffmpeg -i"), "{error}");
}

#[test]
fn an_edit_behind_the_last_frame_is_refused() {
    let film = Scratch::new("behind", &[[0, 24 * TICKS, NORMAL]]);
    let said = Film::open(&film.0).err().unwrap().to_string();
    assert!(said.contains("none of its 24 frames"), "{said}");
}
