//! Films are read as they were written, and damaged ones are refused with the frame.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use track::Gray;
use track::video::{Quality, Reader, VideoError, Writer};

const RATE: f64 = 60.0;

/// A file of its own for each test, gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("track-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A light ground with a soft pattern and a dark disc that moves by 3 px a frame; its level encodes the frame's number.
fn scene(width: usize, height: usize, frame: usize) -> Gray {
    let centre = [40.0 + 3.0 * frame as f64 % (width as f64 - 80.0), height as f64 / 2.0];
    Gray::from_fn(width, height, |x, y| {
        let away = (x as f64 - centre[0]).hypot(y as f64 - centre[1]);
        let ground = 190.0 + 20.0 * (x as f64 * 0.05).sin() * (y as f64 * 0.07).cos();
        let disc = 40.0 + (frame % 50) as f64;
        ground + (disc - ground) * (12.5 - away).clamp(0.0, 1.0)
    })
}

/// Writes `frames` pictures of the scene.
fn film(path: &Path, width: usize, height: usize, frames: usize, quality: Quality) {
    let mut writer = Writer::create(path, (width, height), RATE, quality).unwrap();
    for frame in 0..frames {
        writer.push(&scene(width, height, frame)).unwrap();
    }
    writer.finish().unwrap();
}

fn mean_difference(a: &Gray, b: &Gray) -> f64 {
    let sum: u64 = a.pixels.iter().zip(&b.pixels).map(|(&a, &b)| u64::from(a.abs_diff(b))).sum();
    sum as f64 / a.pixels.len() as f64
}

#[test]
fn every_frame_comes_back_in_order_and_close_to_what_was_written() {
    let file = Scratch::new("round.mp4");
    film(&file.0, 640, 360, 150, Quality::Quantiser(18));
    let reader = Reader::open(&file.0).unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height, info.frames), (640, 360, 150));
    assert!((info.rate - RATE).abs() < 1e-9);
    let mut count = 0;
    for frame in reader {
        let frame = frame.unwrap();
        assert_eq!(frame.index, count);
        assert!((frame.time - count as f64 / RATE).abs() < 1e-9);
        let away = mean_difference(&frame.gray, &scene(640, 360, count));
        assert!(away < 1.0, "frame {count} differs by {away} grey levels a pixel");
        count += 1;
    }
    assert_eq!(count, 150);
}

#[test]
fn black_and_white_keep_their_full_range() {
    let file = Scratch::new("range.mp4");
    let picture = Gray::from_fn(64, 64, |x, _| if x < 32 { 0.0 } else { 255.0 });
    let mut writer = Writer::create(&file.0, (64, 64), 30.0, Quality::Quantiser(12)).unwrap();
    writer.push(&picture).unwrap();
    writer.finish().unwrap();
    let back = Reader::open(&file.0).unwrap().next().unwrap().unwrap().gray;
    assert!(back.pixel_level(8, 32) <= 1.0 && back.pixel_level(56, 32) >= 254.0);
}

