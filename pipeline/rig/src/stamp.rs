//! The stamp in a folder that the bench made: it identifies the folder, and a change of it makes the recording stale.
//!
//! The stamp hashes the settings of its own specimen and profile: a change of Nemo's load cell leaves Dory's recordings current.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};

use crate::settings;
use crate::specimen::{Draw, SHEET, Specimen};

/// The stamp's file.
pub const FILE: &str = ".virtual-bench";
/// Incremented by hand whenever the bench writes other bytes for the same settings.
pub const VERSION: u32 = 15;

/// State of the folder of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FolderState {
    /// There is none, or an empty one.
    Absent,
    /// It holds the recording that would be made.
    Current,
    /// It holds a recording made with other settings, or an incomplete one.
    Stale,
}

/// The stamp of a recording: it changes with the settings that apply to it, its shape, the bench's version and the profile.
pub fn stamp_text(specimen: &Specimen, profile: &str) -> String {
    let mut hash = blake3::Hasher::new();
    hash.update(settings_of(specimen, profile).as_bytes());
    hash.update(format!("{:?}", (specimen.tail)()).as_bytes());
    let (hash, name) = (hash.finalize().to_hex(), &specimen.name);
    let again = match specimen.draw {
        None => format!("rig record {name}"),
        Some(Draw { seed, number }) => format!("rig draw {number} --seed {seed}"),
    };
    let head = format!("made by the virtual bench; the folder may be deleted and made again: {again}");
    format!("{head}\nspecimen {name}\nprofile {profile}\nedition {VERSION}\nsettings {hash}\n")
}

/// The settings that decide the recording of a specimen. One of a population has those of its design, of the population and its draw.
fn settings_of(specimen: &Specimen, profile: &str) -> String {
    let mut settings: toml::Table = toml::from_str(settings::TEXT).expect("the program's own settings are TOML");
    let population = settings.remove("population").expect("bench.toml has a population");
    match (specimen.draw, population.get("like").and_then(toml::Value::as_str)) {
        (Some(draw), Some(like)) => format!("{}{population}{draw:?}", own_settings(settings, like, profile)),
        _ => own_settings(settings, &specimen.name, profile),
    }
}

/// The settings that apply to one specimen in one profile, without those of the others and without comments.
fn own_settings(mut all: toml::Table, name: &str, profile: &str) -> String {
    let body = all["specimen"][name]["body"].as_str().expect("a specimen has a silicone").to_owned();
    retain_keys(&mut all, &["material"], &[&body, SHEET]);
    retain_keys(&mut all, &["specimen"], &[name]);
    retain_keys(&mut all, &["profile"], &[profile]);
    retain_keys(&mut all, &["buoyancy", "water"], &[name]);
    // which specimens a profile records by default changes none of their recordings
    if let Some(own) = all["profile"].get_mut(profile).and_then(toml::Value::as_table_mut) {
        own.remove("specimens");
    }
    all.to_string()
}

/// Removes every key but `keys` from the table at `path`.
fn retain_keys(settings: &mut toml::Table, path: &[&str], keys: &[&str]) {
    let table = path.iter().try_fold(settings, |table, key| table.get_mut(*key)?.as_table_mut());
    table.expect("bench.toml has this table").retain(|other, _| keys.contains(&other));
}

/// The state of `folder` for the recording whose stamp is `text`.
///
/// # Errors
/// When the folder exists and was not made by the bench.
pub fn inspect_folder(folder: &Path, text: &str) -> Result<FolderState> {
    // a workflow engine makes the folder before the job that fills it
    if std::fs::read_dir(folder).map_or(!folder.exists(), |mut entries| entries.next().is_none()) {
        return Ok(FolderState::Absent);
    }
    match input::read_text(&folder.join(FILE), input::PAGE) {
        Ok(stamp) if stamp == text && is_complete(folder) => Ok(FolderState::Current),
        Ok(_) => Ok(FolderState::Stale),
        Err(_) => Err(Diagnostic::file(
            folder,
            "the folder was not made by the virtual bench",
            format!("it has no {FILE}; the bench does not overwrite recordings of a laboratory"),
            "move the folder, or record into another one with --into",
        )),
    }
}

/// Whether the card can be read and every file that it names exists, and the truth, which is written last.
fn is_complete(folder: &Path) -> bool {
    let has_files = lab::Specimen::open(folder).is_ok_and(|specimen| specimen.missing().is_empty());
    has_files && folder.join(lab::folder::TRUTH).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::{population, specimens};

    #[test]
    fn settings_of_another_specimen_or_profile_do_not_enter_a_stamp() {
        let of = |profile: &str| settings_of(&specimens::ALL[0], profile);
        let own = of("quick");
        for (expected, word) in [
            (true, "[specimen.nemo]"),
            (false, "[specimen.dory]"),
            (true, "[material.dragon_skin_10]"),
            (false, "[material.dragon_skin_20]"),
            (true, "[valve]"),
        ] {
            assert_eq!(own.contains(word), expected, "{word}");
        }
        assert!(own.contains("[profile.quick") && !own.contains("[profile.paper") && !own.contains("dory ="));
        assert!(!own.contains("population"), "{own}");
        assert_ne!(own, of("paper"));
    }

    #[test]
    fn the_draw_of_a_population_enters_the_stamps_of_its_specimens() {
        let text = |seed, number| {
            stamp_text(&population::draw_member(&Settings::built_in(), Draw { seed, number }).specimen, "quick")
        };
        assert_eq!(text(1, 2), text(1, 2));
        assert!(text(1, 2) != text(2, 2) && text(1, 2) != text(1, 3));
        assert!(text(1, 2).contains("rig draw 2 --seed 1"));
    }
}
