//! `study init`: the card of a new specimen with every key explained, and the folders that it names. Nothing is overwritten.
//!
//! Values to be filled in are marked and are `nan`, which is outside every range of a card: a missing number is
//! refused, never used.

use std::fs;
use std::io::Write;
use std::path::Path;

use diagnostics::{Diagnostic, Result};
use workflow::runner::Folders;
use workflow::settings::Profile;

use crate::proposal;

/// The initial card of a specimen; `NAME` stands for its name.
pub const CARD: &str = include_str!("card.toml");

/// Folders of a specimen.
const FOLDERS: [&str; 3] = ["cad", "camera", "trials/static_left"];

/// Creates the specimen `name` in the project at `root`; returns a summary with the next step.
///
/// # Errors
/// A [`Diagnostic`] when the name is invalid, there is no project, the card exists already, or a file cannot be written.
pub fn run(root: &Path, profile: Profile, name: &str) -> Result<String> {
    write_card(&checked_folders(root, profile, name)?, name)
}

/// Creates the specimen `name` with the card that is proposed from the recordings in `folder`, and copies of the files that it names;
/// returns the guesses and a summary with the next step.
///
/// # Errors
/// A [`Diagnostic`] as of [`run`], or when nothing can be proposed.
pub(crate) fn from_folder(root: &Path, profile: Profile, (name, folder): (&str, &Path)) -> Result<String> {
    let folders = checked_folders(root, profile, name)?;
    let proposal = proposal::propose(folder, name)?;
    let card = folders.raw_file(&format!("{name}/{}", lab::folder::CARD));
    if card.exists() {
        return Err(write_error(&folders.display(&card), &std::io::ErrorKind::AlreadyExists.into()));
    }
    for file in &proposal.files {
        let target = folders.raw_file(&format!("{name}/{file}"));
        copy_recording(&folder.join(file), &target).map_err(|e| write_error(&folders.display(&target), &e))?;
    }
    create_card(&card, &folders, &proposal.card)?;
    let card = folders.display(&card);
    let copied = proposal.files.len();
    Ok(format!(
        "{proposal}{card}: {copied} files copied; fill in the lines marked FILL IN and check the others\nthen: study doctor {name}"
    ))
}

/// Copies a file, or a folder of pictures with what lies in it.
fn copy_recording(from: &Path, to: &Path) -> std::io::Result<()> {
    if !from.is_dir() {
        to.parent().map_or(Ok(()), fs::create_dir_all)?;
        return fs::copy(from, to).map(|_| ());
    }
    fs::create_dir_all(to)?;
    fs::read_dir(from)?.try_for_each(|entry| {
        let path = entry?.path();
        path.file_name().filter(|_| path.is_file()).map_or(Ok(()), |name| fs::copy(&path, to.join(name)).map(|_| ()))
    })
}

/// # Errors
/// A [`Diagnostic`] when the name is invalid or there is no project.
fn checked_folders(root: &Path, profile: Profile, name: &str) -> Result<Folders> {
    let folders = Folders::new(root, profile);
    if !lab::card::is_name(name) {
        let reason = "it becomes part of file names: letters, digits, `_` and `-`, the first no `-`";
        return Err(Diagnostic::new(
            format!("`{name}` is not a valid name of a specimen"),
            reason,
            "choose another name",
        ));
    }
    if !folders.settings().is_file() {
        let defect = format!("{} is no project", root.display());
        return Err(Diagnostic::new(
            defect,
            "it has no study.toml",
            "run in the project's folder, or name it with --root",
        ));
    }
    Ok(folders)
}

fn write_card(folders: &Folders, name: &str) -> Result<String> {
    for folder in FOLDERS {
        let path = folders.raw_file(&format!("{name}/{folder}"));
        fs::create_dir_all(&path).map_err(|e| write_error(&folders.display(&path), &e))?;
    }
    let path = folders.raw_file(&format!("{name}/{}", lab::folder::CARD));
    let card_path = folders.display(&path);
    create_card(&path, folders, &CARD.replace("\"NAME\"", &format!("{name:?}")))?;
    let marked_lines = CARD.lines().filter(|line| line.contains("# FILL IN;")).count();
    Ok(format!(
        "{card_path}: fill in the {marked_lines} lines marked FILL IN; put the STL files into cad, the board's film or pictures into camera, films and logs into trials\nthen: study doctor {name}"
    ))
}

/// Writes a card where there is none.
fn create_card(path: &Path, folders: &Folders, card: &str) -> Result<()> {
    let created = fs::File::create_new(path).and_then(|mut file| file.write_all(card.as_bytes()));
    created.map_err(|e| write_error(&folders.display(path), &e))
}

fn write_error(shown_path: &str, error: &std::io::Error) -> Diagnostic {
    if error.kind() == std::io::ErrorKind::AlreadyExists {
        let reason = "a card is never overwritten";
        return Diagnostic::new(
            format!("{shown_path} exists already"),
            reason,
            "choose another name, or move the card away",
        );
    }
    Diagnostic::new(
        format!("{shown_path} cannot be written"),
        error,
        "check the permissions and the free space of its folder",
    )
}
