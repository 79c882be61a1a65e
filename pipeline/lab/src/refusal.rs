//! Why a file of `data/raw` is refused: where, what, why, and the next move.
//!
//! Stands on: nothing. Never knows: what kind of file it was.

use std::path::{Path, PathBuf};

/// A file, or a line of it, that cannot be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The file as it was named to the reader.
    pub file: PathBuf,
    /// Its line, from 1, where one line is to blame.
    pub line: Option<usize>,
    /// What is wrong.
    pub what: String,
    /// What was expected.
    pub why: String,
    /// The next move.
    pub act: String,
}

impl Refusal {
    /// A refusal of a whole file.
    pub fn file(file: &Path, what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, what: what.into(), why: why.into(), act: act.into() }
    }

    /// The same refusal, blamed on one line (from 1).
    pub fn at_line(mut self, line: impl Into<Option<usize>>) -> Self {
        self.line = line.into();
        self
    }

    /// A file that could not be opened, read or written.
    pub fn io(file: &Path, error: &std::io::Error, act: impl Into<String>) -> Self {
        Self::file(file, "the file cannot be used", error.to_string().to_lowercase(), act)
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}, line {line}: {}", self.file.display(), self.what)?,
            None => write!(f, "{}: {}", self.file.display(), self.what)?,
        }
        write!(f, "\n  why: {}\n  do:  {}", self.why, self.act)
    }
}

impl std::error::Error for Refusal {}
