//! The page of a joint fit: the tests of one material, and the laws that are compared.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};
use lab::range::{Checked, violation, within};
use lab::table;
use serde::Deserialize;
use si::{Metre, Pascal};

use super::laws::{LAWS, Law};

/// The contents of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Page {
    /// `joint`.
    pub test: String,
    /// Name of the results.
    pub name: String,
    /// Pages of free vibration, inflation and tensile tests, relative to this one.
    #[serde(default)]
    pub tests: Vec<PathBuf>,
    /// The laws that are compared, from the plainest to the richest.
    pub laws: Vec<String>,
    /// Edge of the meshes of inflated bodies, m.
    pub edge: Metre,
    /// Conditions that are predicted and never fitted, by name.
    #[serde(default)]
    pub held_out: Vec<String>,
    /// Pressures of the inflation tests that were not recorded and are predicted, Pa.
    #[serde(default)]
    pub pressures: Vec<Pascal>,
}

impl Page {
    /// The page in the file `path`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it cannot be read, has an unknown or missing key, or names no test or no law.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, "name a page of TOML"))?;
        Self::parse(&text, path)
    }

    /// The page in `text`; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// As [`Page::read`].
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self> {
        table::parse(text, path, "pipeline/sysid/examples/real has a page with every key", Self::check)
    }

    fn check(&self) -> Checked {
        let law_names: Vec<&str> = LAWS.iter().map(|law| law.name).collect();
        if let Some(unknown) = self.laws.iter().find(|name| !law_names.contains(&name.as_str())) {
            let message = format!("there is no law `{unknown}`");
            let available_laws = format!("laws: {}", law_names.join(", "));
            return violation("laws", message, &available_laws, "correct its name");
        }
        if self.laws.is_empty() || self.tests.is_empty() {
            return violation("", "it names no law or no test", "one of each is fitted", "name them");
        }
        within("edge", self.edge, 1e-4..=0.1, "m")?;
        self.pressures.iter().try_for_each(|pressure| within("pressures", *pressure, -1e5..=1e7, "Pa"))
    }

    /// The laws of the page, from the plainest to the richest.
    pub(super) fn laws(&self) -> Vec<&'static Law> {
        LAWS.iter().filter(|law| self.laws.iter().any(|name| name == law.name)).collect()
    }
}

/// The kind of test that a page names; a page that names none is that of a free vibration.
pub(super) fn kind(path: &Path) -> Result<String> {
    let text = input::read_text(path, input::PAGE).map_err(|e| Diagnostic::io(path, e, "name a page of TOML"))?;
    let table = text.parse::<toml::Table>();
    let kind = table.ok().and_then(|page| page.get("test").and_then(|test| test.as_str().map(str::to_owned)));
    Ok(kind.unwrap_or_else(|| "free_vibration".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = include_str!("../../examples/real/ds10.toml");

    #[test]
    fn the_page_that_comes_along_is_read_and_a_slip_of_the_pen_is_refused() {
        let page = Page::parse(PAGE, Path::new("page.toml")).unwrap();
        assert_eq!(page.laws().len(), page.laws.len());
        for (from, to, expected) in [
            ("edge = ", "edges = ", "edges"),
            ("\"yeoh_c20\"", "\"yoeh\"", "there is no law"),
            ("edge = 0", "edge = 8", "out of range"),
        ] {
            assert!(PAGE.contains(from), "{from}");
            let refused = Page::parse(&PAGE.replace(from, to), Path::new("page.toml")).unwrap_err().to_string();
            assert!(refused.contains(expected) && refused.contains("do:"), "{refused}");
        }
    }
}
