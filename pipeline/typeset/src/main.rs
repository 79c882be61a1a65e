//! Compiles the paper's resolved source to PDF with typst. The same source gives the same bytes.
//!
//! `study paper` has inserted and checked every number, figure and table before. The fonts are those that come with typst and those in
//! `paper/fonts`; fonts of the system are not used. The typesetter is a program of its own because its dependencies take minutes to build
//! and nothing else needs them.
//!
//! Depends on `diagnostics`.

mod compiler;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

use compiler::TypesetError;
use diagnostics::{output, processor};

/// Compiles the paper that `study paper` has prepared.
#[derive(Debug, Parser)]
#[command(name = "typeset", version)]
struct Cli {
    /// Profile of the paper: paper, or quick under target/quick.
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
    processor::run(run_program)
}

fn run_program() -> ExitCode {
    let cli = Cli::parse();
    let base = match cli.profile {
        Profile::Paper => cli.root.clone(),
        Profile::Quick => cli.root.join("target").join("quick"),
    };
    match typeset_paper(&cli.root, &base) {
        Ok(report) => {
            output::line(&report);
            if output::failed() { ExitCode::FAILURE } else { ExitCode::SUCCESS }
        }
        Err(error) => {
            output::note(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn typeset_paper(root: &Path, base: &Path) -> Result<String, TypesetError> {
    if !base.join(SOURCE).is_file() {
        return Err(TypesetError::NotPrepared(base.join(SOURCE)));
    }
    let document = compiler::compile(base, SOURCE, &compiler::read_fonts(&root.join(FONTS))?)?;
    let output = base.join(PDF);
    let unwritable = |source: std::io::Error| TypesetError::Unwritable { path: output.clone(), source };
    let unfinished = output.with_extension("pdf.unfinished");
    std::fs::create_dir_all(output.parent().unwrap_or(base)).map_err(unwritable)?;
    std::fs::write(&unfinished, &document.pdf)
        .and_then(|()| std::fs::rename(&unfinished, &output))
        .map_err(unwritable)?;
    Ok(format!("{}: {} pages, {} KiB", output.display(), document.pages, document.pdf.len().div_ceil(1024)))
}
