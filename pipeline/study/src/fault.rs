//! Faults: what a person reads when something is wrong, with the specimen, trial and stage it happened to.
//!
//! Tool crates know the cause and say `what`, `why:` and `do:` in their own error's text; a fault adds where.
//!
//! Stands on: nothing. Never knows: how it is printed.

use std::fmt;

/// One thing that went wrong, in the three parts that a person needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Which record was being made ("track/nemo/static_left"), empty when none was.
    pub of: String,
    /// What and where, with numbers and units; further lines may already hold `why:` and `do:`.
    pub what: String,
    /// A picture (PNG) that shows it, for the runner to put beside the record.
    pub shows: Option<Vec<u8>>,
}

/// What a stage returns.
pub type Outcome<T> = Result<T, Fault>;

impl Fault {
    /// A fault from the text of a tool's error, which holds its own `why:` and `do:` lines.
    pub fn from_tool(error: impl fmt::Display) -> Self {
        Self { of: String::new(), what: error.to_string(), shows: None }
    }

    /// A fault in three parts.
    pub fn new(what: impl fmt::Display, why: impl fmt::Display, next: impl fmt::Display) -> Self {
        Self { of: String::new(), what: format!("{what}\n  why: {why}\n  do:  {next}"), shows: None }
    }

    /// The same fault with a picture (PNG) of it.
    pub fn showing(self, picture: Vec<u8>) -> Self {
        Self { shows: Some(picture), ..self }
    }

    /// The same fault, said of a record.
    pub fn of(mut self, record: impl fmt::Display) -> Self {
        if self.of.is_empty() {
            self.of = record.to_string();
        }
        self
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.of.as_str() {
            "" => write!(f, "error: {}", self.what),
            of => write!(f, "error: {of}: {}", self.what),
        }
    }
}

impl std::error::Error for Fault {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_names_the_record_it_happened_to_once() {
        let fault = Fault::new("a is b", "c", "d").of("track/x").of("later");
        assert_eq!(fault.to_string(), "error: track/x: a is b\n  why: c\n  do:  d");
    }
}
