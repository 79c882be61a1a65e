//! One diagnostic for every crate: what is wrong, why (the measured value against its limit), and the action.
//!
//! Errors are typed where they arise. Their text has three parts, separated as in [`Diagnostic`]'s own: what, `why:` and `do:`. `?`
//! turns such an error into a [`Diagnostic`], which adds file, line and the record it happened to, and keeps the error as its
//! [`source`](Diagnostic::source), so that a caller can still match on it.
//!
//! ```
//! use diagnostics::{Diagnostic, Result};
//!
//! fn levels(text: &str) -> Result<f64> {
//!     let level: f64 = text.parse()?;
//!     if level < 0.0 {
//!         return Err(Diagnostic::new(
//!             format!("the level is {level} Pa"),
//!             "levels lie between 0 and 5e5 Pa",
//!             "correct `levels` on the card",
//!         ));
//!     }
//!     Ok(level)
//! }
//! let diagnostic = levels("-3").unwrap_err().of("track/fish/static_left");
//! assert!(diagnostic.to_string().starts_with("track/fish/static_left: the level is -3 Pa\n  why: "));
//! assert!(levels("x").unwrap_err().downcast_ref::<std::num::ParseFloatError>().is_some());
//! ```
//!
//! [`input`] reads regular files up to a limit, and [`table`] refuses what is wrong with a page of TOML; [`output`] prints, and a reader that goes
//! away or a full disk ends no program; [`next_move`] makes its commands complete, and
//! [`processor`] refuses processors that a program is not compiled for.
//!
//! Depends on no other crate.

mod echo;
pub mod input;
pub mod next_move;
pub mod output;
pub mod processor;
pub mod table;

use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a fallible function of the upper crates returns.
pub type Result<T, E = Diagnostic> = std::result::Result<T, E>;

const WHY: &str = "\n  why: ";
const ACTION: &str = "\n  do:  ";

/// What is wrong, why, and what to do, with its place and its cause.
///
/// It does not implement [`Error`] itself, because the blanket `From<E: Error>` below would then overlap with `From<T> for T`.
#[derive(Debug, Clone)]
pub struct Diagnostic {
    /// The record that was being computed ("track/fish/static_left"), empty when none was.
    pub subject: String,
    /// The file of the error, and its line.
    pub location: Option<Location>,
    /// What is wrong, with numbers and units.
    pub what: String,
    /// Why: what was measured against which limit, or what was expected.
    pub why: String,
    /// What to do.
    pub action: String,
    /// Further lines: where a partial result or a picture of it lies.
    pub notes: Vec<String>,
    /// A picture (PNG) that shows it.
    pub picture: Option<Vec<u8>>,
    source: Option<Arc<dyn Error + Send + Sync>>,
}

/// A file, or a line of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// The file as it was named to the reader.
    pub file: PathBuf,
    /// Its line, from 1, where the error has one.
    pub line: Option<usize>,
}

impl Diagnostic {
    /// A diagnostic in three parts.
    pub fn new(what: impl fmt::Display, why: impl fmt::Display, action: impl fmt::Display) -> Self {
        Self {
            subject: String::new(),
            location: None,
            what: what.to_string(),
            why: why.to_string().trim_end().to_owned(),
            action: action.to_string(),
            notes: Vec::new(),
            picture: None,
            source: None,
        }
    }

    /// A diagnostic about a whole file.
    pub fn file(file: &Path, what: impl fmt::Display, why: impl fmt::Display, action: impl fmt::Display) -> Self {
        Self::new(what, why, action).in_file(file)
    }

    /// The same diagnostic with its file.
    pub fn in_file(self, file: &Path) -> Self {
        Self { location: Some(Location { file: file.to_owned(), line: None }), ..self }
    }

    /// The same diagnostic with its file, where it has none yet.
    pub fn in_file_unless_named(self, file: &Path) -> Self {
        if self.location.is_some() { self } else { self.in_file(file) }
    }

    /// A file that could not be opened, read or written.
    pub fn io(file: &Path, error: std::io::Error, action: impl fmt::Display) -> Self {
        let reason = error.to_string().to_lowercase();
        Self::file(file, "the file cannot be used", reason, action).caused_by(error)
    }

    /// The end of a computation that was asked to end.
    pub fn interrupted() -> Self {
        Self::new("the computation was interrupted", "an interrupt was requested", "start it again to have its results")
    }

    /// The same diagnostic with a line (from 1) of its file.
    pub fn at_line(mut self, line: impl Into<Option<usize>>) -> Self {
        if let Some(location) = &mut self.location {
            location.line = line.into();
        }
        self
    }

    /// The same diagnostic with a picture (PNG) of it.
    pub fn showing(self, picture: Vec<u8>) -> Self {
        Self { picture: Some(picture), ..self }
    }

    /// The same diagnostic with a further line.
    pub fn noting(mut self, note: impl fmt::Display) -> Self {
        self.notes.push(note.to_string());
        self
    }

    /// The same diagnostic, with what was being done before what is wrong: "no equilibrium at 120 mbar: …".
    pub fn while_doing(self, doing: impl fmt::Display) -> Self {
        Self { what: format!("{doing}: {}", self.what), ..self }
    }

