//! The program `study`: its command line and what it does without the pipeline.
//!
//! [`doctor`] inspects recordings before anything is computed, [`init`] creates a specimen, [`meshing`] meshes surfaces, [`recordings`] lists the recordings that a goal needs, [`reducing`] trains reduced models, [`shell`] writes completions and manual pages, [`track`] tracks markers through any film, [`twin`] exports a tail for a controller.
//! Every other command calls `study`, `simulate` or `sysid`.
//!
//! ```
//! use clap::Parser;
//! let cli = cli::options::Cli::try_parse_from(["study", "run", "identify", "--specimen", "nemo"]).unwrap();
//! assert!(matches!(cli.command, cli::options::Command::Run { .. }));
//! ```
//!
//! Depends on `study` and on its dependencies.

pub mod commands;
pub mod doctor;
pub mod init;
pub mod meshing;
pub mod options;
pub mod pictures;
pub mod proposal;
pub mod recordings;
pub mod reducing;
pub mod shell;
pub mod track;
pub mod twin;
