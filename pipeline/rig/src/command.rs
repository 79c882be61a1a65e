//! The command line: `rig record [SPECIMEN…] [--profile NAME] [--root DIR] [--into DIR] [--quiet]`, `rig check [--profile NAME] [--write]`.
//!
//! Stands on: `clap`, the recorder, the realism of the instruments. Never knows: how anything is recorded.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use rayon::prelude::*;

use crate::fault::Fault;
use crate::folder;
use crate::progress::Progress;
use crate::realism;
use crate::record::{Outcome, record};
use crate::settings::Settings;
use crate::specimen::Specimen;
use crate::specimens::ALL;

/// The virtual bench: makes data/raw as a laboratory would, with hidden properties.
#[derive(Parser)]
#[command(name = "rig", version)]
struct Line {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Record specimens (all of them when none is named); finished recordings are kept.
    Record {
        /// Names of specimens.
        specimens: Vec<String>,
        /// How much and how finely: paper or quick.
        #[arg(long, default_value = "paper")]
        profile: String,
        /// The project's folder.
        #[arg(long, default_value = ".")]
        root: PathBuf,
        /// Where the specimens' folders go; by default data/raw under the root, or target/quick/data/raw.
        #[arg(long)]
        into: Option<PathBuf>,
        /// No progress.
        #[arg(long)]
        quiet: bool,
    },
    /// Compare the valve, the load cell and the forces of recordings in water with what was measured on real ones.
    Check {
        /// The project's folder.
        #[arg(long, default_value = ".")]
        root: PathBuf,
        /// Whose recordings are looked at: paper or quick.
        #[arg(long, default_value = "paper")]
        profile: String,
        /// Write the table to paper/tables/bench_check.csv under the root as well.
        #[arg(long)]
        write: bool,
    },
}

/// Where the table of the instruments goes under the project's folder.
const REALISM: &str = "paper/tables/bench_check.csv";
/// Exit code for a command that cannot be understood; clap ends with the same.
const USAGE: u8 = 2;

/// Reads the command line and obeys it.
pub fn run() -> ExitCode {
    let set = Settings::built_in();
    match Line::parse().task {
        Task::Record { specimens, profile, root, into, quiet } => {
            let into = into.unwrap_or_else(|| home(&root, &profile));
            record_all(&specimens, &set, &profile, &into, quiet)
        }
        Task::Check { root, profile, write } => check(&set, &home(&root, &profile), write.then_some(root)),
    }
}

/// Prints the table of the instruments and of the recordings under `raw`, and writes it under `root` where that is asked for.
fn check(set: &Settings, raw: &Path, root: Option<PathBuf>) -> ExitCode {
    let figures = match realism::with_recordings(set, raw) {
        Ok(figures) => figures,
        Err(fault) => return fail(&fault.to_string(), 1),
    };
    print!("{}", realism::table(&figures));
    if let Some(Err(fault)) = root.map(|root| folder::write(&root, REALISM, realism::csv(&figures).as_bytes())) {
        return fail(&fault.to_string(), 1);
    }
    match figures.iter().filter(|f| !f.inside()).count() {
        0 => ExitCode::SUCCESS,
        outside => fail(&outside_of(outside), 1),
    }
}

fn outside_of(count: usize) -> String {
    let why = "the bench should be no better and no worse than real instruments";
    format!("{count} of the bench's figures lie outside what was measured\n  why: {why}\n  do:  correct bench.toml")
}

fn record_all(specimens: &[String], set: &Settings, profile: &str, into: &Path, quiet: bool) -> ExitCode {
    let chosen = match choose(specimens, profile, set) {
        Ok(chosen) => chosen,
        Err(said) => return fail(&said, USAGE),
    };
    let progress = Progress::new(quiet);
    match chosen.into_par_iter().try_for_each(|specimen| one(specimen, set, profile, into, &progress)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => fail(&fault.to_string(), 1),
    }
}

fn one(specimen: &Specimen, set: &Settings, profile: &str, into: &Path, progress: &Progress) -> Result<(), Fault> {
    let task = progress.begin("record", specimen.name, 1);
    match record(specimen, set, profile, into, progress)? {
        Outcome::Made => task.done(&into.join(specimen.name).display().to_string()),
        Outcome::Kept => progress.say("record", specimen.name, "kept"),
    }
    Ok(())
}

fn fail(said: &str, code: u8) -> ExitCode {
    eprintln!("error: {said}");
    ExitCode::from(code)
}

/// Where recordings of a profile go under the project's folder.
fn home(root: &Path, profile: &str) -> PathBuf {
    let base = if profile == "paper" { root.to_owned() } else { root.join("target").join(profile) };
    base.join("data").join("raw")
}

/// The specimens of these names, all for none.
fn choose(names: &[String], profile: &str, set: &Settings) -> Result<Vec<&'static Specimen>, String> {
    if !set.profile.contains_key(profile) {
        let known: Vec<&str> = set.profile.keys().map(String::as_str).collect();
        return Err(format!(
            "there is no profile `{profile}`\n  why: the profiles are {}\n  do:  name one of them",
            known.join(", ")
        ));
    }
    if names.is_empty() {
        return Ok(ALL.iter().collect());
    }
    let known: Vec<&str> = ALL.iter().map(|s| s.name).collect();
    let find = |name: &String| {
        let unknown = || {
            format!(
                "there is no specimen `{name}` on the bench\n  why: it has {}\n  do:  name one of them",
                known.join(", ")
            )
        };
        ALL.iter().find(|s| s.name == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_specimen_or_profile_is_refused_with_the_known_ones() {
        let set = Settings::built_in();
        let said = |names: &[&str], profile: &str| {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            choose(&names, profile, &set).err().unwrap_or_default()
        };
        assert!(said(&["goldfish"], "quick").contains("it has nemo"));
        assert!(said(&[], "slow").contains("paper, quick"));
        assert_eq!(said(&[], "quick"), "");
    }

    #[test]
    fn every_profile_but_the_paper_s_lives_under_target() {
        let root = Path::new("house");
        assert_eq!(home(root, "paper"), Path::new("house/data/raw"));
        assert_eq!(home(root, "quick"), Path::new("house/target/quick/data/raw"));
    }
}
