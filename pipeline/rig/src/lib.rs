//! The virtual bench: it simulates experiments on specimens with hidden properties and writes what a laboratory would record.
//!
//! Shape and hidden properties → valve → finite-element motion → camera, pressure logger, load cell → a folder of `data/raw`. Every file is
//! marked "virtual bench", and a folder that the bench did not make is never overwritten. The pipeline that evaluates the recordings
//! shares neither the mesh nor the ground truth with the bench: the two meet in `data/raw` alone.
//!
//! Every random number is drawn from a named stream under the specimen's seed, so the same settings give the same bytes:
//!
//! ```
//! use rig::random::RandomStream;
//! use rig::settings::Settings;
//! use rig::valve::{Command, ValveDisturbance, valve_response};
//!
//! let valve = Settings::built_in().valve;
//! let commands = [Command { time: 0.0, pressure: 20_000.0 }];
//! let chamber = valve_response(&valve, &commands, ValveDisturbance::default(), &mut RandomStream::new(1, "valve"));
//! assert_eq!(chamber.at(0.0), 0.0); // dead time
//! assert!((chamber.at(2.0) - 18_800.0).abs() < 1.0); // it settles 12 mbar below the command
//! ```
//!
//! Depends on `si`, `diagnostics`, `lab`, `mesh`, `tail_cad`, `fem`, `simulate`, `track` and `workflow`.

mod bench;
mod calibration;
pub mod camera;
pub mod card;
mod checkpoint;
pub mod command;
mod export;
mod film;
mod folder;
mod force_log;
mod instruments;
pub mod physics;
pub mod population;
mod pressure_log;
pub mod progress;
pub mod random;
mod realism;
pub mod record;
pub mod renderer;
pub mod scene;
mod script;
pub mod settings;
mod side;
pub mod specimen;
pub mod specimens;
pub mod stamp;
mod trial;
pub mod valve;

pub use side::Side;
