//! Films: H.264 in an MP4, written and read as grey pictures without any system library; other codecs through an
//! `ffmpeg` on the PATH; folders of pictures.
//!
//! Luma is passed on as it is coded, 0 … 255. Films of other cameras may use 16 … 235 of it; nothing in this crate depends on which.
//! A new container or codec needs one file here that yields [`Frame`]s.
//!
//! Films are untrusted. Sizes and counts in a header are held against the file and the limits of this crate before memory is reserved,
//! every loop over boxes, bits and frames advances, and a program that decodes has a time limit.

mod ahead;
mod avc;
mod boxes;
mod child;
mod edits;
mod error;
mod feature;
mod files;
mod film;
mod folder;
mod index;
mod outermost;
mod pipe;
mod reader;
mod sps;
mod stream;
mod tables;
mod turn;
mod writer;

pub use ahead::DecodedAhead;
pub use error::VideoError;
pub use feature::Feature;
pub use film::Film;
pub use reader::Reader;
pub use turn::Quarter;
pub use writer::{Quality, Writer};

use crate::Gray;
use crate::gray::Depth;
use si::{Hertz, Second};
use std::path::{Path, PathBuf};

/// The pictures (PNG, JPEG) of a folder in the natural order of their names; no times are needed.
///
/// # Errors
/// [`VideoError`] when the folder cannot be read.
pub fn picture_files(folder: &Path) -> Result<Vec<PathBuf>, VideoError> {
    folder::list_pictures(folder)
}

/// A picture by itself, with the levels of its own depth.
///
/// # Errors
/// [`VideoError`] when it cannot be read.
pub fn picture(file: &Path) -> Result<Gray, VideoError> {
    folder::read_picture(file, &mut Depth::default())
}

/// Metadata of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Info {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frames in the film.
    pub frames: usize,
    /// Mean number of frames a second.
    pub rate: Hertz,
}

impl Info {
    /// Of pictures of a size that are shown at these times (s).
    fn of_times((width, height): (usize, usize), times: &[Second]) -> Self {
        let span = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
        let rate = if span > 0.0 { (times.len() - 1) as f64 / span } else { 0.0 };
        Self { width, height, frames: times.len(), rate }
    }
}

/// One frame of a film, in the order of showing.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its number, from 0.
    pub index: usize,
    /// When it is shown, counted from the first frame; behind the delay of an edit list that begins with an empty edit.
    pub time: Second,
    /// Its luma.
    pub gray: Gray,
}
