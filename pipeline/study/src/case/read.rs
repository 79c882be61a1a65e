//! Reading a case: TOML to [`Case`], with the line, the key and the nearest known key in every refusal.
//!
//! Stands on: the case's types and their checks, lab's words. Never knows: what lies beside the case.

use std::path::Path;

use lab::Refusal;
use lab::table::{line_of_path, refused};

use super::{Case, check};

const SEE: &str = "`study simulate --help` shows every key with its unit";

/// The case in the file `path`, checked.
///
/// # Errors
/// [`Refusal`] when the file cannot be read, is no TOML, has an unknown, missing or mistyped key, or a number outside the
/// range that its unit allows.
pub fn read(path: &Path) -> Result<Case, Refusal> {
    let text = std::fs::read_to_string(path).map_err(|e| Refusal::io(path, &e, "name a case, a page of TOML"))?;
    parse(&text, path)
}

/// The case in `text`; `path` is only quoted in refusals.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Case, Refusal> {
    let text = text.trim_start_matches('\u{feff}');
    let case: Case = toml::from_str(text).map_err(|e| refused(text, path, &e, SEE))?;
    check::case(&case).map_err(|found| {
        let line = line_of_path(text, &found.key);
        Refusal::file(path, found.what, found.why, found.act).at_line(line)
    })?;
    Ok(case)
}
