//! What lies in `data/raw`: the card of a specimen, the logs of its trials, and the truth that a virtual bench hides.
//!
//! A specimen is a folder: `specimen.toml` (the card: what the laboratory knows of it), `cad/`, `camera/`,
//! `trials/<trial>/{video.mp4, pressure.csv, force.csv, hammer.csv}`. Everything is read into SI and range-checked, so that a slip of unit
//! breaks here and loudly. Whatever can be read can be written, with the same bytes every time.
//!
//! Stands on: `si`, csv, c3dio. Never knows: a mesh, a picture, who wrote the files or who reads them.

pub mod card;
pub mod folder;
pub mod force;
mod log;
mod nearest;
pub mod pressure;
pub mod range;
mod refusal;
pub mod space;
pub mod table;
pub mod truth;

pub use card::Card;
pub use folder::Specimen;
pub use force::ForceLog;
pub use pressure::PressureLog;
pub use refusal::Refusal;
pub use space::Space;
pub use truth::Truth;

/// What `origin` says in everything that the virtual bench writes.
pub const VIRTUAL_BENCH: &str = "virtual bench";
