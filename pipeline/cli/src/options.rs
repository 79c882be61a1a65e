//! The command line of `study`.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::meshing::options::MeshSurfaces;
use crate::reducing::ReduceCase;
use workflow::settings;

/// Recordings in, paper out: tracks, identified materials, validation, figures, tables.
#[derive(Debug, Parser)]
#[command(name = "study", version)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// Location of the project.
    #[command(flatten)]
    pub place: Place,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct Place {
    /// Settings and folders to use: quick is coarse and writes to target/quick, population is for the specimens of `rig draw`.
    #[arg(long, global = true, value_enum, default_value_t = Profile::Paper)]
    pub profile: Profile,
    /// The project's folder.
    #[arg(long, global = true, default_value = ".")]
    pub root: PathBuf,
    /// Print only diagnostics, warnings and the last line.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Number of records made in parallel; as many as there are cores and as memory permits when not given.
    #[arg(long, global = true, value_parser = count_parser(1..=1024))]
    pub jobs: Option<usize>,
    /// Threads of the parallel loops of all records together; one a core when not given.
    #[arg(long, global = true, value_parser = count_parser(1..=1024))]
    pub threads: Option<usize>,
    /// Memory that the records made in parallel may use together, GiB; what is free at the start when not given. A record counts with the
    /// peak that was measured of its stage.
    #[arg(long, global = true, value_name = "GIB", value_parser = number_parser(0.0, 1e6))]
    pub memory: Option<f64>,
    /// After an error, make everything that does not depend on what failed.
    #[arg(long, global = true)]
    pub keep_going: bool,
    /// Start no further record while less memory is free, GiB; also what a record counts with before its stage was measured.
    #[arg(long, global = true, value_name = "GIB", default_value_t = study::MIN_FREE_MEMORY, value_parser = number_parser(0.0, 1e6))]
    pub min_free_memory: f64,
}

