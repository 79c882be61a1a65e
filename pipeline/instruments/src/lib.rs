//! Instruments by themselves, without a card, a film of a specimen or a project.
//!
//! [`calibrate`] makes a camera file of a film or a folder of pictures of a board. [`film`] tracks markers through any film. [`force`] makes a table and a figure of force and pressure
//! logs: the fixture's dynamics from taps, standing waves from still water, the static cross-talk of pressure and the cell's lag from
//! staircases, and the mean force of each run over whole cycles with its interval.
//!
//! Depends on `track`, `signal`, `lab` and `plot`.

pub mod calibrate;
pub mod film;
pub mod force;

use std::path::Path;

use diagnostics::{Diagnostic, Result};

/// Asked now and then, whether to end a long computation; none where nothing can.
pub type Interrupt<'a> = Option<&'a dyn Fn() -> bool>;

/// # Errors
/// A [`Diagnostic`] when a computation is to end.
fn check_interrupt(interrupt: Interrupt<'_>) -> Result<()> {
    interrupt.is_none_or(|asked| !asked()).then_some(()).ok_or_else(Diagnostic::interrupted)
}

/// Writes a result.
fn write_result(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> Result<()> {
    let path = folder.join(name);
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, content));
    written.map_err(|e| cannot_write(&path, &e))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::new(format!("{} cannot be written", path.display()), error, "choose another folder with --out")
}
