//! From video to pixels and rays: reading films, marker tracking, camera calibration, refraction.
//!
//! | module | method |
//! |---|---|
//! | [`video`] | H.264 in MP4, folders of pictures and, through `ffmpeg`, other codecs |
//! | [`klt`] | pyramidal Lucas–Kanade flow with centroids, gates and covariances |
//! | [`board`], [`calibrate`], [`lens`], [`pose`] | calibration targets; homographies and bundle adjustment; Brown–Conrady and fisheye lenses |
//! | [`refraction`], [`shutter`], [`grid`] | rays through a water surface; rolling shutter; camera pose from a grid under the scene |
//! | [`led`], [`silhouette`] | brightness of a lamp; outline of a body |
//!
//! Pixels are used in this crate alone. The centre of a picture's first pixel is (0, 0), x runs to the right and y down,
//! so a frame of 1280 × 720 spans −0.5 … 1279.5 and −0.5 … 719.5. Lengths are metres.
//!
//! ```
//! use track::Gray;
//! use track::klt::{Settings, Tracker};
//!
//! // a dark disc that moves by 2.5 px to the right
//! let frame = |x0: f64| Gray::from_fn(160, 120, |x, y| if (x as f64 - x0).hypot(y as f64 - 60.0) < 10.0 { 40.0 } else { 180.0 });
//! let mut tracker = Tracker::new(&frame(70.0), &[[71.0, 58.0]], Settings::default())?;
//! let observations = tracker.step(&frame(72.5))?;
//! assert!((observations[0].at[0] - 72.5).abs() < 0.2);
//! # Ok::<(), track::klt::TrackingError>(())
//! ```
//!
//! Depends on `si`, `optimize` (Levenberg–Marquardt), kornia (optical flow), openh264 and, for writing, mp4 (video), nalgebra. Paper, section IV.

pub mod board;
pub mod calibrate;
mod gray;
pub mod grid;
pub mod imported;
pub mod klt;
pub mod led;
pub mod lens;
mod limits;
pub mod picture_size;
pub mod pose;
pub mod refraction;
pub mod scene;
pub mod shutter;
pub mod silhouette;
pub mod video;

pub use gray::{Gray, PictureError};
