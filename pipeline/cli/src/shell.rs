//! What a shell and `man` read of the command line: completions, and a manual page for each command.

use std::fs;
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::options::Cli;
use diagnostics::{Diagnostic, Result, output};

/// The name of the program.
const PROGRAM: &str = "study";

/// Prints the completions of a shell.
pub fn print_completions(shell: Shell) -> bool {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), PROGRAM, &mut script);
    output::text(String::from_utf8_lossy(&script));
    true
}

/// Writes a manual page for the program and for each of its commands into `folder`, which is made where there is none.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub fn write_manual(folder: &Path) -> Result<bool> {
    let unwritable = |e| Diagnostic::io(folder, e, "choose another folder for the manual pages");
    fs::create_dir_all(folder).map_err(unwritable)?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(unwritable)?;
    output::line(format_args!("{}: manual pages; man {}/{PROGRAM}.1", folder.display(), folder.display()));
    Ok(true)
}
