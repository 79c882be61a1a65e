//! The command line: `rig record [SPECIMEN[/TRIAL]…] [--cards] [--part PART] [--profile NAME] [--root DIR] [--into DIR] [--quiet]`,
//! `rig draw COUNT [--seed S] [--only NUMBER]`, `rig export snakemake`, `rig check [--profile NAME] [--write]`.

mod chosen;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use diagnostics::{Diagnostic, Result, output};
use rayon::prelude::*;
use workflow::snakemake::Workflow;

use self::chosen::{chosen_numbers, chosen_parts, chosen_specimens, known_profile};
use crate::export::{self, Recording};
use crate::folder;
use crate::population;
use crate::progress::Progress;
use crate::realism;
use crate::record::{Request, Status, record, record_part, record_some};
use crate::settings::Settings;
use crate::specimen::{Draw, Specimen};

/// The virtual bench: simulates experiments on specimens with hidden properties and writes them to data/raw.
#[derive(Parser)]
#[command(name = "rig", version)]
struct Line {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Record specimens. Without a name, all are recorded. Recordings that are up to date are kept. Several processes may record at once.
    Record {
        /// Names of specimens, or of parts as SPECIMEN/PART (a trial, a log of the fixture, calibration): of a specimen whose parts are named, these alone
        /// are recorded; the same command with the specimen's name makes what is left.
        specimens: Vec<String>,
        /// Only the cards and the solids: enough for `study plan` to list the trials that something needs.
        #[arg(long, conflicts_with = "part")]
        cards: bool,
        /// Only this part of each recording: statics, which every trial needs, calibration, or a trial by its name. The same command
        /// without it makes what is left and finishes the recording.
        #[arg(long)]
        part: Option<String>,
        /// Extent and resolution of the recordings: paper or quick.
        #[arg(long, default_value = "paper")]
        profile: String,
        /// Where they are recorded.
        #[command(flatten)]
        destination: Destination,
    },
    /// Record a population: specimens of one design, each with its own silicone, sheet, casting, water, valve and camera, drawn at random.
    Draw {
        /// How many: tail_001 to tail_COUNT. Those that are up to date are kept.
        #[arg(value_parser = clap::value_parser!(u16).range(1..=9999))]
        count: u16,
        /// Seed of the population.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Only the specimen of this number.
        #[arg(long, value_name = "NUMBER")]
        only: Option<u16>,
        /// Only this part of each recording, as of `rig record`.
        #[arg(long)]
        part: Option<String>,
        /// Extent and resolution of the recordings.
        #[arg(long, default_value = "population")]
        profile: String,
        /// Where they are recorded.
        #[command(flatten)]
        destination: Destination,
    },
    /// Write the recordings as a workflow for another program, whose jobs make one part each.
    Export {
        #[command(subcommand)]
        what: Exported,
    },
    /// Compare the simulated valve, load cell and forces in water with measurements of real instruments.
    Check {
        /// The project's folder.
        #[arg(long, default_value = ".")]
        root: PathBuf,
        /// Profile of the recordings: paper or quick.
        #[arg(long, default_value = "paper")]
        profile: String,
        /// Also write the table to paper/tables/bench_check.csv under the root.
        #[arg(long)]
        write: bool,
    },
}

/// What the recordings are written for.
#[derive(Subcommand)]
enum Exported {
    /// A workflow for Snakemake 9, with profiles for one machine and for Slurm.
    Snakemake {
        /// Names of specimens. Without a name, and without --draw, all are recorded.
        specimens: Vec<String>,
        /// Instead of these the first COUNT specimens of a population.
        #[arg(long, value_name = "COUNT", conflicts_with = "specimens", value_parser = clap::value_parser!(u16).range(1..=9999))]
        draw: Option<u16>,
        /// Seed of the population.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Extent and resolution of the recordings.
        #[arg(long, default_value = "paper")]
        profile: String,
        /// Where they are recorded.
        #[command(flatten)]
        destination: Destination,
    },
}

