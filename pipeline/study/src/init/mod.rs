//! `study init`: the card of a new specimen with every key explained, and the folders that it names. Nothing is written over.
//!
//! What must be filled in is marked and stands as `nan`, which no range of a card holds: a number that was forgotten is
//! refused, never used.
//!
//! Stands on: folders, the names of `lab`. Never knows: what a recording holds.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::fault::{Fault, Outcome};
use crate::runner::Folders;
use crate::settings::Profile;

/// The card of every specimen at its beginning; its name stands as `NAME`.
pub const CARD: &str = include_str!("card.toml");

/// Folders of a specimen.
const FOLDERS: [&str; 3] = ["cad", "camera", "trials/static_left"];

/// Begins the specimen `name` in the project at `root`; says what was made and what comes next.
///
/// # Errors
/// A [`Fault`] when the name is none, there is no project, the card is there already, or the disk refuses.
pub fn run(root: &Path, profile: Profile, name: &str) -> Outcome<String> {
    let folders = Folders::new(root, profile);
    if !lab::card::is_name(name) {
        let why = "it becomes part of file names: letters, digits, `_` and `-`";
        return Err(Fault::new(format!("`{name}` is no name of a specimen"), why, "choose another name"));
    }
    if !folders.settings().is_file() {
        let what = format!("{} is no project", root.display());
        return Err(Fault::new(what, "it has no study.toml", "run in the project's folder, or name it with --root"));
    }
    write(&folders, name)
}

fn write(folders: &Folders, name: &str) -> Outcome<String> {
    for folder in FOLDERS {
        let path = folders.raw_file(&format!("{name}/{folder}"));
        fs::create_dir_all(&path).map_err(|e| refused(&folders.tell(&path), &e))?;
    }
    let path = folders.raw_file(&format!("{name}/{}", lab::folder::CARD));
    let place = folders.tell(&path);
    let mut file = fs::File::create_new(&path).map_err(|e| refused(&place, &e))?;
    file.write_all(CARD.replace("\"NAME\"", &format!("{name:?}")).as_bytes()).map_err(|e| refused(&place, &e))?;
    let marked = CARD.lines().filter(|line| line.contains("# FILL IN;")).count();
    Ok(format!(
        "{place}: fill in the {marked} lines marked FILL IN; put the STL files into cad, the board's film into camera, films and logs into trials\nthen: study doctor {name}"
    ))
}

fn refused(place: &str, error: &std::io::Error) -> Fault {
    if error.kind() == std::io::ErrorKind::AlreadyExists {
        let why = "a card is never written over";
        return Fault::new(format!("{place} is there already"), why, "take another name, or move the card away");
    }
    Fault::new(format!("{place} cannot be written"), error, "check the permissions and the free space of its folder")
}
