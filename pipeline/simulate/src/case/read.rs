//! Reading a case: TOML to [`Case`], with the line, the key and the nearest known key in every diagnostic.

use std::path::Path;

use diagnostics::{Diagnostic, input};
use lab::table::{line_of_path, toml_error};

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
    let text = text.trim_start_matches('\u{feff}');
    let case: Case = toml::from_str(text).map_err(|e| toml_error(text, path, &e, SEE))?;
    check::case(&case).map_err(|violation| {
        let line = line_of_path(text, &violation.key);
        Diagnostic::file(path, violation.what, violation.why, violation.action).at_line(line)
    })?;
    Ok(case)
}
