//! The runner: decides what is stale, makes it in order, keeps what was made. It alone chooses paths, reads and writes
//! records, prints and keeps time.
//!
//! Stands on: the entries of stages, figures and tables. Never knows: what any of them computes.

mod crate_file;
mod desk;
mod folders;
mod graph;
mod hashes;
mod inputs;
mod lock;
mod manifest;
mod metrics_file;
mod page_file;
mod paper_files;
mod plan;
mod pool;
mod report;
mod room;
mod show;
mod store;
mod tree;
mod verdict;

pub use folders::Folders;
pub use graph::Goal;
pub use metrics_file::{Entry as MetricEntry, read as read_metrics};
pub use paper_files::{resolve as resolve_paper, unresolved as unresolved_paper, write as write_paper};

use std::path::PathBuf;

use crate::entry::Entry;
use crate::fault::{Fault, Outcome};
use crate::settings::{Profile, Settings};
use crate::stage::{Desk, RawFile};
use crate::subject::Study;
use graph::Job;
use hashes::Hashes;
use lock::Lock;
use report::Report;

/// Everything that the runner runs: lists of entries, the subjects, the settings, the folders.
pub struct Runner {
    /// Stages, figures and tables, each list in the order of the data.
    pub lists: &'static [&'static [Entry]],
    /// The specimens found.
    pub study: Study,
    /// The profile's settings.
    pub settings: Settings,
    /// The profile.
    pub profile: Profile,
    /// The profile's folders.
    pub folders: Folders,
    /// Whether progress is left out.
    pub quiet: bool,
    /// Records made side by side.
    pub jobs: usize,
    /// Whether a record that fails stops only those that need it, or the run.
    pub keep_going: bool,
    /// No second record is begun while less memory is free, GiB.
    pub spare: f64,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Records made.
    pub made: usize,
    /// Records that were as they should be.
    pub kept: usize,
    /// Records that could not be made.
    pub failed: usize,
    /// Records left out because one that they read failed.
    pub skipped: usize,
}

impl Runner {
    /// Makes every stale record that the goal needs; with `fresh`, the goal's own records even when they are not stale.
    ///
    /// # Errors
    /// A [`Fault`] when the goal is unknown or another run is at work. Records that fail are counted, not returned.
    pub fn run(&self, goal: &Goal, fresh: bool) -> Outcome<Tally> {
        let jobs = self.jobs_of(goal)?;
        let _lock = Lock::take(&self.folders)?;
        let report = Report::new(jobs.len(), self.quiet);
        let hashes = Hashes::default();
        let mut tally = pool::run(self, &jobs, &|job: &Job| fresh && is_named(goal, job), &hashes, &report);
        tally.skipped = jobs.len() - tally.made - tally.kept - tally.failed;
        self.write_metrics(&hashes, &report)?;
        report.end(&tally.in_words());
        Ok(tally)
    }

    /// What a run would do, one line a record, without doing it.
    ///
    /// # Errors
    /// A [`Fault`] when the goal is unknown.
    pub fn plan(&self, goal: &Goal) -> Outcome<String> {
        Ok(plan::text(self, &self.jobs_of(goal)?))
    }

    /// The stages as a tree of what reads what, with how many records of each a run would keep and make.
    ///
    /// # Errors
    /// A [`Fault`] when the goal is unknown.
    pub fn tree(&self, goal: &Goal) -> Outcome<String> {
        Ok(tree::text(self, &self.jobs_of(goal)?))
    }

    /// The same as a drawing, SVG.
    ///
    /// # Errors
    /// A [`Fault`] when the goal is unknown or the graph cannot be drawn.
    pub fn drawing(&self, goal: &Goal) -> Outcome<String> {
        tree::svg(self, &self.jobs_of(goal)?)
    }

    /// From what each record of a stage was made, and what would make it stale now.
    ///
    /// # Errors
    /// A [`Fault`] when there is no such stage.
    pub fn why(&self, entry: &str) -> Outcome<String> {
        let goal = Goal { entries: vec![entry.into()], specimen: None };
        Ok(plan::why(self, &self.jobs_of(&goal)?, entry))
    }

    /// Writes the page that shows everything; says where it lies.
    ///
    /// # Errors
    /// A [`Fault`] when it cannot be written or a record is damaged.
    pub fn page(&self) -> Outcome<PathBuf> {
        page_file::write(self)
    }

    fn jobs_of(&self, goal: &Goal) -> Outcome<Vec<Job>> {
        graph::jobs(self.lists, &self.study, &self.settings, goal)
    }

    fn write_metrics(&self, hashes: &Hashes, report: &Report) -> Outcome<()> {
        let all = self.jobs_of(&Goal::default())?;
        let place = self.folders.processed();
        metrics_file::write(self, &all, report)
            .and_then(|()| crate_file::write(self, &all))
            .and_then(|()| hashes.write(&self.folders.hashes()))
            .map_err(|e| {
                let what = format!("the numbers cannot be written to {}", self.folders.tell(&place));
                Fault::new(what, e, "free some disk space and run again")
            })
    }
}

impl Tally {
    fn in_words(self) -> String {
        let mut words = format!("{} made, {} kept", self.made, self.kept);
        if self.failed + self.skipped > 0 {
            words += &format!(", {} failed, {} not made because of that", self.failed, self.skipped);
        }
        words
    }
}

fn is_named(goal: &Goal, job: &Job) -> bool {
    goal.entries.is_empty() || goal.entries.iter().any(|name| name == job.id.stage)
}

/// A desk for a look at recordings from which no record is made: without a progress line.
pub fn desk<'a>(folders: &'a Folders, raw: &'a [RawFile]) -> impl Desk + 'a {
    desk::Laid::new(folders, raw, report::Line::hidden())
}
