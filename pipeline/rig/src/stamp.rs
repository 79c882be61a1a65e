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
pub const EDITION: u32 = 10;

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

/// The stamp of a recording: it changes with what the settings say to it, its shape, the edition and the profile.
pub fn text(specimen: &Specimen, profile: &str) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(own_settings(specimen.name, profile).as_bytes());
    hash.update(format!("{:?}", (specimen.tail)()).as_bytes());
    let (hash, name) = (hash.finalize().to_hex(), specimen.name);
    let head = format!("made by the virtual bench; the folder may be deleted and made again: rig record {name}");
    format!("{head}\nspecimen {name}\nprofile {profile}\nedition {EDITION}\nsettings {hash}\n")
}

/// What `bench.toml` says to one specimen in one profile: what it says to others alone is left out, and so are its remarks.
fn own_settings(name: &str, profile: &str) -> String {
    let mut all: toml::Table = toml::from_str(settings::TEXT).expect("the program's own settings are TOML");
    keep(&mut all, &["specimen"], name);
    keep(&mut all, &["profile"], profile);
    keep(&mut all, &["buoyancy", "water"], name);
    all.to_string()
}

/// Leaves `key` alone in the table at `path`.
fn keep(all: &mut toml::Table, path: &[&str], key: &str) {
    let table = path.iter().try_fold(all, |table, at| table.get_mut(*at)?.as_table_mut());
    table.expect("bench.toml has this table").retain(|other, _| other == key);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_to_another_specimen_or_profile_alone_leaves_a_stamp_as_it_is() {
        let own = own_settings("nemo", "quick");
        for (there, word) in [(true, "[specimen.nemo]"), (false, "[specimen.dory]"), (true, "[valve]")] {
            assert_eq!(own.contains(word), there, "{word}");
        }
        assert!(own.contains("[profile.quick") && !own.contains("[profile.paper") && !own.contains("dory ="));
        assert_ne!(own, own_settings("nemo", "paper"));
    }
}