#[test]
fn equal_pictures_make_equal_files() {
    let files = [Scratch::new("once.mp4"), Scratch::new("twice.mp4")];
    let bytes = files.each_ref().map(|file| {
        film(&file.0, 320, 192, 30, Quality::BitsPerSecond(2_000_000));
        std::fs::read(&file.0).unwrap()
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn a_bit_rate_too_low_for_the_scene_still_loses_no_frame() {
    let file = Scratch::new("poor.mp4");
    film(&file.0, 320, 192, 60, Quality::BitsPerSecond(60_000));
    assert_eq!(Reader::open(&file.0).unwrap().map(Result::unwrap).count(), 60);
}

#[test]
fn a_lower_quality_makes_a_smaller_film() {
    let size = |quality| {
        let file = Scratch::new("size.mp4");
        film(&file.0, 320, 192, 30, quality);
        std::fs::metadata(&file.0).unwrap().len()
    };
    assert!(size(Quality::Quantiser(32)) < size(Quality::Quantiser(20)));
}

#[test]
fn a_film_without_its_last_bytes_is_refused() {
    let file = Scratch::new("cut.mp4");
    film(&file.0, 320, 192, 40, Quality::Quantiser(20));
    let whole = std::fs::read(&file.0).unwrap();
    for keep in [whole.len() - 1, whole.len() / 2, 60] {
        std::fs::write(&file.0, &whole[..keep]).unwrap();
        assert!(matches!(Reader::open(&file.0), Err(VideoError::NoIndex { bytes, .. }) if bytes == keep as u64));
    }
}

/// The same film with its index in front, as cameras and web tools lay it, so that a cut leaves the index whole.
fn index_in_front(film: &[u8]) -> Vec<u8> {
    let place = |name: &[u8; 4]| film.windows(4).position(|w| w == name).unwrap() - 4;
    let (data, index) = (place(b"mdat"), place(b"moov"));
    let mut moov = film[index..].to_vec();
    let table = moov.windows(4).position(|w| w == b"stco").unwrap() + 8;
    let number = |bytes: &[u8], at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    for i in 0..number(&moov, table) as usize {
        let at = table + 4 + 4 * i;
        let moved = number(&moov, at) + moov.len() as u32;
        moov[at..at + 4].copy_from_slice(&moved.to_be_bytes());
    }
    [&film[..data], &moov, &film[data..index]].concat()
}

#[test]
fn a_film_cut_behind_its_index_is_refused_with_the_frame_at_which_it_ends() {
    let file = Scratch::new("front.mp4");
    film(&file.0, 320, 192, 40, Quality::Quantiser(20));
    let front = index_in_front(&std::fs::read(&file.0).unwrap());
    std::fs::write(&file.0, &front).unwrap();
    assert_eq!(Reader::open(&file.0).unwrap().map(Result::unwrap).count(), 40);
    std::fs::write(&file.0, &front[..front.len() - 200]).unwrap();
    let error = Reader::open(&file.0).err().unwrap();
    assert!(matches!(error, VideoError::Truncated { frame: 35..=39, expected: 40, .. }), "{error}");
    assert!(error.to_string().contains("of 40"), "{error}");
}

#[test]
fn what_is_no_film_is_refused_with_its_reason() {
    let file = Scratch::new("none.mp4");
    assert!(matches!(Reader::open(&file.0), Err(VideoError::NotFound { .. })));
    std::fs::write(&file.0, b"time,pressure\n0.0,12.5\n").unwrap();
    assert!(matches!(Reader::open(&file.0), Err(VideoError::NotMp4 { .. })));
    std::fs::write(&file.0, b"").unwrap();
    assert!(matches!(Reader::open(&file.0), Err(VideoError::NotMp4 { .. })));
}

#[test]
fn another_codec_is_refused_by_its_name() {
    let file = Scratch::new("codec.mp4");
    film(&file.0, 320, 192, 3, Quality::Quantiser(20));
    let mut bytes = std::fs::read(&file.0).unwrap();
    let at = bytes.windows(4).rposition(|w| w == b"avc1").unwrap();
    bytes[at..at + 4].copy_from_slice(b"hvc1");
    std::fs::write(&file.0, &bytes).unwrap();
    let error = Reader::open(&file.0).err().unwrap();
    assert!(matches!(&error, VideoError::UnknownCodec { codec, .. } if codec == "hvc1"), "{error}");
    assert!(error.to_string().contains("ffmpeg"));
}

#[test]
fn damaged_frames_are_never_passed_over() {
    let file = Scratch::new("damage.mp4");
    film(&file.0, 320, 192, 40, Quality::Quantiser(20));
    let mut bytes = std::fs::read(&file.0).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 40].fill(0xff);
    std::fs::write(&file.0, &bytes).unwrap();
    let last = Reader::open(&file.0).unwrap().last().unwrap();
    assert!(matches!(last, Err(VideoError::Damaged { expected: 40, .. })));
}

#[test]
fn a_film_of_odd_size_is_refused_before_it_is_begun() {
    let file = Scratch::new("odd.mp4");
    assert!(matches!(Writer::create(&file.0, (321, 192), RATE, Quality::Quantiser(20)), Err(VideoError::Unfit { .. })));
    assert!(!file.0.exists());
}
