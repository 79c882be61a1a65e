//! Checks of single entries of a card: points, pixels, names, files and lists.

use std::collections::BTreeSet;

use crate::range::{Checked, violation, within};

/// Upper limit of pixel coordinates; no picture is larger.
const PICTURE: f64 = 20_000.0;

pub(super) fn check_point(key: &str, coordinates: &[f64; 3]) -> Checked {
    coordinates.iter().enumerate().try_for_each(|(i, x)| within(&format!("{key}.{i}"), *x, -1.0..=1.0, "m"))
}

pub(super) fn check_pixel(key: &str, coordinates: &[f64; 2]) -> Checked {
    coordinates.iter().enumerate().try_for_each(|(i, x)| within(&format!("{key}.{i}"), *x, 0.0..=PICTURE, "px"))
}

/// Whether a text can name a specimen, a trial or a part: it becomes part of file names and of command lines.
pub fn is_name(text: &str) -> bool {
    !text.is_empty()
        && !text.starts_with('-')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

/// A name becomes part of file names: letters, digits, `_` and `-`, the first no `-`.
pub(super) fn check_name(key: &str, text: &str) -> Checked {
    if is_name(text) {
        return Ok(());
    }
    let reason = "a name becomes part of file names: letters, digits, `_` and `-`, the first no `-`";
    violation(key, format!("{key} = `{text}` is no name"), reason, "choose another name")
}

/// Files lie in the specimen's folder, so that the folder can be moved.
pub(super) fn check_relative(key: &str, file: &str) -> Checked {
    let is_plain = file.split('/').all(|part| !part.is_empty() && part != "." && part != "..");
    if is_plain && !file.contains('\\') && !file.contains(':') {
        return Ok(());
    }
    let reason = "files lie in the specimen's folder and are named relative to it, parts parted by `/`";
    violation(
        key,
        format!("{key} = `{file}` leaves the folder"),
        reason,
        "move the file into the folder and name it relative to the card",
    )
}

pub(super) fn check_not_empty(key: &str, count: usize) -> Checked {
    match count {
        0 => violation(key, format!("`{key}` is empty"), "at least one is needed", "add one"),
        _ => Ok(()),
    }
}

pub(super) fn check_unique<'a>(table: &str, key: &str, names: impl Iterator<Item = &'a str>) -> Checked {
    let mut previous_names = BTreeSet::new();
    for (i, word) in names.enumerate() {
        check_name(&format!("{table}.{i}.{key}"), word)?;
        if !previous_names.insert(word) {
            let defect = format!("{table} {key} `{word}` stands twice");
            return violation(
                &format!("{table}.{i}.{key}"),
                defect,
                "results are filed under it",
                "rename one of them",
            );
        }
    }
    Ok(())
}
