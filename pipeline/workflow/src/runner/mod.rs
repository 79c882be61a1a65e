//! The runner: determines stale records and makes them in order. It alone chooses paths, reads and writes records,
//! prints progress and reads clocks.

mod atomic;
mod context;
mod differences;
mod exhibit;
mod folders;
mod graph;
mod hashes;
mod lock;
mod make;
mod manifest;
mod memory;
mod plan;
mod pool;
mod process;
mod report;
mod schedule;
mod staleness;
mod store;
mod times;
mod tree;
mod usage;

pub use atomic::write_atomically;
pub use folders::Folders;
pub use graph::{Goal, Job};
pub use lock::{Attempt, Holder, Lock};
pub use manifest::{MadeFrom, Manifest};
pub(crate) use plan::up_to_date;
pub use plan::{Outdated, Share};
pub use process::Process;
pub use store::{Found, Store};
pub use usage::{Measured, Usage, peak_memory};

use std::collections::BTreeMap;

use diagnostics::{Diagnostic, Result, output};
use rayon::prelude::*;

use crate::entry::Entry;
use crate::metric::Metric;
use crate::settings::{Profile, Settings};
use crate::stage::{RawFile, StageContext};
use crate::stage_graph::StageGraph;
use crate::subject::Universe;
use hashes::Hashes;
use make::Task;
use memory::Budget;
use pool::Pool as Work;
use report::Report;

/// How often the lock of the files derived from all records is asked for before its holder is named: five seconds.
const PATIENCE: usize = 50;

/// Everything that a run needs: lists of entries, the subjects, the settings, the folders.
pub struct Runner<U: 'static> {
    /// Stages, figures and tables, each list in the order of the data.
    pub lists: &'static [&'static [Entry<U>]],
    /// The subjects found.
    pub universe: U,
    /// The profile's settings.
    pub settings: Settings,
    /// The profile.
    pub profile: Profile,
    /// The profile's folders.
    pub folders: Folders,
    /// How it runs.
    pub options: Options,
}

/// Options of a run.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Whether progress is left out.
    pub quiet: bool,
    /// Number of records made in parallel; without one, as many as there are cores.
    pub jobs: Option<usize>,
    /// Memory for all records in progress, GiB; without it, what is free when the run begins.
    pub memory: Option<f64>,
    /// Whether a record that fails stops only those that need it, or the run.
    pub keep_going: bool,
    /// No further record is started while less memory is free, GiB.
    pub min_free_memory: f64,
}

/// Counts of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunSummary {
    /// Records made.
    pub made: usize,
    /// Records that were up to date.
    pub kept: usize,
    /// Records that could not be made.
    pub failed: usize,
    /// Records left out because one that they read failed.
    pub skipped: usize,
}

