//! Films whose boxes cannot be right are refused soon and with their reason; unusual but valid boxes are read.

#![allow(clippy::unwrap_used)] // a test may unwrap

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use track::video::{Frame, Reader, VideoError};

/// A film of 2 kB is opened in 1 ms; the rest is for a busy computer.
const SOON: Duration = Duration::from_secs(2);

/// The films of a folder of test data, in the order of their names.
fn films(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder);
    let mut films: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    films.sort();
    assert!(!films.is_empty());
    films
}

/// Reads a film to its end or first error.
fn read(path: &Path) -> Result<Vec<Frame>, VideoError> {
    Reader::open(path)?.collect()
}

#[test]
fn films_with_impossible_boxes_are_refused_soon_and_with_their_reason() {
    for path in films("broken") {
        let start = Instant::now();
        let error = read(&path).unwrap_err();
        assert!(start.elapsed() < SOON, "{} takes {:?}", path.display(), start.elapsed());
        let said = error.to_string();
        for piece in [&path.display().to_string(), "\n  why: ", "\n  do:  "] {
            assert!(said.contains(piece), "`{piece}` is not in:\n{said}");
        }
        assert!(said.contains("at byte "), "the box and its place are not in:\n{said}");
    }
}

#[test]
fn boxes_of_size_zero_and_terminators_are_read() {
    for path in films("unusual") {
        let frames = read(&path).unwrap();
        assert_eq!(frames.len(), 12, "{}", path.display());
    }
}

/// A film with one byte changed is read or refused, but neither loops nor panics: every byte of the index, with the values that sizes
/// and counts are sensitive to.
#[test]
fn no_single_byte_of_the_index_makes_the_reader_loop_or_panic() {
    let whole = std::fs::read(&films("unusual")[0]).unwrap();
    let index = whole.windows(4).rposition(|name| name == b"moov").unwrap() - 4;
    let path = std::env::temp_dir().join(format!("track-broken-{}.mp4", std::process::id()));
    let start = Instant::now();
    for at in index..whole.len() {
        for value in [0, 1, 7, 0x7f, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] = value;
            std::fs::write(&path, &bytes).unwrap();
            let _ = Reader::open(&path);
        }
    }
    std::fs::remove_file(&path).unwrap();
    // 3400 films of 2 kB: 0.3 s on a free core
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}
