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
    /// After a fault, make everything that does not need what failed.
    #[arg(long, global = true)]
    pub keep_going: bool,
    /// Begin no second record while less memory is free, GiB.
    #[arg(long, global = true, value_name = "GIB", default_value_t = crate::SPARE)]
    pub spare: f64,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Begin a specimen: a card with every key explained, and its folders, under data/raw. Nothing is written over.
    Init {
        /// Its name: letters, digits, `_` and `-`.
        name: String,
    },
    /// Look at recordings before anything is made of them: card, surfaces, films, logs, clocks, markers, disk. A line for each
    /// finding with what to do; exit code 1 when something must be mended.
    Doctor {
        /// One specimen; all of them when none is named.
        name: Option<String>,
    },
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
    /// Say for each record whether it would be kept or made, and why; write nothing but the drawing that is asked for.
    Plan {
        /// Stages, figures or tables.
        names: Vec<String>,
        /// One specimen alone.
        #[arg(long)]
        specimen: Option<String>,
        /// Show the stages as a tree of what reads what instead; with a file, draw them there as SVG.
        #[arg(long, value_name = "FILE.svg", num_args = 0..=1, require_equals = true)]
        graph: Option<Option<PathBuf>>,
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
    /// Write figures/index.html from the records at hand: everything that there is to look at, in one file.
    Page,
    /// Simulate a body under loads of one's own: a page of TOML that names a mesh, materials, clamps and loads.
    #[command(after_long_help = crate::case::KEYS)]
    Simulate {
        /// The case; its keys stand at the end of `study simulate --help`.
        case: PathBuf,
        /// Folder for the results, instead of CASE.out beside the case.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Identify a body that was held straight and let go: its Young's modulus from where it settles, its damping from how its swing
    /// dies; a page of TOML names recordings, marks and a case. The swing itself is foretold.
    Fit {
        /// The page, or the name of one that comes with the project.
        page: PathBuf,
        /// Folder for the table and the figure, instead of PAGE.out beside the page.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Bring the recordings that a page of `study fit` names from their public source.
    Fetch {
        /// The page, or the name of one that comes with the project.
        page: PathBuf,
    },
    /// Follow dark markers through any film: a CSV of their pixels with covariances, and a strip of pictures to look at.
    Track(Follow),
    /// Compare every number with what is expected and published, and every claim with its rule; or certify gradients.
    Check {
        /// Something else to check.
        #[command(subcommand)]
        what: Option<Checked>,
    },
    /// Put the numbers, figures and tables of the last run into the paper's source; `typeset` makes the PDF of it.
    Paper,
    /// List the stages, figures and tables, each with its story.
    List,
}

/// Options of `study track`.
#[derive(Debug, Args)]
pub struct Follow {
    /// The film: H.264 in MP4, a folder of PNG pictures with times.csv, or what an ffmpeg on the PATH reads.
    pub film: PathBuf,
    /// A marker in the first frame, px: `--at 512,360`; once for each marker.
    #[arg(long, value_name = "U,V", value_parser = pair, required_unless_present = "find")]
    pub at: Vec<[f64; 2]>,
    /// Find so many markers by themselves: the most distinct dark spots, from left to right.
    #[arg(long, value_name = "COUNT", conflicts_with = "at")]
    pub find: Option<usize>,
    /// Where to find them, px: left,top,right,bottom; the whole picture when not given.
    #[arg(long, value_name = "L,T,R,B", value_parser = four, requires = "find")]
    pub region: Option<[f64; 4]>,
    /// Radius of the disc that holds a marker and a margin of light ground, px.
    #[arg(long, default_value_t = 18.0)]
    pub radius: f64,
    /// How long a marker may be hidden, s.
    #[arg(long, default_value_t = 0.5)]
    pub hidden: f64,
    /// Write the film with its tracks drawn over it as well.
    #[arg(long)]
    pub overlay: bool,
    /// Folder for the results, instead of FILM.tracks beside the film.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
}

fn four(text: &str) -> Result<[f64; 4], String> {
    numbers(text)
}

/// `N` numbers between commas.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let read: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let read = read.map_err(|e| format!("`{text}` is not {N} numbers between commas: {e}"))?;
    read.try_into().map_err(|_| format!("`{text}` is not {N} numbers between commas"))
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
