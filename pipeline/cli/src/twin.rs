//! `study export twin`: the identified and reduced tail of a specimen for a controller, with the crate that steps it.

use std::fs;
use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use study::Runner;

/// The arrays' file, and the page that describes it.
const ARRAYS: &str = "tail.safetensors";
const PAGE: &str = "tail.txt";

/// Writes the arrays, the page that describes them, and the crate by itself; returns their folder.
///
/// # Errors
/// A [`Diagnostic`] when there is no such specimen, one of its records is missing, or a file cannot be written.
pub fn export(runner: &Runner, name: &str, folder: Option<&Path>) -> Result<PathBuf> {
    let specimens = &runner.universe.specimens;
    let specimen = specimens.iter().find(|specimen| specimen.card.name == name).ok_or_else(|| {
        let known: Vec<&str> = specimens.iter().map(|specimen| &*specimen.card.name).collect();
        let why = format!("there are {}", known.join(", "));
        Diagnostic::new(format!("there is no specimen `{name}`"), why, "name one of these")
    })?;
    let data = study::live::twin(runner, specimen, None)?;
    let folder = folder.map_or_else(|| runner.folders.base().join("twin").join(name), Path::to_owned);
    write(&folder.join(ARRAYS), &twin::file::bytes(&data)?)?;
    write(&folder.join(PAGE), twin::file::page(&data).as_bytes())?;
    for (path, text) in twin::package::files() {
        write(&folder.join(path), text.as_bytes())?;
    }
    Ok(folder)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let parent = path.parent().unwrap_or(path);
    let written = fs::create_dir_all(parent).and_then(|()| fs::write(path, bytes));
    written.map_err(|e| Diagnostic::io(path, e, "choose another folder or correct its permissions"))
}
