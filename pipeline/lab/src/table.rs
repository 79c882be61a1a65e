//! Pages of TOML whose entries are checked: cards, cases, and the pages of tests.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::range::Checked;
use diagnostics::Diagnostic;
pub(crate) use diagnostics::table::nearest;
pub use diagnostics::table::{line_of_path, toml_error};

/// Where the keys of a card are explained.
pub(crate) const SEE: &str = "data/raw/README.md has every key with its unit";

/// A page of TOML without NaN or infinities that passes its `check`; `see` says where its keys are explained.
///
/// # Errors
/// A [`Diagnostic`] with the line of an unknown, missing or mistyped key, of a number that is not finite, or of the entry that the check found.
pub fn parse<T: DeserializeOwned>(
    text: &str,
    path: &Path,
    see: &str,
    check: impl FnOnce(&T) -> Checked,
) -> Result<T, Diagnostic> {
    let page: T = toml::from_str(text).map_err(|e| toml_error(text, path, &e, see))?;
    diagnostics::table::check_finite(text, path, see)?;
    check(&page).map_err(|violation| {
        let line = line_of_path(text, &violation.key);
        Diagnostic::file(path, violation.what, violation.why, violation.action).at_line(line)
    })?;
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_refused_at_the_line_of_a_wrong_key_or_number_and_read_past_a_byte_order_mark() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Page {
            held: f64,
        }
        let check = |page: &Page| crate::range::within("held", page.held, 0.0..=9.0, "s");
        let read = |text: &str| parse::<Page>(text, Path::new("page.toml"), "see the manual", check);
        assert_eq!(read("\u{feff}held = 3.0").unwrap().held, 3.0);
        let line = |text: &str| read(text).unwrap_err().location.and_then(|at| at.line);
        assert_eq!([line("# s\nheld = 30.0"), line("held = 3.0\n\nhold = 1")], [Some(2), Some(3)]);
    }
}