impl<U: Universe> Runner<U> {
    /// Makes every stale record that the goal needs; with `fresh`, the goal's own records even when they are not stale. Other runs may make
    /// records of the same project at the same time.
    ///
    /// `publish` is called after the records are made: it writes the files derived from all of them, while no other run does.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown or a file cannot be written. Records that fail are counted, not returned.
    pub fn run(&self, goal: &Goal, fresh: bool, publish: &dyn Fn(&Self) -> Result<()>) -> Result<RunSummary> {
        let task = Task { jobs: self.jobs_of(goal)?, contents: BTreeMap::new() };
        let finish = |work: &Work<'_, U>| {
            let _lock = self.lock_publication(work.holder)?;
            self.folders.written_to().iter().for_each(|folder| atomic::sweep(folder));
            // First the hashes: what is published is of the records that the plan keeps, which then need not be read again.
            work.hashes.write(&self.folders.hashes()).map_err(|e| self.without_hashes(e))?;
            publish(self)
        };
        self.run_task(task, &|job| fresh && is_named(goal, job), &finish)
    }

    /// Makes exactly these records, named `stage/subject`, from what lies in the store, unless they are up to date. Nothing that is derived
    /// from all records is written.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no such record, or when one of those that it reads is missing or stale: the first is named with the
    /// reason, and with the command that makes them.
    pub fn make(&self, names: &[String]) -> Result<RunSummary> {
        let task = make::split_task(self, self.jobs_of(&Goal::default())?, names)?;
        let finish =
            |work: &Work<'_, U>| make::write_hashes(self, work.jobs, work.hashes).map_err(|e| self.without_hashes(e));
        self.run_task(task, &|_| false, &finish)
    }

    /// Makes the stale records of a task and those that are `forced`.
    fn run_task(
        &self,
        task: Task<U>,
        forced: &(dyn Fn(&Job<U>) -> bool + Sync),
        finish: &dyn Fn(&Work<'_, U>) -> Result<()>,
    ) -> Result<RunSummary> {
        let Task { jobs, contents } = task;
        let (holder, hashes) = (Holder::enter(&self.folders.lock_holders())?, Hashes::default());
        let (report, budget) = (Report::new(jobs.len(), self.options.quiet), self.memory_budget(&jobs));
        let work = Work {
            runner: self,
            jobs: &jobs,
            forced,
            hashes: &hashes,
            report: &report,
            holder: &holder,
            budget: &budget,
        };
        let summary = work.run(contents);
        finish(&work)?;
        report.end(&summary.in_words());
        Ok(summary)
    }

    /// The memory that records in progress share, by the peaks of those that were measured.
    fn memory_budget(&self, jobs: &[Job<U>]) -> Budget {
        let store = Store::new(&self.folders);
        let peak = |job: &Job<U>| Some((job.id.stage, store.measured(&job.id)?.peak_memory?));
        Budget::new(self.options.memory, self.options.min_free_memory, jobs.iter().filter_map(peak))
    }

    /// Writes the files derived from all records, while no other run does.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a file cannot be written.
    pub fn publish(&self, publish: &dyn Fn(&Self) -> Result<()>) -> Result<()> {
        let holder = Holder::enter(&self.folders.lock_holders())?;
        let _lock = self.lock_publication(&holder)?;
        publish(self)
    }

    /// Waits for the lock of the files derived from all records: they are written in seconds, and who holds it for longer is named.
    fn lock_publication<'a>(&self, holder: &'a Holder) -> Result<Lock<'a>> {
        let path = self.folders.publication_lock();
        let mut waited = 0;
        loop {
            match holder.ask(&path)? {
                Attempt::Held(lock) => return Ok(lock),
                Attempt::Busy(process) => {
                    if waited == PATIENCE {
                        let remedy = remedy(&self.folders, &path);
                        output::note(format_args!("waits: {process} writes the numbers of all records; {remedy}"));
                    }
                    waited += 1;
                    std::thread::sleep(pool::POLL);
                }
            }
        }
    }

    fn without_hashes(&self, error: std::io::Error) -> Diagnostic {
        let problem = format!("the hashes cannot be written to {}", self.folders.display(&self.folders.processed()));
        Diagnostic::new(problem, &error, "free some disk space and run again").caused_by(error)
    }

    /// What a run would do, one line a record, without doing it.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn plan(&self, goal: &Goal) -> Result<String> {
        let jobs = self.jobs_of(goal)?;
        let text = plan::plan_text(self, &jobs);
        // thirty thousand cards and settings take a tenth of a second to drop one after the other
        jobs.into_par_iter().for_each(drop);
        Ok(text)
    }

    /// The same as JSON: `record`, `stage`, `subject`, `kept`, `why` and `reads` of each record.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn plan_json(&self, goal: &Goal) -> Result<String> {
        let text = plan::plan_json(self, &self.jobs_of(goal)?);
        text.map_err(|e| Diagnostic::new("the plan cannot be written as JSON", e, "take the plan in words"))
    }

    /// How long all records of the goal would take with each of these numbers of workers, and the longest chain, from measured durations.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn schedule(&self, goal: &Goal, workers: &[usize]) -> Result<String> {
        Ok(schedule::schedule_text(self, &self.jobs_of(goal)?, workers))
    }

    /// What the records of each stage took, and how many are left to make.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn times(&self, goal: &Goal) -> Result<String> {
        Ok(times::times_text(self, &self.jobs_of(goal)?))
    }

    /// The records that a run would make, by name.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn stale(&self, goal: &Goal) -> Result<Vec<String>> {
        Ok(plan::stale_records(self, &self.jobs_of(goal)?))
    }

    /// The records in the store that a run for the goal would not keep, each with the reason.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn outdated(&self, goal: &Goal) -> Result<Vec<Outdated>> {
        Ok(plan::outdated_records(self, &self.jobs_of(goal)?))
    }

    /// Holds that these records, named `stage/subject`, and all that they read are up to date: what is made from them is of one state of
    /// cards, settings and recordings.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the first record that is missing or stale, with the reason and the command that makes it.
    pub fn require(&self, names: &[String]) -> Result<()> {
        make::require_current(self, self.jobs_of(&Goal::default())?, names)
    }

    /// The dependency tree of the stages, with how many records of each a run would keep and make.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn tree(&self, goal: &Goal) -> Result<String> {
        Ok(tree::tree_text(&self.stage_graph(), &self.shares(goal)?))
    }

    /// How many records of each stage a run would keep and make.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn shares(&self, goal: &Goal) -> Result<BTreeMap<&'static str, Share>> {
        Ok(plan::stage_shares(self, &self.jobs_of(goal)?))
    }

    /// The inputs of each record of a stage, and the differences that make it stale.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no such stage.
    pub fn why(&self, entry: &str) -> Result<String> {
        let goal = Goal { entries: vec![entry.into()], group: None };
        Ok(plan::explain_staleness(self, &self.jobs_of(&goal)?, entry))
    }

    /// What reads what.
    pub fn stage_graph(&self) -> StageGraph {
        StageGraph::of(&self.universe, self.lists.first().copied().unwrap_or_default())
    }

    /// Every record that the goal needs, in an order in which each comes after those that it reads.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the goal is unknown.
    pub fn jobs_of(&self, goal: &Goal) -> Result<Vec<Job<U>>> {
        graph::goal_jobs(self, goal)
    }

    /// The metrics of all records that are up to date, by name; of a name shared by several subjects, the largest.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the settings of a stage cannot be read.
    pub fn metrics(&self) -> Result<BTreeMap<String, Metric>> {
        let (store, jobs) = (Store::new(&self.folders), self.jobs_of(&Goal::default())?);
        let up_to_date = plan::up_to_date(self, &jobs);
        let mut metrics: BTreeMap<String, Metric> = BTreeMap::new();
        for job in jobs.iter().filter(|job| up_to_date.contains(&job.id)) {
            if let Found::Whole(manifest) = store.find(&job.id) {
                for metric in manifest.metrics {
                    let largest = metrics.entry(metric.id.clone()).or_insert_with(|| metric.clone());
                    largest.value = largest.value.max(metric.value);
                }
            }
        }
        Ok(metrics)
    }
}

