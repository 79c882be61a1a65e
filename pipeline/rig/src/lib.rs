//! The virtual bench: it records specimens whose properties it hides, as a laboratory would record real ones.
//!
//! Shape and hidden properties → valve → finite elements in motion → camera, logger, load cell → a folder of `data/raw`. Everything
//! it writes says "virtual bench", and it never writes into a folder that it did not make itself. The pipeline that reads
//! the folder shares neither mesh nor truth with it.
//!
//! Stands on: `lab`, `shape`, `fem`, `track`. Never knows: the pipeline that will read its recordings.

pub mod calibration;
pub mod camera;
pub mod card;
pub mod command;
pub mod draw;
pub mod fault;
pub mod film;
pub mod folder;
pub mod instruments;
pub mod logger;
pub mod physics;
pub mod progress;
pub mod realism;
pub mod receipts;
pub mod record;
pub mod scene;
pub mod script;
pub mod settings;
pub mod specimen;
pub mod specimens;
pub mod stamp;
pub mod studio;
pub mod trial;
pub mod valve;
pub mod weighing;
