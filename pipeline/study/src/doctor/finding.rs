//! A finding: what, where, and what to do, in one line.
//!
//! Stands on: faults. Never knows: who found it.

use std::fmt;

use lab::Refusal;

use crate::fault::Fault;

/// One thing that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What and where, with numbers and units.
    pub what: String,
    /// Measured against limit.
    pub why: String,
    /// The next move.
    pub act: String,
    /// Whether it must be mended; otherwise it is good to know.
    pub must: bool,
}

impl Finding {
    /// Something that must be mended.
    pub fn mend(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into(), act: act.into(), must: true }
    }

    /// Something good to know.
    pub fn note(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { must: false, ..Self::mend(what, why, act) }
    }

    /// A tool's error, which says what, `why:` and `do:` in lines of their own.
    pub fn said(text: &str) -> Self {
        let (what, rest) = text.split_once("\n  why:").unwrap_or((text, ""));
        let (why, act) = rest.split_once("\n  do:").unwrap_or((rest, ""));
        Self::mend(what.trim(), why.trim(), act.trim())
    }
}

impl From<Fault> for Finding {
    fn from(fault: Fault) -> Self {
        Self::said(&fault.what)
    }
}

impl From<Refusal> for Finding {
    fn from(refusal: Refusal) -> Self {
        Self::said(&refusal.to_string())
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.must { "mend" } else { "know" };
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let [what, why, act] = [&self.what, &self.why, &self.act].map(|text| one_line(text));
        write!(f, "{word}  {what}; {why}; do: {act}")
    }
}

/// Several looks' findings in their order.
pub fn findings(looks: impl IntoIterator<Item = Vec<Finding>>) -> Vec<Finding> {
    looks.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_in_three_lines_is_told_in_one() {
        let finding = Finding::from(Fault::new("a film is dark", "it has\n3 of 255", "light it"));
        assert_eq!(finding.to_string(), "mend  a film is dark; it has 3 of 255; do: light it");
    }
}
