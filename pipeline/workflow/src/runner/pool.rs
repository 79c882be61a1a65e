//! The worker pool: stale records are made in parallel, each as soon as its inputs exist.
//!
//! A record that fails ends the run once those in progress are done, or, with `keep_going`, stops only those that need it. The
//! products do not depend on the order in which workers finish. A second record waits while memory is short.
//!
//! A record is made under its lock, and whether it is stale is decided under the lock. One that another process is making is left to that
//! process: others are begun first, and once it is done it is found up to date.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use diagnostics::{Diagnostic, Result};

use super::context::RunContext;
use super::exhibit;
use super::graph::Job;
use super::hashes::Hashes;
use super::lock::{Attempt, Holder, Lock};
use super::manifest::{MadeFrom, Manifest};
use super::memory::Budget;
use super::process::Process;
use super::report::Report;
use super::staleness::{State, made_from, record_state};
use super::store::{KeyedReader, Store};
use super::usage::Meter;
use super::{RunSummary, Runner, remedy};
use crate::needs::RecordId;
use crate::stage::StageContext;
use crate::subject::Universe;

/// How often a record that another process is making is looked at.
pub(crate) const POLL: Duration = Duration::from_millis(100);

/// What all workers share.
pub(crate) struct Pool<'a, U: 'static> {
    /// Lists, settings, folders and options.
    pub runner: &'a Runner<U>,
    /// The records, each after those that it reads.
    pub jobs: &'a [Job<U>],
    /// Which records are made even when they are up to date.
    pub forced: &'a (dyn Fn(&Job<U>) -> bool + Sync),
    /// The hashes of the files read.
    pub hashes: &'a Hashes,
    /// Where progress goes.
    pub report: &'a Report,
    /// Takes the locks of the records.
    pub holder: &'a Holder,
    /// The memory that records in progress share.
    pub budget: &'a Budget,
}

/// The state of a run in progress.
#[derive(Default)]
struct Progress {
    waiting: BTreeSet<usize>,
    /// Of those that wait, the ones that other processes were making, and when they are looked at again.
    elsewhere: BTreeMap<usize, Instant>,
    reported: BTreeSet<usize>,
    running: usize,
    /// What those in progress are expected to need, GiB.
    memory: f64,
    contents: BTreeMap<RecordId, String>,
    failed: BTreeSet<RecordId>,
    stopped: bool,
    summary: RunSummary,
}

/// The result of one record, with its content hash.
enum End {
    Made(String),
    Kept(String),
    Failed,
    Elsewhere(Process),
}

/// One state under a lock, and the condition that it changed.
struct Shared {
    progress: Mutex<Progress>,
    changed: Condvar,
}

impl Shared {
    /// A worker that panicked while it held the lock leaves counters that are still true: they are set in single steps.
    fn lock_progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<U: Universe> Pool<'_, U> {
    /// Makes every stale job; `contents` are those of records that the jobs read and that are none of them.
    pub fn run(&self, contents: BTreeMap<RecordId, String>) -> RunSummary {
        let waiting = (0..self.jobs.len()).collect();
        let progress = Mutex::new(Progress { waiting, contents, ..Progress::default() });
        let shared = Shared { progress, changed: Condvar::new() };
        // Scoped threads of their own, not rayon's: a worker blocks while it waits, and a blocked rayon thread would keep the stages'
        // own parallel loops from running.
        std::thread::scope(|scope| {
            for _ in 0..self.worker_count() {
                scope.spawn(|| self.run_jobs(&shared));
            }
        });
        let mut summary = shared.lock_progress().summary;
        summary.skipped = self.jobs.len() - summary.made - summary.kept - summary.failed;
        summary
    }

    /// One a core, unless another number is asked for. Their parallel loops share one pool of as many threads.
    fn worker_count(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.runner.options.jobs.unwrap_or_else(cores).clamp(1, self.jobs.len().max(1))
    }

    fn run_jobs(&self, shared: &Shared) {
        while let Some((next, contents)) = self.take_job(shared) {
            let job = &self.jobs[next];
            // A record is settled whatever happened to it: the other workers wait for that.
            let end = catch_unwind(AssertUnwindSafe(|| self.run_job(job, &contents))).unwrap_or(End::Failed);
            if let End::Elsewhere(process) = end {
                self.leave_job(shared, next, &process);
                continue;
            }
            let skipped = self.settle_job(shared, job, end);
            // Printing may block for as long as the reader likes, and so is done without the lock.
            skipped.iter().for_each(|(id, needs)| self.report.skipped(id, needs));
        }
    }

