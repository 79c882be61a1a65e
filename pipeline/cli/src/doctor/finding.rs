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
    /// How much it matters.
    pub severity: Severity,
}

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// It must be fixed.
    Fix,
    /// It does not stop the study.
    Note,
    /// How a log is read: nothing is wrong.
    Log,
}

impl Finding {
    /// A problem that must be fixed.
    pub fn fix(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into(), act: act.into(), severity: Severity::Fix }
    }

    /// A note.
    pub fn note(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { severity: Severity::Note, ..Self::fix(what, why, act) }
    }

    /// How a log is read: what it is, and what is made of it.
    pub fn log(what: impl Into<String>, method: impl Into<String>) -> Self {
        Self { severity: Severity::Log, ..Self::fix(what, method, "") }
    }

    /// Whether it must be fixed.
    pub(crate) fn must_fix(&self) -> bool {
        self.severity == Severity::Fix
    }

    /// A tool's error, with what, `why:` and `do:` on separate lines.
    pub fn message(text: &str) -> Self {
        let (what, remedy) = text.split_once("\n  why:").unwrap_or((text, ""));
        let (why, act) = remedy.split_once("\n  do:").unwrap_or((remedy, ""));
        Self::fix(what.trim(), why.trim(), act.trim())
    }
}

impl From<Diagnostic> for Finding {
    fn from(diagnostic: Diagnostic) -> Self {
        let location = diagnostic.location.as_ref().map_or_else(String::new, |location| format!("{location}: "));
        Self::fix(format!("{location}{}", diagnostic.what), diagnostic.why, diagnostic.action)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let [what, why, act] = [&self.what, &self.why, &self.act].map(|text| one_line(text));
        match self.severity {
            Severity::Fix => write!(f, "fix  {what}; {why}; do: {act}"),
            Severity::Note => write!(f, "note  {what}; {why}; do: {act}"),
            Severity::Log => write!(f, "log  {what}; {why}"),
        }
    }
}

/// The findings of several checks in their order.
pub(crate) fn all_findings(checks: impl IntoIterator<Item = Vec<Finding>>) -> Vec<Finding> {
    checks.into_iter().flatten().collect()
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
