//! Films: H.264 in an MP4, written and read as grey pictures without any system library.
//!
//! Luma is kept as it is coded, 0 … 255: what the writer is given is what the reader hands out, up to the loss of the
//! codec. Films of other cameras may use 16 … 235 of it; nothing in this crate depends on which.
//!
//! Stands on: openh264 (codec), mp4 (container). Never knows: what is filmed.
//! A new container or codec: one file here that hands out [`Frame`]s.

mod boxes;
mod error;
mod index;
mod reader;
mod writer;

pub use error::VideoError;
pub use reader::Reader;
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
