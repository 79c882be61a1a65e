//! The command line of `study`.
//!
//! Stands on: clap. Never knows: what a command does.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::settings;

/// Recordings in, paper out: tracks, identified materials, validation, figures, tables.
#[derive(Debug, Parser)]
#[command(name = "study", version)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Where the project lies.
    #[command(flatten)]
    pub place: Place,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct Place {
    /// Settings and folders to use: quick is coarse and lives under target/quick.
    #[arg(long, global = true, value_enum, default_value_t = Profile::Paper)]
    pub profile: Profile,
    /// The project's folder.
    #[arg(long, global = true, default_value = ".")]
    pub root: PathBuf,
    /// Print only faults, warnings and the last line.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// How many records are made side by side.
    #[arg(long, global = true, default_value_t = 2)]
    pub jobs: usize,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make what is stale: everything, or the named stages, figures or tables with what they need.
    Run {
        /// Stages, figures or tables.
        names: Vec<String>,
        /// One specimen alone.
        #[arg(long)]
        specimen: Option<String>,
        /// Make the named ones even when they are not stale.
        #[arg(long)]
        fresh: bool,
    },
    /// Say for each record whether it would be kept or made, and why; write nothing.
    Plan {
        /// Stages, figures or tables.
        names: Vec<String>,
        /// One specimen alone.
        #[arg(long)]
        specimen: Option<String>,
    },
    /// Say from what each record of a stage was made.
    Why {
        /// The stage, figure or table.
        name: String,
    },
    /// Make one figure, with what it needs.
    Fig {
        /// Its name, as in figures/NAME.svg.
        name: String,
    },
    /// Make one table, with what it needs.
    Table {
        /// Its name, as in paper/tables/NAME.csv.
        name: String,
    },
    /// Simulate a body under loads of one's own: a page of TOML that names a mesh, materials, clamps and loads.
    #[command(after_long_help = crate::case::KEYS)]
    Simulate {
        /// The case; its keys stand at the end of `study simulate --help`.
        case: PathBuf,
        /// Folder for the results, instead of CASE.out beside the case.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Compare every number with what is expected and published, and every claim with its rule; or certify gradients.
    Check {
        /// Something else to check.
        #[command(subcommand)]
        what: Option<Checked>,
    },
    /// List the stages, figures and tables, each with its story.
    List,
}

/// What can be checked beside the numbers.
#[derive(Debug, Subcommand)]
pub enum Checked {
    /// Check every gradient of a case against converged differences, and by the Taylor test.
    Gradients {
        /// Cases as `study simulate` takes them; the examples that come with the project when none is named.
        cases: Vec<PathBuf>,
        /// Steps of a motion that are gone through.
        #[arg(long, default_value_t = 12)]
        steps: usize,
    },
}

/// The profiles as words of the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Profile {
    /// Full resolution.
    Paper,
    /// Coarse and short.
    Quick,
}

impl From<Profile> for settings::Profile {
    fn from(profile: Profile) -> Self {
        match profile {
            Profile::Paper => settings::Profile::Paper,
            Profile::Quick => settings::Profile::Quick,
        }
    }
}
