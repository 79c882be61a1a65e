//! The worker pool: stale records are made in parallel, each as soon as its inputs exist.
//!
//! A record that fails ends the run once those in progress are done, or, with `keep_going`, stops only those that need it. The
//! products do not depend on the order in which workers finish. A second record waits while memory is short.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use diagnostics::{Diagnostic, Result};

use super::context::RunContext;
use super::exhibit;
use super::graph::Job;
use super::hashes::Hashes;
use super::manifest::{MadeFrom, Manifest};
use super::memory;
use super::report::Report;
use super::staleness::{State, made_from, state};
use super::store::Store;
use super::{RunSummary, Runner};
use crate::needs::RecordId;
use crate::stage::StageContext;
use crate::subject::Universe;

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
}

/// The state of a run in progress.
#[derive(Default)]
struct Progress {
    waiting: BTreeSet<usize>,
    running: usize,
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
}

/// One state under a lock, and the condition that it changed.
struct Shared {
    progress: Mutex<Progress>,
    changed: Condvar,
}

impl Shared {
    /// A worker that panicked while it held the lock leaves counters that are still true: they are set in single steps.
    fn lock(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<U: Universe> Pool<'_, U> {
    /// Makes every stale job.
    pub fn run(&self) -> RunSummary {
        let progress = Mutex::new(Progress { waiting: (0..self.jobs.len()).collect(), ..Progress::default() });
        let shared = Shared { progress, changed: Condvar::new() };
        // Scoped threads of their own, not rayon's: a worker blocks while it waits, and a blocked rayon thread would keep the stages'
        // own parallel loops from running.
        std::thread::scope(|scope| {
            for _ in 0..self.runner.options.jobs.clamp(1, self.jobs.len().max(1)) {
                scope.spawn(|| self.work(&shared));
            }
        });
        shared.lock().summary
    }

    fn work(&self, shared: &Shared) {
        while let Some((next, contents)) = self.take(shared) {
            let job = &self.jobs[next];
            // A record is settled whatever happened to it: the other workers wait for that.
            let end = catch_unwind(AssertUnwindSafe(|| self.make(job, &contents))).unwrap_or(End::Failed);
            let skipped = self.settle(shared, job, end);
            // Printing may block for as long as the reader likes, and so is done without the lock.
            skipped.iter().for_each(|(id, needs)| self.report.skipped(id, needs));
        }
    }

    /// Waits for a record that can be begun; returns it with the contents of those that exist, or none when nothing is left to do.
    fn take(&self, shared: &Shared) -> Option<(usize, BTreeMap<RecordId, String>)> {
        let mut progress = shared.lock();
        loop {
            if let Some(next) = self.ready(&progress) {
                progress.waiting.remove(&next);
                progress.running += 1;
                // The contents are copied so that the lock is free while the record is made.
                return Some((next, progress.contents.clone()));
            }
            // Nothing can become ready once no record is in progress: what is left waits for one that was never made.
            if progress.waiting.is_empty() || progress.stopped || progress.running == 0 {
                shared.changed.notify_all();
                return None;
            }
            progress = shared.changed.wait(progress).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Enters the result of a record; returns the records that cannot be made because of it, each with one that it reads.
    fn settle(&self, shared: &Shared, job: &Job<U>, end: End) -> Vec<(RecordId, RecordId)> {
        let mut progress = shared.lock();
        progress.running -= 1;
        progress.stopped |= matches!(end, End::Failed) && !self.runner.options.keep_going;
        progress.settle(&job.id, end);
        let skipped = self.skip_dependents(&mut progress);
        shared.changed.notify_all();
        skipped
    }

    /// The next record that can be begun; none while another is in progress and memory is short.
    fn ready(&self, progress: &Progress) -> Option<usize> {
        // The first record always begins: with nothing in progress no memory will be freed by waiting.
        let short = || progress.running > 0 && !memory::is_free(self.runner.options.min_free_memory);
        if progress.stopped || short() {
            return None;
        }
        let available = |job: &Job<U>| job.reads().iter().all(|id| progress.contents.contains_key(id));
        progress.waiting.iter().copied().find(|&i| available(&self.jobs[i]))
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

    fn make(&self, job: &Job<U>, contents: &BTreeMap<RecordId, String>) -> End {
        // A stage that panics fails alone: its record is whole or absent, so nothing else can have been harmed.
        let make = || self.keep_or_make(job, contents);
        let ended = catch_unwind(AssertUnwindSafe(make)).unwrap_or_else(|panic| Err(panicked(&*panic)));
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
        let seen = match folder.and_then(|()| std::fs::write(&path, picture)) {
            Ok(()) => self.runner.folders.display(&path),
            Err(e) => format!("its picture could not be written: {e}"),
        };
        diagnostic.notes.push(format!("see: {seen}"));
        diagnostic
    }

    fn keep_or_make(&self, job: &Job<U>, contents: &BTreeMap<RecordId, String>) -> Result<End> {
        let now = made_from(self.runner, job, contents, self.hashes)?;
        match state(self.runner, job, &now, self.hashes) {
            State::Kept(manifest) if !(self.forced)(job) => {
                exhibit::write(self.runner, job, &manifest)?;
                self.report.kept(&job.id);
                return Ok(End::Kept(manifest.content));
            }
            State::Damaged(damage) => self.report.warn(&format!("record `{}` is made again: {damage}", job.id)),
            _ => {}
        }
        let manifest = self.make_record(job, now)?;
        exhibit::write(self.runner, job, &manifest)?;
        self.report.made(&job.id, &manifest.summary, manifest.seconds);
        Ok(End::Made(manifest.content))
    }

    fn make_record(&self, job: &Job<U>, now: MadeFrom) -> Result<Manifest> {
        let runner = self.runner;
        let store = Store::new(&runner.folders);
        let raw = job.inputs.as_ref().map_or(&[][..], |i| &i.raw);
        let context = RunContext::new(&runner.folders, raw, self.report.begin(&job.id));
        let product = (job.entry.make)(&runner.universe, &job.id.subject, &runner.settings, &store, &context)?;
        let manifest = Manifest::of(now, product, context.seconds());
        store.write(&job.id, &manifest.0, &manifest.1)?;
        Ok(manifest.0)
    }
}

impl Progress {
    fn settle(&mut self, id: &RecordId, end: End) {
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
        }
    }
}

fn panicked(panic: &(dyn Any + Send)) -> Diagnostic {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    let why = format!("an assertion about its own computation did not hold: {}", text.unwrap_or("no message"));
    Diagnostic::new("the stage panicked", why, "report it with the recordings; other records are not affected")
}
