//! Instruments by themselves, without a card, a film of a specimen or a project.
//!
//! [`calibrate`] makes a camera file of a film or a folder of pictures of a board. [`force`] makes a table and a figure of force and pressure
//! logs: the fixture's dynamics from taps, standing waves from still water, the static cross-talk of pressure and the cell's lag from
//! staircases, and the mean force of each run over whole cycles with its interval.
//!
//! Depends on `track`, `signal`, `lab` and `plot`.

pub mod calibrate;
pub mod force;

use std::path::Path;

use diagnostics::{Diagnostic, Result};

/// Writes a result.
fn write(folder: &Path, name: &str, text: &str) -> Result<()> {
    let path = folder.join(name);
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, text));
    written.map_err(|e| Diagnostic::io(&path, e, "name another folder with --out"))
}
