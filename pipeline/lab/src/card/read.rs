//! Reading a card: TOML to [`Card`], with the line, the key and the nearest known key in every diagnostic.

use std::path::Path;

use super::{Card, check};
use crate::table::{self, SEE};
use diagnostics::{Diagnostic, input};

/// The card in the file `path`, checked.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, is no TOML, has an unknown, missing or mistyped key, or a number outside
/// the range that its unit allows.
pub fn read(path: &Path) -> Result<Card, Diagnostic> {
    let text = input::read_text(path, input::PAGE)
        .map_err(|e| Diagnostic::io(path, e, "write a card there, or name a folder that holds one"))?;
    parse(&text, path)
}

/// The card in `text`; `path` appears only in diagnostics, and its folder's name must be the card's.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Card, Diagnostic> {
    let folder = path.parent().and_then(Path::file_name).and_then(|n| n.to_str());
    table::parse(text, path, SEE, |card| check::check_card(card, folder))
}
