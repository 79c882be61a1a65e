//! Reading a case: TOML to [`Case`], with the line, the key and the nearest known key in every diagnostic.

use std::path::Path;

use diagnostics::{Diagnostic, input};
use lab::table;

use super::{Case, check};

const SEE: &str = "`study simulate --help` shows every key with its unit";

/// The case in the file `path`, checked.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read, is no TOML, has an unknown, missing or mistyped key, or a number outside the
/// range that its unit allows.
pub fn read(path: &Path) -> Result<Case, Diagnostic> {
    let text =
        input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, "name a case, a page of TOML"))?;
    parse(&text, path)
}

/// The case in `text`; `path` is used in diagnostics only.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Case, Diagnostic> {
    table::parse(text, path, SEE, check::check_case)
}
