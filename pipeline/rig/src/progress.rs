//! Progress on stderr: a bar with an estimate for each running part, and a line for each finished one.
//!
//! Stands on: `indicatif`. Never knows: what the parts do.

use std::io::IsTerminal;
use std::time::Instant;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Where progress goes.
pub struct Progress {
    bars: Option<MultiProgress>,
    quiet: bool,
}

/// One running part.
pub struct Task<'a> {
    progress: &'a Progress,
    bar: Option<ProgressBar>,
    room: &'static str,
    what: String,
    begun: Instant,
}

impl Progress {
    /// Bars on a terminal, plain lines elsewhere, nothing when `quiet`.
    pub fn new(quiet: bool) -> Self {
        let bars = (!quiet && std::io::stderr().is_terminal()).then(MultiProgress::new);
        Self { bars, quiet }
    }

    /// Begins a part of `steps` steps, `room` doing `what`.
    pub fn begin(&self, room: &'static str, what: impl Into<String>, steps: usize) -> Task<'_> {
        let what = what.into();
        let style = ProgressStyle::with_template("{prefix:10} {msg:24} {wide_bar} {pos}/{len} {eta:>4}");
        let bar = self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new(steps as u64)).with_prefix(room).with_message(what.clone());
            style.into_iter().for_each(|style| bar.set_style(style));
            bar
        });
        Task { progress: self, bar, room, what, begun: Instant::now() }
    }

    /// A line of its own.
    pub fn say(&self, room: &str, what: &str, note: &str) {
        let line = format!("{room:10} {what:24} {note}");
        match &self.bars {
            Some(bars) => drop(bars.println(line)),
            None if !self.quiet => eprintln!("{line}"),
            None => {}
        }
    }
}

impl Task<'_> {
    /// One step done.
    pub fn tick(&self) {
        if let Some(bar) = &self.bar {
            bar.inc(1);
        }
    }

    /// Finished, with its one telling number.
    pub fn done(self, note: &str) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let seconds = self.begun.elapsed().as_secs_f64();
        self.progress.say(self.room, &self.what, &format!("{note:44} made {seconds:6.1} s"));
    }
}