/// The command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Create a specimen: a card with every key explained, and its folders, under data/raw. Nothing is overwritten.
    Init {
        /// Its name: letters, digits, `_` and `-`.
        name: String,
        /// A folder of recordings: the card is proposed from its files as by `study doctor FOLDER`, and those that it names are copied.
        #[arg(long, value_name = "FOLDER")]
        from: Option<PathBuf>,
    },
    /// Check recordings before anything is computed: card, surfaces, films, logs, clocks, markers, disk. One line for each
    /// finding with the next action; exit code 1 when something must be fixed. Of a folder without a card: propose one from its files, each
    /// guess with its evidence, as specimen.toml in that folder.
    Doctor {
        /// One specimen, or a folder of recordings without a card; all specimens when none is named.
        #[arg(value_name = "NAME|FOLDER")]
        name: Option<String>,
    },
    /// Make what is stale: everything, or the named stages, figures or tables with their inputs.
    Run {
        /// Stages, figures or tables.
        names: Vec<String>,
        /// Only this specimen.
        #[arg(long)]
        specimen: Option<String>,
        /// Make the named ones even when they are not stale.
        #[arg(long)]
        fresh: bool,
    },
    /// Make exactly the named records from what lies in the store, unless they are up to date: one record is one job of a workflow engine,
    /// on any machine that shares the folder. A missing or stale input is an error that names the command which makes it.
    Make {
        /// Records by stage and subject, as in `study plan`: `mesh/NAME`, `track/NAME/TRIAL`, `findings/all`.
        #[arg(required = true, value_name = "STAGE/SUBJECT")]
        records: Vec<String>,
    },
    /// Write the numbers, the archive's description and the page of the existing records: after `study make`, which writes records alone.
    /// Stale records are refused.
    Publish {
        /// Stages, figures or tables whose records must be up to date, with their inputs; all of them when none is named.
        names: Vec<String>,
    },
    /// Report for each record whether it would be kept or made, and why. Writes nothing except a requested drawing.
    Plan {
        /// Stages, figures or tables.
        names: Vec<String>,
        /// Only this specimen.
        #[arg(long)]
        specimen: Option<String>,
        /// Show the stages as a dependency tree instead; with a file, draw it there as SVG.
        #[arg(long, value_name = "FILE.svg", num_args = 0..=1, require_equals = true)]
        graph: Option<Option<PathBuf>>,
        /// Show instead how long everything would take with so many workers, from the durations of the records as they were made.
        #[arg(long, value_name = "WORKERS", value_delimiter = ',', conflicts_with = "graph", value_parser = count_parser(1..=1024))]
        schedule: Vec<usize>,
        /// Show instead what the records of each stage took when they were made, and how many are left.
        #[arg(long, conflicts_with_all = ["graph", "schedule"])]
        times: bool,
        /// Print instead one JSON array for a program: an object a record with what it reads, and whether and why it would be made.
        #[arg(long, conflicts_with_all = ["graph", "schedule", "times"])]
        json: bool,
        /// Print instead the recordings of the bench that these records read, as `rig record` takes them, one a line.
        #[arg(long, conflicts_with_all = ["graph", "schedule", "times", "json"])]
        recordings: bool,
    },
    /// Report the inputs of each record of a stage.
    Why {
        /// The stage, figure or table.
        name: String,
    },
    /// Make one figure with its inputs.
    Fig {
        /// Its name, as in figures/NAME.svg.
        name: String,
    },
    /// Make one table with its inputs.
    Table {
        /// Its name, as in paper/tables/NAME.csv.
        name: String,
    },
    /// Write figures/index.html from the existing records: all figures, tables and numbers in one file.
    Page,
    /// Simulate a body described by a TOML file: mesh, materials, clamps and loads.
    #[command(after_long_help = simulate::case::keys())]
    Simulate {
        /// The case; its keys are listed at the end of `study simulate --help`.
        case: PathBuf,
        /// Folder for the results, instead of CASE.out beside the case.
        #[arg(long)]
        out: Option<PathBuf>,
        /// Solve it again on cells shorter by 1.5, and print by how much the nodes and markers of the output move otherwise there; without it cells
        /// longer by 1.5 give an estimate, unless --quiet.
        #[arg(long)]
        certify: bool,
        /// When a search for an equilibrium ends; these take the place of the keys of the case.
        #[command(flatten)]
        budget: Limits,
    },
    /// Train a reduced model of a case's body over ranges of constants and pressures: its equilibria take milliseconds, and
    /// `softfish.ReducedModel.load` steps it. It is checked against the whole body at points drawn from the ranges.
    Reduce(ReduceCase),
    /// Mesh closed surfaces: a body with inserts that displace it, and cavities, each in an STL file, become quadratic tetrahedra with regions and
    /// chambers. Prints a report; columns are taken where they divide the body in elements of 5° and more, else the general method, which takes any closed surface.
    Mesh(MeshSurfaces),
    /// Identify a body from a free vibration test: Young's modulus from its static deflection, damping from the decay. A TOML file
    /// names recordings, markers and a case. The frequency and the first amplitude are then predicted. A file with test = "inflation"
    /// predicts a body whose chamber is inflated in a step, of the material that another fit wrote into the same folder; one with
    /// test = "tension", "compression" or "relaxation" fits a strip that is pulled, a cylinder that is pressed between plates on which it slides, or one
    /// that is held; one with test = "joint" names several tests that share a material.
    Fit {
        /// The TOML file, or the name of one that comes with the project.
        page: PathBuf,
        /// Folder for the table and the figure, instead of PAGE.out beside the file.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Download the recordings that a file of `study fit` names from their public source.
    Fetch {
        /// The TOML file, or the name of one that comes with the project.
        page: PathBuf,
    },
    /// Evaluate logs of a load cell without a film: a TOML file names taps, still water, staircases and runs. Writes a table with the mean
    /// force of each run over whole cycles, its interval and every correction, a record and a figure.
    #[command(after_long_help = instruments::force::keys())]
    Force {
        /// The TOML file; its keys are listed at the end of `study force --help`.
        page: PathBuf,
        /// Folder for the results, instead of PAGE.out beside the file.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Calibrate a camera from a film or a folder of pictures of a board: writes a camera file, OpenCV's YAML, the reprojection error of
    /// each view and a picture. No card is needed.
    Calibrate(CalibrateCamera),
    /// Track dark markers in any film: writes a CSV of their pixels with covariances, and a strip of pictures.
    Track(TrackFilm),
    /// Compare every number with its expected and published values, and every claim with its rule; or check gradients.
    #[command(args_conflicts_with_subcommands = true)]
    Check {
        /// Also write the comparison as JUnit XML, for continuous integration: a number that drifted is a failed case.
        #[arg(long, value_name = "FILE")]
        junit: Option<PathBuf>,
        /// Another check.
        #[command(subcommand)]
        what: Option<Checked>,
    },
    /// Put the numbers, figures and tables of the last run into the paper's source; `typeset` makes the PDF.
    Paper,
    /// List the stages, figures and tables, each with a description.
    List,
    /// Write the study for another program.
    Export {
        /// The program.
        #[command(subcommand)]
        what: Exported,
    },
}

/// Options of `study calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateCamera {
    /// The film, or a folder of PNG or JPEG pictures.
    pub source: PathBuf,
    /// Squares of the board along its first axis, or dots.
    #[arg(long, value_parser = count_parser(2..=100))]
    pub columns: usize,
    /// Squares along the second axis, or dots.
    #[arg(long, value_parser = count_parser(3..=100))]
    pub rows: usize,
    /// Side of a square, or distance of the dots' middles, m.
    #[arg(long, value_parser = number_parser(1e-3, 1.0))]
    pub square: f64,
    /// The board has dots in a square grid.
    #[arg(long, conflicts_with_all = ["asymmetric_dots", "charuco"])]
    pub dots: bool,
    /// The board has an odd number of rows of dots, every second row shifted by half a pitch: columns are the dots of a row, square is the
    /// distance of two rows.
    #[arg(long, conflicts_with = "charuco")]
    pub asymmetric_dots: bool,
    /// The board is a ChArUco board with markers of this dictionary of OpenCV, DICT_4X4_50 to DICT_7X7_1000, or of AprilTag; a part of it in a picture is
    /// enough.
    #[arg(long, value_name = "DICTIONARY", requires = "marker")]
    pub charuco: Option<track::board::charuco::Dictionary>,
    /// Side of a marker of a ChArUco board, m.
    #[arg(long, requires = "charuco", value_parser = number_parser(5e-4, 1.0))]
    pub marker: Option<f64>,
    /// The lens is a fisheye.
    #[arg(long)]
    pub fisheye: bool,
    /// Of a film, use one frame in so many.
    #[arg(long, default_value_t = 10, value_parser = count_parser(1..=1000))]
    pub every: usize,
    /// Folder for the results, instead of SOURCE.camera beside it.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Options of `study track`.
#[derive(Debug, Args)]
pub struct TrackFilm {
    /// The film: H.264 in MP4, a folder of PNG or JPEG pictures with times.csv, or any format read by an ffmpeg on the PATH. Of several
    /// films each is tracked by the same options; a table says what was lost where.
    #[arg(required = true, num_args = 1..)]
    pub films: Vec<PathBuf>,
    /// The first frame to track, from 0: markers are clicked or detected in this one.
    #[arg(long, default_value_t = 0)]
    pub first: usize,
    /// The last frame to track.
    #[arg(long)]
    pub last: Option<usize>,
    /// A marker in the first frame, px: `--at 512,360`; once for each marker.
    #[arg(long, value_name = "U,V", value_parser = parse_pair, required_unless_present = "find")]
    pub at: Vec<[f64; 2]>,
    /// Detect this number of markers: the most distinct dark spots, from left to right.
    #[arg(long, value_name = "COUNT", conflicts_with = "at", value_parser = count_parser(1..=1000))]
    pub find: Option<usize>,
    /// Region of detection, px: left,top,right,bottom; the whole picture when not given.
    #[arg(long, value_name = "L,T,R,B", value_parser = parse_four, requires = "find")]
    pub region: Option<[f64; 4]>,
    /// Radius of the disc that holds a marker and a margin of light ground, px.
    #[arg(long, default_value_t = 18.0, value_parser = number_parser(track::klt::LEAST_RADIUS, 1000.0))]
    pub radius: f64,
    /// Longest occlusion of a marker, s.
    #[arg(long, default_value_t = 0.5, value_parser = number_parser(0.0, 3600.0))]
    pub hidden: f64,
    /// Also write the film with its tracks drawn over it.
    #[arg(long)]
    pub overlay: bool,
    /// Folder for the results, instead of FILM.tracks beside the film; of several films, the folder of those.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// A whole number within a range.
fn count_parser(range: std::ops::RangeInclusive<u64>) -> RangedU64ValueParser<usize> {
    RangedU64ValueParser::new().range(range)
}

/// A number from `low` to `high`.
fn number_parser(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number: f64 = text.trim().parse().map_err(|e| format!("`{text}` is not a number: {e}"))?;
        let out_of_range = || format!("{text} is not in {low}..={high}");
        (low..=high).contains(&number).then_some(number).ok_or_else(out_of_range)
    }
}

fn parse_pair(text: &str) -> Result<[f64; 2], String> {
    parse_numbers(text)
}

fn parse_four(text: &str) -> Result<[f64; 4], String> {
    parse_numbers(text)
}

/// `N` numbers between commas.
fn parse_numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let values: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let values = values.map_err(|e| format!("`{text}` is not {N} numbers between commas: {e}"))?;
    if values.iter().any(|number| !number.is_finite()) {
        return Err(format!("`{text}` holds a number that is not finite"));
    }
    values.try_into().map_err(|_| format!("`{text}` is not {N} numbers between commas"))
}

