//! Typeset: the paper's source with its numbers in place → PDF. The same source gives the same bytes.
//!
//! `study paper` has put every number, figure and table into the source and refused what was wrong; here pages are set, and
//! nothing else. Fonts are those that come with typst and those in `paper/fonts`; none of the machine's is looked at.
//!
//! Stands on: typst. Never knows: a number, a claim, where either came from.

mod press;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

/// Sets the paper that `study paper` has prepared.
#[derive(Debug, Parser)]
#[command(name = "typeset", version)]
struct Cli {
    /// Whose paper: quick lives under target/quick.
    #[arg(long, value_enum, default_value_t = Profile::Paper)]
    profile: Profile,
    /// The project's folder.
    #[arg(long, default_value = ".")]
    root: PathBuf,
}

/// The profiles of the study.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Profile {
    /// Full resolution.
    Paper,
    /// Coarse and short.
    Quick,
}

/// The prepared source, below the profile's folder.
const SOURCE: &str = "data/processed/paper/main.typ";
/// The PDF, below the profile's folder.
const PDF: &str = "paper/paper.pdf";
/// Fonts, below the project's folder.
const FONTS: &str = "paper/fonts";

fn main() -> ExitCode {
    let cli = Cli::parse();
    let base = match cli.profile {
        Profile::Paper => cli.root.clone(),
        Profile::Quick => cli.root.join("target").join("quick"),
    };
    match run(&cli.root, &base) {
        Ok(said) => {
            println!("{said}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run(root: &Path, base: &Path) -> Result<String, String> {
    if !base.join(SOURCE).is_file() {
        return Err(format!("{} is not there\n  do:  study paper", base.join(SOURCE).display()));
    }
    let set = press::set(base, SOURCE, &press::fonts(&root.join(FONTS))?)?;
    let to = base.join(PDF);
    let unwritable = |e: std::io::Error| format!("{} cannot be written\n  why: {e}", to.display());
    let beside = to.with_extension("pdf.unfinished");
    std::fs::create_dir_all(to.parent().unwrap_or(base)).map_err(unwritable)?;
    std::fs::write(&beside, &set.pdf).and_then(|()| std::fs::rename(&beside, &to)).map_err(unwritable)?;
    Ok(format!("{}: {} pages, {} KiB", to.display(), set.pages, set.pdf.len().div_ceil(1024)))
}
