//! The data format of `data/raw`: specimen cards, pressure and force logs, marker trajectories, and the hidden truth of a
//! virtual bench.
//!
//! A specimen is a folder with `specimen.toml` (the card), `cad/`, `camera/` and
//! `trials/<trial>/{video.mp4, pressure.csv, force.csv, hammer.csv}`. All values are converted to SI and range-checked, so
//! that a wrong unit is refused with file, line and key. Everything that can be read can be written; the same data give the
//! same bytes.
//!
//! ```
//! use lab::pressure;
//! use std::path::Path;
//!
//! let text = "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n0.0,0,0,0.5,0,0\n0.1,200,0,180,0,1\n";
//! let channels = ["left".to_owned(), "right".to_owned()];
//! let log = pressure::parse(text, Path::new("pressure.csv"), &channels)?;
//! assert_eq!(log.channels[0].measured, [50.0, 18_000.0]);
//!
//! let wrong = pressure::parse(&text.replace("180", "1.8e4"), Path::new("pressure.csv"), &channels).unwrap_err();
//! assert!(wrong.to_string().starts_with("pressure.csv, line 3: left_mbar = 18000 is out of range"));
//! # Ok::<(), diagnostics::Diagnostic>(())
//! ```
//!
//! Depends on `si`, `diagnostics` and the parsers of TOML, CSV, C3D and dates.

pub mod card;
pub mod folder;
pub mod force;
pub mod log;
pub mod pixels;
pub mod place;
pub mod pressure;
pub mod range;
pub mod rest;
pub mod space;
pub mod table;
pub mod truth;

pub use card::Card;
pub use folder::Specimen;
pub use force::ForceLog;
pub use log::{Logged, Sampling};
pub use pressure::PressureLog;
pub use space::Trajectories;
pub use truth::Truth;

/// The value of `origin` in all files of the virtual bench.
pub const VIRTUAL_BENCH: &str = "virtual bench";
