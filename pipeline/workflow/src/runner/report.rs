//! The report: progress on stderr while a study runs. The one place that prints progress.
//!
//! On a terminal: a bar over all records with an estimate, and a line for each record that has been finished. In a pipe, or
//! with `--quiet`: plain lines without bars.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::process::Process;
use crate::needs::RecordId;
use diagnostics::{Diagnostic, output};

/// Where progress goes.
pub struct Report {
    bars: MultiProgress,
    total: ProgressBar,
    live: bool,
    kept_lines: bool,
}

/// The progress of one running record.
pub struct Line {
    bar: ProgressBar,
}

impl Report {
    /// A report over `records` records; with `quiet`, only diagnostics and a last line are printed.
    pub fn new(records: usize, quiet: bool) -> Self {
        let live = std::io::stderr().is_terminal() && !quiet;
        let target = if live { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bars = MultiProgress::with_draw_target(target);
        let total = bars.add(ProgressBar::new(records as u64));
        total.set_style(progress_style("{bar:30} {pos}/{len} records, {elapsed} gone, about {eta} to go"));
        if live {
            total.enable_steady_tick(Duration::from_millis(500));
        }
        Self { bars, total, live, kept_lines: !quiet }
    }

    /// A record that is being made.
    pub fn begin(&self, id: &RecordId) -> Line {
        let bar = self.bars.insert_before(&self.total, ProgressBar::new(1000));
        bar.set_style(progress_style("  {prefix:32} {bar:20} {msg}"));
        bar.set_prefix(id.to_string());
        Line { bar }
    }

    /// A record that was made.
    pub fn made(&self, id: &RecordId, summary: &str, seconds: f64) {
        self.total.inc(1);
        let remaining = self.total.length().unwrap_or_default().saturating_sub(self.total.position());
        self.print_progress(&format!(
            "{:<16} {:<28} {summary:<60} made {seconds:6.1} s, {remaining} left",
            id.stage, id.subject
        ));
    }

    /// A record that is up to date.
    pub fn kept(&self, id: &RecordId) {
        if self.kept_lines && self.live {
            self.print_progress(&format!("{:<16} {:<28} {:<60} kept", id.stage, id.subject, ""));
        }
        self.total.inc(1);
    }

    /// A record that could not be made.
    pub fn failed(&self, diagnostic: &Diagnostic) {
        self.print_line(&diagnostic.to_string());
        self.total.inc(1);
    }

    /// A record that another process is making, with what to do if it is not.
    pub fn elsewhere(&self, id: &RecordId, process: &Process, remedy: &str) {
        self.print_progress(&format!("{:<16} {:<28} waits: {process} is making it; {remedy}", id.stage, id.subject));
    }

    /// A record whose inputs could not be made.
    pub fn skipped(&self, id: &RecordId, needs: &RecordId) {
        self.print_progress(&format!("{:<16} {:<28} not made: it needs {needs}", id.stage, id.subject));
        self.total.inc(1);
    }

    /// A warning.
    pub(crate) fn warn(&self, text: &str) {
        self.print_line(&format!("warning: {text}"));
    }

    /// The last line.
    pub fn end(&self, text: &str) {
        self.total.finish_and_clear();
        self.print_line(text);
    }

    fn print_progress(&self, text: &str) {
        if self.kept_lines {
            self.print_line(text);
        }
    }

    fn print_line(&self, text: &str) {
        let text = text.trim_end();
        if self.live {
            self.bars.suspend(|| output::note(text));
        } else {
            output::note(text);
        }
    }
}

impl Line {
    /// A progress line that is not printed.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// The fraction done, from 0 to 1, and the current step.
    pub fn progress(&self, fraction: f64, step: &str) {
        self.bar.set_position((fraction.clamp(0.0, 1.0) * 1000.0) as u64);
        self.bar.set_message(step.to_string());
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn progress_style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
