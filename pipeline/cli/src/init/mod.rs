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

/// The initial card of a specimen; `NAME` stands for its name.
pub const CARD: &str = include_str!("card.toml");

/// Folders of a specimen.
const FOLDERS: [&str; 3] = ["cad", "camera", "trials/static_left"];

/// Creates the specimen `name` in the project at `root`; returns a summary with the next step.
///
/// # Errors
/// A [`Diagnostic`] when the name is invalid, there is no project, the card exists already, or a file cannot be written.
pub fn run(root: &Path, profile: Profile, name: &str) -> Result<String> {
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
    write_card(&folders, name)
}

fn write_card(folders: &Folders, name: &str) -> Result<String> {
    for folder in FOLDERS {
        let path = folders.raw_file(&format!("{name}/{folder}"));
        fs::create_dir_all(&path).map_err(|e| write_error(&folders.display(&path), &e))?;
    }
    let path = folders.raw_file(&format!("{name}/{}", lab::folder::CARD));
    let card_path = folders.display(&path);
    let mut file = fs::File::create_new(&path).map_err(|e| write_error(&card_path, &e))?;
    file.write_all(CARD.replace("\"NAME\"", &format!("{name:?}")).as_bytes())
        .map_err(|e| write_error(&card_path, &e))?;
    let marked_lines = CARD.lines().filter(|line| line.contains("# FILL IN;")).count();
    Ok(format!(
        "{card_path}: fill in the {marked_lines} lines marked FILL IN; put the STL files into cad, the board's film or pictures into camera, films and logs into trials\nthen: study doctor {name}"
    ))
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
