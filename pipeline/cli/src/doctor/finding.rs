//! A finding in one line: what, where, and the next action.

use std::fmt;

use diagnostics::Diagnostic;

/// A finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What and where, with numbers and units.
    pub what: String,
    /// Measured against limit.
    pub why: String,
    /// The next action.
    pub act: String,
    /// Whether it must be fixed; otherwise it is a note.
    pub must: bool,
}

impl Finding {
    /// A problem that must be fixed.
    pub fn fix(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into(), act: act.into(), must: true }
    }

    /// A note.
    pub fn note(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { must: false, ..Self::fix(what, why, act) }
    }

    /// A tool's error, with what, `why:` and `do:` on separate lines.
    pub fn message(text: &str) -> Self {
        let (what, rest) = text.split_once("\n  why:").unwrap_or((text, ""));
        let (why, act) = rest.split_once("\n  do:").unwrap_or((rest, ""));
        Self::fix(what.trim(), why.trim(), act.trim())
    }
}

impl From<Diagnostic> for Finding {
    fn from(diagnostic: Diagnostic) -> Self {
        let place = diagnostic.location.as_ref().map_or_else(String::new, |location| format!("{location}: "));
        Self::fix(format!("{place}{}", diagnostic.what), diagnostic.why, diagnostic.action)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.must { "fix" } else { "note" };
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let [what, why, act] = [&self.what, &self.why, &self.act].map(|text| one_line(text));
        write!(f, "{word}  {what}; {why}; do: {act}")
    }
}

/// The findings of several checks in their order.
pub fn findings(looks: impl IntoIterator<Item = Vec<Finding>>) -> Vec<Finding> {
    looks.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_in_three_lines_is_told_in_one() {
        let finding = Finding::from(Diagnostic::new("a film is dark", "it has\n3 of 255", "light it"));
        assert_eq!(finding.to_string(), "fix  a film is dark; it has 3 of 255; do: light it");
    }
}
