//! Standard output and standard error: the one place that prints.
//!
//! `println!` panics when the reader has gone or the disk behind it is full. Here a closed pipe ends the printing and nothing else, as
//! a reader that has seen enough (`study list | head`) expects. Any other failure of standard output is reported once on standard error
//! and makes [`failed`] true, so that a program can end with exit code 1: a file that it filled is not whole.
//!
//! Names that come from files are printed in diagnostics. Control characters in them are escaped, so that no file moves a terminal's
//! cursor or changes its title.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::next_move;

/// One stream of the process.
struct Stream {
    /// No more is written after the first failure.
    closed: AtomicBool,
    /// Whether it failed for another reason than a reader that has gone.
    failed: AtomicBool,
}

static STDOUT: Stream = Stream::new();
static STDERR: Stream = Stream::new();

impl Stream {
    const fn new() -> Self {
        Self { closed: AtomicBool::new(false), failed: AtomicBool::new(false) }
    }

    /// Writes and flushes a text; returns the failure that a person should hear of, once.
    fn write_text(&self, to: &mut dyn Write, text: &str) -> Option<io::Error> {
        if self.closed.load(Ordering::Relaxed) {
            return None;
        }
        let error =
            to.write_all(escape_controls(&next_move::with_options(text)).as_bytes()).and_then(|()| to.flush()).err()?;
        let first = !self.closed.swap(true, Ordering::Relaxed);
        if error.kind() == ErrorKind::BrokenPipe {
            return None;
        }
        self.failed.store(true, Ordering::Relaxed);
        first.then_some(error)
    }
}

/// A text with its control characters but line ends and tabulators as `\u{1b}`.
fn escape_controls(text: &str) -> Cow<'_, str> {
    let harmful = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(harmful) {
        return Cow::Borrowed(text);
    }
    let each = text.chars().map(|c| if harmful(c) { c.escape_unicode().to_string() } else { c.to_string() });
    Cow::Owned(each.collect())
}

/// Prints a line on standard output.
pub fn line(text: impl std::fmt::Display) {
    write_output(&format!("{text}\n"));
}

/// Prints a text on standard output as it is.
pub fn text(text: impl std::fmt::Display) {
    write_output(&text.to_string());
}

/// Prints a line on standard error.
pub fn note(text: impl std::fmt::Display) {
    // One write a line: lines of several workers do not mix.
    let line = format!("{text}\n");
    // There is no third stream that could report a failure of this one.
    let _ = STDERR.write_text(&mut io::stderr().lock(), &line);
}

/// Whether standard output could not take all that was printed, for another reason than a reader that has gone.
pub fn failed() -> bool {
    STDOUT.failed.load(Ordering::Relaxed)
}

fn write_output(text: &str) {
    if let Some(error) = STDOUT.write_text(&mut io::stdout().lock(), text) {
        note(format_args!(
            "error: the output is not whole\n  why: {}\n  do:  free some space where it goes, or name another place",
            error.to_string().to_lowercase()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stream that fails in one way.
    struct Failing(ErrorKind);

    impl Write for Failing {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_reported_once() {
        let stream = Stream::new();
        assert!(stream.write_text(&mut Failing(ErrorKind::StorageFull), "a").is_some());
        assert!(stream.write_text(&mut Failing(ErrorKind::StorageFull), "b").is_none());
        assert!(stream.failed.load(Ordering::Relaxed));
    }

    #[test]
    fn a_program_learns_that_its_output_is_not_whole() {
        assert!(!failed());
        STDOUT.write_text(&mut Failing(ErrorKind::StorageFull), "a");
        assert!(failed());
    }

    #[test]
    fn a_name_from_a_file_does_not_reach_the_terminal_as_a_command() {
        assert_eq!(escape_controls("a\u{1b}[2Jb\n"), "a\\u{1b}[2Jb\n");
        assert!(matches!(escape_controls("region `fäß`\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn a_reader_that_has_gone_is_no_failure_and_is_not_written_to_again() {
        let stream = Stream::new();
        assert!(stream.write_text(&mut Failing(ErrorKind::BrokenPipe), "a").is_none());
        assert!(!stream.failed.load(Ordering::Relaxed));
        let mut kept = Vec::new();
        assert!(stream.write_text(&mut kept, "b").is_none());
        assert!(kept.is_empty());
    }
}
