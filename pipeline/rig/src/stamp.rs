//! The stamp in a folder that the bench made: whose it is, and whether it is still what the bench would make.
//!
//! Stands on: `blake3`, the folder. Never knows: how a recording is made.

use std::path::Path;

use crate::fault::Fault;
use crate::settings;
use crate::specimen::Specimen;

/// The stamp's file.
pub const FILE: &str = ".virtual-bench";
/// Raised by hand whenever the bench would write other bytes for the same settings.
pub const EDITION: u32 = 7;

/// What lies where a recording should go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    /// Nothing.
    Nothing,
    /// The very recording that would be made.
    Current,
    /// A recording of the bench with other settings, or an unfinished one.
    Stale,
}

/// The stamp of a recording: it changes with the settings, the specimen's shape, the edition and the profile.
pub fn text(specimen: &Specimen, profile: &str) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(settings::TEXT.as_bytes());
    hash.update(format!("{:?}", (specimen.tail)()).as_bytes());
    let (hash, name) = (hash.finalize().to_hex(), specimen.name);
    let head = format!("made by the virtual bench; the folder may be deleted and made again: rig record {name}");
    format!("{head}\nspecimen {name}\nprofile {profile}\nedition {EDITION}\nsettings {hash}\n")
}

/// What lies in `folder`, where the recording stamped `text` should go.
///
/// # Errors
/// [`Fault`] when the folder is there and the bench did not make it.
pub fn look(folder: &Path, text: &str) -> Result<Found, Fault> {
    if !folder.exists() {
        return Ok(Found::Nothing);
    }
    match std::fs::read_to_string(folder.join(FILE)) {
        Ok(stamp) if stamp == text && whole(folder) => Ok(Found::Current),
        Ok(_) => Ok(Found::Stale),
        Err(_) => Err(Fault::new(
            folder.display().to_string(),
            "the folder was not made by the virtual bench",
            &format!("it has no {FILE}, and the bench never writes into a laboratory's folder"),
            "move the folder away, or record into another place with --into",
        )),
    }
}

/// Whether the card can be read and every file that it names is there.
fn whole(folder: &Path) -> bool {
    lab::Specimen::open(folder).is_ok_and(|specimen| specimen.missing().is_empty())
}