impl RunSummary {
    /// Whether every record that was asked for was made or is up to date.
    pub fn is_complete(self) -> bool {
        self.failed + self.skipped == 0
    }

    fn in_words(self) -> String {
        let mut words = format!("{} made, {} kept", self.made, self.kept);
        if !self.is_complete() {
            words += &format!(", {} failed, {} not made because of that", self.failed, self.skipped);
        }
        words
    }
}

/// What to do about a lock whose holder does not run any more, which cannot be seen from another machine.
fn remedy(folders: &Folders, lock: &std::path::Path) -> String {
    format!("if that runs no more, remove {}", folders.display(lock))
}

fn is_named<U>(goal: &Goal, job: &Job<U>) -> bool {
    goal.entries.is_empty() || goal.entries.iter().any(|name| name == job.id.stage)
}

/// A context for an inspection of raw files from which no record is made: without a progress line.
pub fn inspection_context<'a>(folders: &'a Folders, raw: &'a [RawFile]) -> impl StageContext + 'a {
    context::RunContext::new(folders, raw, report::Line::hidden())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::needs::RecordId;
    use crate::testing::{CHAIN, Whole, runner};
    use std::path::PathBuf;

    /// A runner of [`CHAIN`] in a folder of its own that holds its recording.
    fn chain(name: &str) -> (Runner<Whole>, PathBuf) {
        let root = std::env::temp_dir().join(format!("chain-{name}-{}", std::process::id()));
        let runner = Runner { lists: &[CHAIN], ..runner(&root) };
        std::fs::create_dir_all(runner.folders.raw_file("a")).unwrap();
        std::fs::write(runner.folders.raw_file("a/lit.csv"), "1").unwrap();
        (runner, root)
    }

    fn run(runner: &Runner<Whole>, entry: Option<&str>) -> [usize; 4] {
        let goal = Goal { entries: entry.into_iter().map(str::to_owned).collect(), group: None };
        let RunSummary { made, kept, failed, skipped } = runner.run(&goal, entry.is_some(), &|_| Ok(())).unwrap();
        [made, kept, failed, skipped]
    }

    #[test]
    fn why_says_what_a_record_was_made_from() {
        let (runner, root) = chain("why");
        let explain = |entry| runner.why(entry).unwrap();
        let never = explain("second");
        assert!(never.starts_with("second ") && never.ends_with("\n  it was never made"), "{never}");
        assert_eq!(run(&runner, None), [2, 0, 0, 0]);
        let (first, second) = (explain("first"), explain("second"));
        let lines: Vec<&str> = second.lines().collect();
        assert!(lines[0].starts_with("second ") && lines[0].ends_with(" kept"), "{second}");
        assert!(lines[1].starts_with("  version 1, made in ") && lines[1].contains(" s, content "), "{second}");
        assert!(lines[2].starts_with("  record    first/a  "), "{second}");
        assert_eq!(lines[3..], ["  settings  {\"step\":2}", "  card      null"]);
        // a hash is cut to twelve letters
        let recording = first.lines().find_map(|line| line.strip_prefix("  recording a/lit.csv  ")).unwrap();
        assert_eq!((recording.len(), first.lines().count()), (12, 5), "{first}");
        std::fs::write(runner.folders.raw_file("a/lit.csv"), "2").unwrap();
        assert!(
            explain("first").starts_with("first ") && explain("first").contains("of other content"),
            "{}",
            explain("first")
        );
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn fresh_makes_the_named_record_again_and_none_that_it_reads() {
        let (runner, root) = chain("fresh");
        run(&runner, None);
        let modified = || {
            let record = |stage, subject: &str| runner.folders.record(&RecordId { stage, subject: subject.into() });
            let manifest = |stage, subject| record(stage, subject).join(manifest::FILE);
            [manifest("first", "a"), manifest("second", "all")]
                .map(|path| std::fs::metadata(path).unwrap().modified().unwrap())
        };
        let former = modified();
        assert_eq!(run(&runner, Some("second")), [1, 1, 0, 0]);
        let later = modified();
        assert!(later[0] == former[0] && later[1] > former[1], "{former:?} {later:?}");
        std::fs::remove_dir_all(&root).unwrap();
    }
}