/// Checks beside the numbers.
#[derive(Debug, Subcommand)]
pub enum Checked {
    /// Check every gradient of a case against converged differences, and by the Taylor test.
    Gradients {
        /// Cases as `study simulate` takes them, and reduced tails (.safetensors) as `study export twin` writes them; the examples that come
        /// with the project when none is named.
        cases: Vec<PathBuf>,
        /// Number of time steps of a motion.
        #[arg(long, default_value_t = 12, value_parser = count_parser(1..=10_000))]
        steps: usize,
    },
}

/// Limits of the solves of a case.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Limits {
    /// Newton iterations of a level or time step at most [default: 250].
    #[arg(long, value_parser = count_parser(1..=1_000_000_000))]
    max_iterations: Option<usize>,
    /// Halvings of a load step at most [default: 40].
    #[arg(long, value_parser = count_parser(0..=10_000))]
    max_cutbacks: Option<usize>,
    /// Seconds of the whole case at most [default: no limit].
    #[arg(long, value_parser = number_parser(1e-3, 1e7))]
    timeout: Option<f64>,
}

impl From<Limits> for simulate::Budget {
    fn from(Limits { max_iterations, max_cutbacks, timeout }: Limits) -> Self {
        Self { max_iterations, max_cutbacks, timeout }
    }
}