/// Where specimens are recorded.
#[derive(Args)]
struct Destination {
    /// The project's folder.
    #[arg(long, default_value = ".")]
    root: PathBuf,
    /// Folder for the specimens. The default is data/raw under the root for the paper profile, target/PROFILE/data/raw for another. An
    /// exported workflow is written into INTO/workflow, by default beside data in workflow/recording.
    #[arg(long)]
    into: Option<PathBuf>,
    /// Do not print progress.
    #[arg(long)]
    quiet: bool,
}

impl Destination {
    /// The folder of a profile's specimens.
    fn recordings_folder(&self, profile: &str) -> PathBuf {
        self.into.clone().unwrap_or_else(|| raw_folder(&self.root, profile))
    }

    /// The folder of a workflow that records them: beside those of the profile, and inside of another folder.
    fn workflow_folder(&self, profile: &str) -> PathBuf {
        match &self.into {
            Some(into) => into.join("workflow"),
            None => profile_folder(&self.root, profile).join("workflow").join("recording"),
        }
    }
}

/// The table of the comparison, under the project's folder.
const CHECK_TABLE: &str = "paper/tables/bench_check.csv";
/// Exit code for an invalid command line, the same as clap's.
const USAGE: u8 = 2;
/// Exit code for a failed command.
const FAILURE: u8 = 1;

/// Parses the command line and runs the command.
pub fn run() -> ExitCode {
    let set = Settings::built_in();
    match Line::parse().task {
        Task::Record { specimens, cards, part, profile, destination } => {
            let (into, progress) = (destination.recordings_folder(&profile), Progress::new(destination.quiet));
            let request = Request { set: &set, profile: &profile, into: &into, progress: &progress };
            record_each(chosen_parts(&specimens, cards, &profile, &set), |(specimen, parts)| match parts {
                None => record_one(specimen, &request, part.as_deref()),
                Some(parts) => record_parts(specimen, &request, &parts),
            })
        }
        Task::Draw { count, seed, only, part, profile, destination } => {
            let (into, progress) = (destination.recordings_folder(&profile), Progress::new(destination.quiet));
            let request = Request { set: &set, profile: &profile, into: &into, progress: &progress };
            let chosen = known_profile(&profile, &set).and_then(|()| chosen_numbers(count, only));
            record_each(chosen, |number| {
                let member = population::draw_member(&set, Draw { seed, number });
                record_one(&member.specimen, &Request { set: &member.settings, ..request }, part.as_deref())
            })
        }
        Task::Export { what: Exported::Snakemake { specimens, draw, seed, profile, destination } } => {
            let (into, progress) = (destination.recordings_folder(&profile), Progress::new(true));
            let request = Request { set: &set, profile: &profile, into: &into, progress: &progress };
            let recordings = match draw {
                None => chosen_specimens(&specimens, &profile, &set).map(|chosen| {
                    chosen.into_iter().map(|specimen| Recording::of_specimen(specimen, &request)).collect()
                }),
                Some(count) => known_profile(&profile, &set).map(|()| drawn_recordings(&request, count, seed)),
            };
            recordings.map_or_else(
                |error| report_failure(&error, FAILURE),
                |recordings| export_workflow(&destination, &request, &recordings),
            )
        }
        Task::Check { root, profile, write } => {
            report_check(check_bench(&set, &raw_folder(&root, &profile), write.then_some(root)))
        }
    }
}

/// Writes the workflow that makes the recordings, and prints where it lies.
fn export_workflow(destination: &Destination, request: &Request, recordings: &[Recording]) -> ExitCode {
    let folder = destination.workflow_folder(request.profile);
    match export::write_snakemake(&destination.root, &folder, request, recordings) {
        Ok(Workflow { folder, kept }) => {
            kept.iter().for_each(|path| output::note(format_args!("kept as it was edited: {}", path.display())));
            output::line(folder.display());
            ExitCode::SUCCESS
        }
        Err(error) => report_failure(&error, FAILURE),
    }
}

