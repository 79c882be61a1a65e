//! Pictures in, pixels and rays out: video, lens, board, markers, lamp.
//!
//! Pixels live in this crate alone. The centre of the picture's first pixel is (0, 0), x runs to the right and y down,
//! so a frame of 1280 × 720 spans −0.5 … 1279.5 and −0.5 … 719.5. Lengths of the world are metres.
//!
//! Stands on: `si`, kornia (optical flow), openh264 and mp4 (video), nalgebra (small matrices). Never knows: a specimen, a
//! trial, a card, or what its markers sit on. Paper: section IV.

pub mod board;
pub mod calibrate;
mod gray;
pub mod grid;
pub mod klt;
pub mod led;
pub mod lens;
pub mod pose;
pub mod shutter;
pub mod sight;
pub mod video;

pub use gray::{Gray, PictureError};
