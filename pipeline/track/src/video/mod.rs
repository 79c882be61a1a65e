//! Films: H.264 in an MP4, written and read as grey pictures without any system library; what else a camera makes, through an
//! `ffmpeg` that is found on the PATH, and folders of pictures.
//!
//! Luma is kept as it is coded, 0 … 255: what the writer is given is what the reader hands out, up to the loss of the
//! codec. Films of other cameras may use 16 … 235 of it; nothing in this crate depends on which.
//!
//! Stands on: openh264 (codec), mp4 (container). Never knows: what is filmed.
//! A new container or codec: one file here that hands out [`Frame`]s.

mod boxes;
mod error;
mod film;
mod folder;
mod index;
mod pipe;
mod reader;
mod turn;
mod writer;

pub use error::VideoError;
pub use film::Film;
pub use reader::Reader;
pub use turn::Quarter;
pub use writer::{Quality, Writer};

use crate::Gray;
use si::{Hertz, Second};

/// What a film says of itself.
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
    fn of((width, height): (usize, usize), times: &[Second]) -> Self {
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
    /// When it is shown, counted from the first frame.
    pub time: Second,
    /// Its luma.
    pub gray: Gray,
}