    /// Waits for a record that can be begun; returns it with the contents of those that exist, or none when nothing is left to do.
    fn take_job(&self, shared: &Shared) -> Option<(usize, BTreeMap<RecordId, String>)> {
        let mut progress = shared.lock_progress();
        loop {
            if let Some(next) = self.next_ready(&progress) {
                progress.waiting.remove(&next);
                progress.elsewhere.remove(&next);
                progress.running += 1;
                progress.memory += self.budget.expected(self.jobs[next].id.stage);
                // The contents are copied so that the lock is free while the record is made.
                return Some((next, progress.contents.clone()));
            }
            // Nothing can become ready once no record is in progress: what is left waits for one that was never made.
            let none_in_progress = progress.running == 0 && progress.elsewhere.is_empty();
            if progress.waiting.is_empty() || progress.stopped || none_in_progress {
                shared.changed.notify_all();
                return None;
            }
            progress = shared.changed.wait_timeout(progress, POLL).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Leaves a record to the process that is making it.
    fn leave_job(&self, shared: &Shared, job: usize, process: &Process) {
        let mut progress = shared.lock_progress();
        self.release_job(&mut progress, &self.jobs[job]);
        progress.waiting.insert(job);
        progress.elsewhere.insert(job, Instant::now() + POLL);
        let first = progress.reported.insert(job);
        shared.changed.notify_all();
        drop(progress);
        if first {
            let id = &self.jobs[job].id;
            let remedy = remedy(&self.runner.folders, &self.runner.folders.record_lock(id));
            self.report.elsewhere(id, process, &remedy);
        }
    }

    /// Enters the result of a record; returns the records that cannot be made because of it, each with one that it reads.
    fn settle_job(&self, shared: &Shared, job: &Job<U>, end: End) -> Vec<(RecordId, RecordId)> {
        let mut progress = shared.lock_progress();
        self.release_job(&mut progress, job);
        progress.stopped |= matches!(end, End::Failed) && !self.runner.options.keep_going;
        progress.enter_result(&job.id, end);
        let skipped = self.skip_dependents(&mut progress);
        shared.changed.notify_all();
        skipped
    }

    fn release_job(&self, progress: &mut Progress, job: &Job<U>) {
        progress.running -= 1;
        progress.memory -= self.budget.expected(job.id.stage);
    }

    /// The next record that can be begun; none while another is in progress and memory is short.
    fn next_ready(&self, progress: &Progress) -> Option<usize> {
        if progress.stopped {
            return None;
        }
        let available = |job: &Job<U>| job.reads().iter().all(|id| progress.contents.contains_key(id));
        let due = |i: &usize| progress.elsewhere.get(i).is_none_or(|due| *due <= Instant::now());
        let next = progress.waiting.iter().copied().filter(due).find(|&i| available(&self.jobs[i]))?;
        // The first record always begins: with nothing in progress no memory will be freed by waiting.
        let room = progress.running == 0 || self.budget.has_room(self.jobs[next].id.stage, progress.memory);
        room.then_some(next)
    }

    fn skip_dependents(&self, progress: &mut Progress) -> Vec<(RecordId, RecordId)> {
        let mut skipped = Vec::new();
        while let Some((i, needs)) = progress.waiting.iter().find_map(|&i| {
            let failed = self.jobs[i].reads().iter().find(|id| progress.failed.contains(*id))?;
            Some((i, failed.clone()))
        }) {
            progress.waiting.remove(&i);
            progress.failed.insert(self.jobs[i].id.clone());
            progress.summary.skipped += 1;
            skipped.push((self.jobs[i].id.clone(), needs));
        }
        skipped
    }

    fn run_job(&self, job: &Job<U>, contents: &BTreeMap<RecordId, String>) -> End {
        // A stage that panics fails alone: its record is whole or absent, so nothing else can have been harmed.
        let make = || self.keep_or_make(job, contents);
        let ended = catch_unwind(AssertUnwindSafe(make)).unwrap_or_else(|panic| Err(panic_diagnostic(&*panic)));
        ended.unwrap_or_else(|diagnostic| {
            self.report.failed(&self.with_picture(&job.id, diagnostic).of(&job.id));
            End::Failed
        })
    }

    /// A diagnostic whose picture has been written beside the record, with the picture's path.
    fn with_picture(&self, id: &RecordId, mut diagnostic: Diagnostic) -> Diagnostic {
        let Some(picture) = diagnostic.picture.take() else { return diagnostic };
        let path = self.runner.folders.picture(id);
        let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let location = match folder.and_then(|()| std::fs::write(&path, picture)) {
            Ok(()) => self.runner.folders.display(&path),
            Err(e) => format!("its picture could not be written: {e}"),
        };
        diagnostic.notes.push(format!("see: {location}"));
        diagnostic
    }

    fn keep_or_make(&self, job: &Job<U>, contents: &BTreeMap<RecordId, String>) -> Result<End> {
        let path = self.runner.folders.record_lock(&job.id);
        // Looked at before anything is read: hashing a film only to find that another process works on it would be repeated.
        if path.exists()
            && let Attempt::Busy(process) = self.holder.ask(&path)?
        {
            return Ok(End::Elsewhere(process));
        }
        let now = made_from(self.runner, job, contents, self.hashes)?;
        if let Some(end) = self.keep_current(job, record_state(self.runner, job, &now, self.hashes))? {
            return Ok(end);
        }
        match self.holder.ask(&path)? {
            Attempt::Held(lock) => self.keep_or_make_under(&lock, (job, now), contents),
            Attempt::Busy(process) => Ok(End::Elsewhere(process)),
        }
    }

    fn keep_current(&self, job: &Job<U>, state: State) -> Result<Option<End>> {
        match state {
            State::Kept(manifest) if !(self.forced)(job) => {
                exhibit::copy_exhibit(self.runner, job, &manifest)?;
                self.report.kept(&job.id);
                Ok(Some(End::Kept(manifest.content)))
            }
            _ => Ok(None),
        }
    }

    fn keep_or_make_under(
        &self,
        lock: &Lock<'_>,
        (job, now): (&Job<U>, MadeFrom),
        contents: &BTreeMap<RecordId, String>,
    ) -> Result<End> {
        lock.sweep();
        // Another process may have made it since it was found stale.
        let current = record_state(self.runner, job, &now, self.hashes);
        if let State::Damaged(damage) = &current {
            self.report.warn(&format!("record `{}` is made again: {damage}", job.id));
        }
        if let Some(end) = self.keep_current(job, current)? {
            return Ok(end);
        }
        let manifest = self.make_record(lock, (job, now), contents)?;
        exhibit::copy_exhibit(self.runner, job, &manifest)?;
        self.report.made(&job.id, &manifest.summary, manifest.seconds);
        Ok(End::Made(manifest.content))
    }

    fn make_record(
        &self,
        lock: &Lock<'_>,
        (job, now): (&Job<U>, MadeFrom),
        contents: &BTreeMap<RecordId, String>,
    ) -> Result<Manifest> {
        let runner = self.runner;
        let store = Store::new(&runner.folders);
        let reader = KeyedReader { store: &store, contents };
        let raw = job.inputs.as_ref().map_or(&[][..], |i| &i.raw);
        let context = RunContext::new(&runner.folders, raw, self.report.begin(&job.id));
        let meter = Meter::begin(self.worker_count() == 1);
        let product = (job.entry.make)(&runner.universe, &job.id.subject, &runner.settings, &reader, &context)?;
        let (manifest, files) = Manifest::of(now, product, context.seconds(), meter.end());
        store.write(&job.id, (&manifest, &files), lock)?;
        Ok(manifest)
    }
}

impl Progress {
    fn enter_result(&mut self, id: &RecordId, end: End) {
        match end {
            End::Made(content) => {
                self.summary.made += 1;
                self.contents.insert(id.clone(), content);
            }
            End::Kept(content) => {
                self.summary.kept += 1;
                self.contents.insert(id.clone(), content);
            }
            End::Failed => {
                self.summary.failed += 1;
                self.failed.insert(id.clone());
            }
            End::Elsewhere(_) => {}
        }
    }
}

fn panic_diagnostic(panic: &(dyn Any + Send)) -> Diagnostic {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    let reason = format!("an assertion about its own computation did not hold: {}", text.unwrap_or("no message"));
    Diagnostic::new("the stage panicked", reason, "report it with the recordings; other records are not affected")
}