/// What the study is written for.
#[derive(Debug, Subcommand)]
pub enum Exported {
    /// A workflow for Snakemake 9: a rule for each stage, figure and table, jobs that make one record each by `study make`, resources from
    /// measured records, and profiles for one machine and for Slurm.
    Snakemake {
        /// Folder for the workflow, instead of workflow/ in the folder of the profile.
        folder: Option<PathBuf>,
        /// Only these stages, figures or tables with their inputs; once for each.
        #[arg(long, value_name = "STAGE")]
        only: Vec<String>,
        /// Write no workflow, but bring the one in FOLDER up to date: which records there are, and which a run would keep. The workflow
        /// itself asks for this each time that it begins.
        #[arg(long, requires = "folder")]
        marks: bool,
    },
    /// A specimen's identified and reduced tail for a controller: its arrays as safetensors, a page that describes them, and the Rust crate
    /// that steps them faster than real time, with an example that closes a loop.
    Twin {
        /// The specimen.
        name: String,
        /// Folder, instead of twin/NAME in the folder of the profile.
        folder: Option<PathBuf>,
    },
    /// Completions of this command line for a shell, on standard output.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Manual pages of the program and of each command.
    Manual {
        /// Folder for the pages.
        folder: PathBuf,
    },
}

/// The profiles on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Profile {
    /// Full resolution.
    Paper,
    /// Coarse and short.
    Quick,
    /// Coarse, for many specimens.
    Population,
}

impl From<Profile> for settings::Profile {
    fn from(profile: Profile) -> Self {
        match profile {
            Profile::Paper => settings::Profile::Paper,
            Profile::Quick => settings::Profile::Quick,
            Profile::Population => settings::Profile::Population,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_between_commas_are_as_many_as_asked_and_finite() {
        assert_eq!(parse_four("1, 2.5,-3,4e2"), Ok([1.0, 2.5, -3.0, 400.0]));
        assert_eq!(parse_pair("0.5,2"), Ok([0.5, 2.0]));
        for (text, said) in [("1,2,3", "not 4 numbers"), ("1,2,x,4", "not 4 numbers"), ("1,2,3,inf", "not finite")] {
            assert!(parse_four(text).is_err_and(|why| why.contains(said)), "{text}");
        }
    }

    #[test]
    fn a_number_is_refused_outside_of_its_range_alone() {
        let read = number_parser(0.5, 2.0);
        assert_eq!([read("0.5"), read(" 2 ")], [Ok(0.5), Ok(2.0)]);
        assert!(read("2.1").is_err_and(|why| why == "2.1 is not in 0.5..=2"));
        assert!(read("two").is_err_and(|why| why.contains("not a number")));
    }
}