    /// The same diagnostic with its record; a record that is already set is kept.
    pub fn of(mut self, record: impl fmt::Display) -> Self {
        if self.subject.is_empty() {
            self.subject = record.to_string();
        }
        self
    }

    /// The same diagnostic with the error that led to it.
    pub fn caused_by(self, source: impl Error + Send + Sync + 'static) -> Self {
        Self { source: Some(Arc::new(source)), ..self }
    }

    /// The error that led to it.
    pub fn source(&self) -> Option<&(dyn Error + Send + Sync + 'static)> {
        self.source.as_deref()
    }

    /// The error that led to it, or one that led to that, where it is of this type.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        let mut next: Option<&(dyn Error + 'static)> = Some(self.source()?);
        while let Some(error) = next {
            if let Some(found) = error.downcast_ref::<E>() {
                return Some(found);
            }
            next = error.source();
        }
        None
    }

    /// The line of the error, from 1.
    pub fn line(&self) -> Option<usize> {
        self.location.as_ref().and_then(|location| location.line)
    }
}

impl<E: Error + Send + Sync + 'static> From<E> for Diagnostic {
    /// Typed errors write their three parts as one text; an error of another library has one part, and its source becomes the reason.
    fn from(error: E) -> Self {
        let text = error.to_string();
        let (what, rest) = text.split_once(WHY).unwrap_or((&text, ""));
        let (reason, action) = rest.split_once(ACTION).unwrap_or((rest, ""));
        let below = || error.source().map(ToString::to_string).filter(|below| !text.contains(below.as_str()));
        let reason = if reason.is_empty() { below().unwrap_or_default() } else { reason.to_owned() };
        Self::new(what, reason, action).caused_by(error)
    }
}

impl PartialEq for Diagnostic {
    /// Compares what a reader sees.
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string() && self.picture == other.picture
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}, line {line}", echo::escaped_token(&self.file.display().to_string())),
            None => write!(f, "{}", echo::escaped_token(&self.file.display().to_string())),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.subject.is_empty() {
            write!(f, "{}: ", echo::escaped_token(&self.subject))?;
        }
        if let Some(location) = &self.location {
            write!(f, "{location}: ")?;
        }
        f.write_str(&echo::escaped_message(&self.what))?;
        for (label, text) in [(WHY, &self.why), (ACTION, &self.action)] {
            if !text.is_empty() {
                write!(f, "{label}{}", echo::escaped_message(text))?;
            }
        }
        self.notes.iter().try_for_each(|note| write!(f, "\n  {}", echo::escaped_message(note)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("the gap is 3 mm\n  why: the limit is 1 mm\n  do:  close it")]
    struct Gap(#[source] std::io::Error);

    #[test]
    fn a_typed_error_keeps_its_parts_and_stays_the_source() {
        let diagnostic = Diagnostic::from(Gap(std::io::Error::other("disk")));
        assert_eq!((&*diagnostic.what, &*diagnostic.why), ("the gap is 3 mm", "the limit is 1 mm"));
        assert_eq!(diagnostic.action, "close it");
        assert!(diagnostic.downcast_ref::<Gap>().is_some());
        assert!(diagnostic.downcast_ref::<std::io::Error>().is_some());
        assert!(diagnostic.downcast_ref::<std::num::ParseIntError>().is_none());
    }

    #[test]
    fn the_first_record_is_kept() {
        let diagnostic = Diagnostic::new("a is b", "c", "d").of("track/x").of("later");
        assert_eq!(diagnostic.to_string(), "track/x: a is b\n  why: c\n  do:  d");
    }

    #[test]
    fn file_and_line_come_before_what_is_wrong() {
        let diagnostic = Diagnostic::file(Path::new("force.csv"), "a is b", "c", "d").at_line(3);
        assert_eq!(diagnostic.to_string(), "force.csv, line 3: a is b\n  why: c\n  do:  d");
        assert_eq!(diagnostic.line(), Some(3));
    }

    #[test]
    fn what_was_being_done_comes_before_what_is_wrong_and_notes_come_last() {
        let diagnostic = Diagnostic::new("a is b", "c", "d").while_doing("level 2").noting("see: e");
        assert_eq!(diagnostic.to_string(), "level 2: a is b\n  why: c\n  do:  d\n  see: e");
    }

    #[test]
    fn the_first_file_is_kept() {
        let of = |error: Diagnostic| error.in_file_unless_named(Path::new("case.toml")).to_string();
        assert!(of(Diagnostic::new("a is b", "c", "d")).starts_with("case.toml: a is b"));
        let mesh = Diagnostic::file(Path::new("body.msh"), "a is b", "c", "d").at_line(3);
        assert!(of(mesh).starts_with("body.msh, line 3: a is b"));
    }

    #[test]
    fn another_text_or_another_picture_is_another_diagnostic() {
        let lost = |what: &str, picture: u8| Diagnostic::new(what, "c", "d").showing(vec![picture]);
        assert_eq!(lost("a", 1), lost("a", 1));
        assert_ne!(lost("a", 1), lost("a", 2));
        assert_ne!(lost("a", 1), lost("b", 1));
    }

    #[test]
    fn an_error_without_parts_is_shown_alone() {
        assert_eq!(Diagnostic::from(std::fmt::Error).to_string(), std::fmt::Error.to_string());
    }
}