/// The exit code of a comparison, which fails where a line of it could not be printed.
fn report_check(checked: Result<()>) -> ExitCode {
    match checked {
        Ok(()) if output::failed() => ExitCode::from(FAILURE),
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report_failure(&error, FAILURE),
    }
}

/// Prints the comparison for the instruments and the recordings under `raw`, and writes it under `root` if one is given.
fn check_bench(set: &Settings, raw: &Path, root: Option<PathBuf>) -> Result<()> {
    let comparisons = realism::with_recordings(set, raw)?;
    output::text(realism::comparisons_table(&comparisons));
    if let Some(root) = root {
        folder::write_file(&root, CHECK_TABLE, realism::comparisons_csv(&comparisons).as_bytes())?;
    }
    let deviations = realism::known_deviations();
    output::text(realism::explanation_text(&comparisons, &deviations));
    let unexplained = realism::unexplained_comparisons(&comparisons, &deviations);
    let Some(first) = unexplained.first() else { return Ok(()) };
    Err(Diagnostic::new(
        format!(
            "{} quantities of the bench lie outside the measured ranges, the first {}",
            unexplained.len(),
            first.quantity
        ),
        "the bench should be no better and no worse than real instruments, save for its known deviations",
        "correct bench.toml, or give the reason in pipeline/rig/src/realism/known_deviations.toml",
    ))
}

/// Records every one of what was chosen in parallel.
fn record_each<T: Send>(chosen: Result<Vec<T>>, one: impl Fn(T) -> Result<()> + Sync) -> ExitCode {
    let chosen = match chosen {
        Ok(chosen) => chosen,
        Err(error) => return report_failure(&error, USAGE),
    };
    match chosen.into_par_iter().try_for_each(&one) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report_failure(&error, FAILURE),
    }
}

fn record_one(specimen: &Specimen, request: &Request, part: Option<&str>) -> Result<()> {
    let Some(part) = part else {
        let task = request.progress.begin_step("record", &*specimen.name, 1);
        match record(specimen, request)? {
            Status::Recorded => task.end_step(&request.into.join(&*specimen.name).display().to_string()),
            Status::UpToDate => request.progress.print_line("record", &specimen.name, "up to date"),
        }
        return Ok(());
    };
    if record_part(specimen, request, part)? == Status::UpToDate {
        request.progress.print_line("record", &specimen.name, "up to date");
    }
    Ok(())
}

fn record_parts(specimen: &Specimen, request: &Request, parts: &[String]) -> Result<()> {
    let task = request.progress.begin_step("record", &*specimen.name, 1);
    match record_some(specimen, request, parts)? {
        Status::Recorded if parts.is_empty() => task.end_step("card and solids"),
        Status::Recorded => task.end_step(&parts.join(", ")),
        Status::UpToDate => request.progress.print_line("record", &specimen.name, "up to date"),
    }
    Ok(())
}

/// The recordings of a population.
fn drawn_recordings(request: &Request, count: u16, seed: u64) -> Vec<Recording> {
    let member = |number| population::draw_member(request.set, Draw { seed, number });
    let recording = |member: population::Member| {
        Recording::of_specimen(&member.specimen, &Request { set: &member.settings, ..*request })
    };
    (1..=usize::from(count)).map(member).map(recording).collect()
}

fn report_failure(error: &Diagnostic, code: u8) -> ExitCode {
    output::note(format_args!("error: {error}"));
    ExitCode::from(code)
}

/// The folder of a profile's recordings under the project's folder.
fn raw_folder(root: &Path, profile: &str) -> PathBuf {
    profile_folder(root, profile).join("data").join("raw")
}

/// The folder of all that is made in a profile.
fn profile_folder(root: &Path, profile: &str) -> PathBuf {
    if profile == "paper" { root.to_owned() } else { root.join("target").join(profile) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_of_other_profiles_than_paper_are_under_target() {
        let root = Path::new("project");
        assert_eq!(raw_folder(root, "paper"), Path::new("project/data/raw"));
        assert_eq!(raw_folder(root, "quick"), Path::new("project/target/quick/data/raw"));
    }
}
