//! The pool: stale records are made as soon as what they read is there, several side by side.
//!
//! A record that fails ends the run once those at work are done, or, where the run is to keep going, stops only those that need
//! it. The outcome does not depend on the order in which workers finish. A second record waits while memory is short.
//!
//! Stands on: inputs, store, desk, report. Never knows: what a stage computes.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex};

use super::desk::Laid;
use super::graph::Job;
use super::hashes::Hashes;
use super::inputs::{State, made_from, state};
use super::manifest::{MadeFrom, Manifest};
use super::report::Report;
use super::room;
use super::show;
use super::store::Store;
use super::{Runner, Tally};
use crate::fault::{Fault, Outcome};
use crate::needs::Id;

/// What is known while a run goes on.
#[derive(Default)]
struct Board {
    waiting: BTreeSet<usize>,
    running: usize,
    contents: BTreeMap<Id, String>,
    lost: BTreeSet<Id>,
    stopped: bool,
    tally: Tally,
}

/// How one record ended.
enum End {
    Made(String),
    Kept(String),
    Failed,
}

/// Makes every stale job; `forced` names those made even when fresh. `hashes` gather what was read.
pub fn run(
    runner: &Runner,
    jobs: &[Job],
    forced: &(dyn Fn(&Job) -> bool + Sync),
    hashes: &Hashes,
    report: &Report,
) -> Tally {
    let board = Mutex::new(Board { waiting: (0..jobs.len()).collect(), ..Board::default() });
    let changed = Condvar::new();
    std::thread::scope(|scope| {
        for _ in 0..runner.jobs.max(1) {
            scope.spawn(|| work(runner, jobs, forced, hashes, report, &board, &changed));
        }
    });
    board.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()).tally
}

fn work(
    runner: &Runner,
    jobs: &[Job],
    forced: &(dyn Fn(&Job) -> bool + Sync),
    hashes: &Hashes,
    report: &Report,
    board: &Mutex<Board>,
    changed: &Condvar,
) {
    let lock = || board.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    loop {
        let mut now = lock();
        skip_lost(&mut now, jobs, report);
        let Some(next) = ready(&now, jobs, runner.spare) else {
            if now.waiting.is_empty() || now.stopped || now.running == 0 {
                changed.notify_all();
                return;
            }
            drop(changed.wait(now));
            continue;
        };
        now.waiting.remove(&next);
        now.running += 1;
        let contents = now.contents.clone();
        drop(now);
        let end = make(runner, &jobs[next], &contents, forced(&jobs[next]), hashes, report);
        let mut now = lock();
        now.running -= 1;
        now.stopped |= matches!(end, End::Failed) && !runner.keep_going;
        settle(&mut now, &jobs[next].id, end);
        changed.notify_all();
    }
}

/// The next record that can be begun; none while another is at work and less than `spare` GiB are free.
fn ready(board: &Board, jobs: &[Job], spare: f64) -> Option<usize> {
    if board.stopped || board.running > 0 && !room::is_left(spare) {
        return None;
    }
    let there = |job: &Job| job.reads().iter().all(|id| board.contents.contains_key(id));
    board.waiting.iter().copied().find(|&i| there(&jobs[i]))
}

fn skip_lost(board: &mut Board, jobs: &[Job], report: &Report) {
    while let Some((i, needs)) = board.waiting.iter().find_map(|&i| {
        let lost = jobs[i].reads().iter().find(|id| board.lost.contains(*id))?;
        Some((i, lost.clone()))
    }) {
        board.waiting.remove(&i);
        board.lost.insert(jobs[i].id.clone());
        board.tally.skipped += 1;
        report.skipped(&jobs[i].id, &needs);
    }
}

fn settle(board: &mut Board, id: &Id, end: End) {
    match end {
        End::Made(content) => {
            board.tally.made += 1;
            board.contents.insert(id.clone(), content);
        }
        End::Kept(content) => {
            board.tally.kept += 1;
            board.contents.insert(id.clone(), content);
        }
        End::Failed => {
            board.tally.failed += 1;
            board.lost.insert(id.clone());
        }
    }
}

fn make(
    runner: &Runner,
    job: &Job,
    contents: &BTreeMap<Id, String>,
    forced: bool,
    hashes: &Hashes,
    report: &Report,
) -> End {
    match keep_or_make(runner, job, contents, forced, hashes, report) {
        Ok(end) => end,
        Err(fault) => {
            report.failed(&shown(runner, &job.id, fault).of(&job.id));
            End::Failed
        }
    }
}

/// A fault whose picture has been written beside the record, and which says where.
fn shown(runner: &Runner, id: &Id, mut fault: Fault) -> Fault {
    let Some(picture) = fault.shows.take() else { return fault };
    let path = runner.folders.picture(id);
    let written = path.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| std::fs::write(&path, picture));
    fault.what += &match written {
        Ok(()) => format!("\n  see: {}", runner.folders.tell(&path)),
        Err(e) => format!("\n  see: its picture could not be written: {e}"),
    };
    fault
}

fn keep_or_make(
    runner: &Runner,
    job: &Job,
    contents: &BTreeMap<Id, String>,
    forced: bool,
    hashes: &Hashes,
    report: &Report,
) -> Outcome<End> {
    let now = made_from(runner, job, contents, hashes)?;
    match state(runner, job, &now, hashes) {
        State::Kept(manifest) if !forced => {
            show::lay_out(runner, job, &manifest)?;
            report.kept(&job.id);
            return Ok(End::Kept(manifest.content));
        }
        State::Damaged(damage) => report.warn(&format!("record `{}` is made again: {damage}", job.id)),
        _ => {}
    }
    let manifest = make_record(runner, job, now, report)?;
    show::lay_out(runner, job, &manifest)?;
    report.made(&job.id, &manifest.telling, manifest.seconds);
    Ok(End::Made(manifest.content))
}

fn make_record(runner: &Runner, job: &Job, now: MadeFrom, report: &Report) -> Outcome<Manifest> {
    let store = Store::new(&runner.folders);
    let raw = job.ingredients.as_ref().map_or(&[][..], |i| &i.raw);
    let desk = Laid::new(&runner.folders, raw, report.begin(&job.id));
    let run = || (job.entry.make)(&runner.study, &job.id.subject, &runner.settings, &store, &desk);
    let made = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| Err(broke_down()))?;
    let seconds = crate::stage::Desk::seconds(&desk);
    let manifest = Manifest::of(now, &made.parcel, made.metrics, made.telling, seconds);
    store.write(&job.id, &manifest, &made.parcel)?;
    Ok(manifest)
}

fn broke_down() -> Fault {
    Fault::new(
        "the stage broke down",
        "an assertion about its own working did not hold; the lines above name the place",
        "report it with the recordings; other records are not harmed",
    )
}
