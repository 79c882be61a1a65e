//! Progress on stderr: a bar with the remaining time for each running step, and a line for each finished one.

use std::io::IsTerminal;
use std::time::Instant;

use diagnostics::output;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// The output of progress.
pub struct Progress {
    bars: Option<MultiProgress>,
    quiet: bool,
}

/// One running step.
pub(crate) struct Task<'a> {
    progress: &'a Progress,
    bar: Option<ProgressBar>,
    step: &'static str,
    what: String,
    begun: Instant,
}

impl Progress {
    /// Bars on a terminal, plain lines elsewhere, nothing when `quiet`.
    pub fn new(quiet: bool) -> Self {
        let bars = (!quiet && std::io::stderr().is_terminal()).then(MultiProgress::new);
        Self { bars, quiet }
    }

    /// Begins the step `step` on `what`, of `count` parts.
    pub(crate) fn begin_step(&self, step: &'static str, subject: impl Into<String>, count: usize) -> Task<'_> {
        let subject = subject.into();
        let style = ProgressStyle::with_template("{prefix:10} {msg:24} {wide_bar} {pos}/{len} {eta:>4}");
        let bar = self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new(count as u64)).with_prefix(step).with_message(subject.clone());
            style.into_iter().for_each(|style| bar.set_style(style));
            bar
        });
        Task { progress: self, bar, step, what: subject, begun: Instant::now() }
    }

    /// Prints one line.
    pub(crate) fn print_line(&self, step: &str, subject: &str, note: &str) {
        let line = format!("{step:10} {subject:24} {note}");
        match &self.bars {
            Some(bars) => drop(bars.println(line)),
            None if !self.quiet => output::note(line),
            None => {}
        }
    }
}

impl Task<'_> {
    /// Counts one part.
    pub(crate) fn count_part(&self) {
        if let Some(bar) = &self.bar {
            bar.inc(1);
        }
    }

    /// Ends the step; `note` is its result in a few words.
    pub(crate) fn end_step(self, note: &str) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let seconds = self.begun.elapsed().as_secs_f64();
        self.progress.print_line(self.step, &self.what, &format!("{note:44} made {seconds:6.1} s"));
    }
}
