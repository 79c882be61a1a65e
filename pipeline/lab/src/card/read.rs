//! Reading a card: TOML to [`Card`], with the line, the key and the nearest known key in every refusal.
//!
//! Stands on: the card's types and their checks. Never knows: what else lies in the folder.

use std::path::Path;

use super::{Card, check};
use crate::Refusal;
use crate::table::{SEE, line_of_path, refused};

/// The card in the file `path`, checked.
///
/// # Errors
/// [`Refusal`] when the file cannot be read, is no TOML, has an unknown, missing or mistyped key, or a number outside
/// the range that its unit allows.
pub fn read(path: &Path) -> Result<Card, Refusal> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| Refusal::io(path, &e, "write a card there, or name a folder that holds one"))?;
    parse(&text, path)
}

/// The card in `text`; `path` is only quoted in refusals, and its folder's name must be the card's.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Card, Refusal> {
    let text = text.trim_start_matches('\u{feff}');
    let card: Card = toml::from_str(text).map_err(|e| refused(text, path, &e, SEE))?;
    let folder = path.parent().and_then(Path::file_name).and_then(|n| n.to_str());
    check::card(&card, folder).map_err(|found| {
        let line = line_of_path(text, &found.key);
        Refusal::file(path, found.what, found.why, found.act).at_line(line)
    })?;
    Ok(card)
}
