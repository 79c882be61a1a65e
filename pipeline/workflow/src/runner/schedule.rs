//! A schedule: how long all records would take with more workers, from the durations that were measured when they were made.
//!
//! List scheduling by the longest way to an end [graham1969]: whenever a worker is free it takes, of the records whose inputs exist, the one
//! after which the longest chain remains. A record keeps the duration that it had; no schedule is shorter than the longest chain.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};
use std::fmt::Write;

use super::Runner;
use super::graph::Job;
use super::store::Store;
use crate::needs::RecordId;
use crate::subject::Universe;

/// Records as a graph: durations, and the later records that read each.
struct Tasks {
    /// s.
    seconds: Vec<f64>,
    readers: Vec<Vec<usize>>,
    /// Number of records that each reads.
    reads: Vec<usize>,
}

/// One line a number of workers, then the longest chain of records.
pub(super) fn schedule_text<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], workers: &[usize]) -> String {
    let store = Store::new(&runner.folders);
    let measured: Vec<Option<f64>> =
        jobs.iter().map(|job| store.measured(&job.id).map(|measured| measured.seconds)).collect();
    let tasks = Tasks::of(jobs, measured.iter().map(|seconds| seconds.unwrap_or(0.0)).collect());
    let mut text = String::new();
    let sequential = tasks.makespan(1);
    for &count in workers {
        let lasts = tasks.makespan(count);
        writeln!(
            text,
            "{count:>4} workers: {lasts:9.1} s, {:5.1} times as fast as one",
            sequential / lasts.max(f64::MIN_POSITIVE)
        )
        .expect("a string takes any text");
    }
    let chain = tasks.longest_chain();
    let named = |&k: &usize| format!("{} {:.1} s", jobs[k].id, tasks.seconds[k]);
    let lasts: f64 = chain.iter().map(|&k| tasks.seconds[k]).sum();
    let ways: Vec<String> = chain.iter().map(named).collect();
    write!(text, "critical path, {lasts:.1} s: {}", ways.join(" → ")).expect("a string takes any text");
    match measured.iter().filter(|seconds| seconds.is_none()).count() {
        0 => text,
        unknown => format!("{text}\n{unknown} of {} records have never been made and count as 0 s", jobs.len()),
    }
}

impl Tasks {
    fn of<U>(jobs: &[Job<U>], seconds: Vec<f64>) -> Self {
        let places: BTreeMap<&RecordId, usize> = jobs.iter().enumerate().map(|(k, job)| (&job.id, k)).collect();
        let (mut readers, mut reads) = (vec![Vec::new(); jobs.len()], vec![0; jobs.len()]);
        for (k, job) in jobs.iter().enumerate() {
            for input in job.reads().iter().filter_map(|id| places.get(id)) {
                readers[*input].push(k);
                reads[k] += 1;
            }
        }
        Self { seconds, readers, reads }
    }

    /// From the beginning of each record to the end of the longest chain that begins with it, s. Records come after those that they read.
    fn remaining_seconds(&self) -> Vec<f64> {
        let mut remaining = self.seconds.clone();
        for k in (0..remaining.len()).rev() {
            remaining[k] += self.readers[k].iter().map(|&next| remaining[next]).fold(0.0, f64::max);
        }
        remaining
    }

    fn longest_chain(&self) -> Vec<usize> {
        let remaining = self.remaining_seconds();
        let longest =
            |records: &mut dyn Iterator<Item = usize>| records.max_by(|&a, &b| remaining[a].total_cmp(&remaining[b]));
        let mut chain: Vec<usize> = longest(&mut (0..remaining.len())).into_iter().collect();
        while let Some(next) = chain.last().and_then(|&last| longest(&mut self.readers[last].iter().copied())) {
            chain.push(next);
        }
        chain
    }

    /// When the last record ends, s.
    fn makespan(&self, workers: usize) -> f64 {
        let remaining = self.remaining_seconds();
        let mut missing = self.reads.clone();
        let free = |k: usize| Waiting { rank: remaining[k], record: k };
        let mut ready: BinaryHeap<Waiting> = (0..missing.len()).filter(|&k| missing[k] == 0).map(free).collect();
        let mut running: BinaryHeap<Waiting> = BinaryHeap::new();
        let mut now = 0.0;
        loop {
            while running.len() < workers.max(1) {
                let Some(next) = ready.pop() else { break };
                // the heap gives the greatest: the earliest end is the greatest of the negative ones
                running.push(Waiting { rank: -(now + self.seconds[next.record]), record: next.record });
            }
            let Some(ended) = running.pop() else { return now };
            now = -ended.rank;
            for &reader in &self.readers[ended.record] {
                missing[reader] -= 1;
                if missing[reader] == 0 {
                    ready.push(free(reader));
                }
            }
        }
    }
}

/// A record in a heap, the greatest rank first; of equal ranks, the first record.
struct Waiting {
    rank: f64,
    record: usize,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank.total_cmp(&other.rank).then(other.record.cmp(&self.record))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::job;

    /// A chain 0 → 1 of 3 s and 2 s, and three records of 2 s that stand alone.
    fn tasks() -> Tasks {
        let readers = vec![vec![1], vec![], vec![], vec![], vec![]];
        Tasks { seconds: vec![3.0, 2.0, 2.0, 2.0, 2.0], readers, reads: vec![0, 1, 0, 0, 0] }
    }

    #[test]
    fn one_worker_takes_the_sum_and_many_take_the_longest_chain() {
        assert_eq!([1, 2, 3, 100].map(|workers| tasks().makespan(workers)), [11.0, 6.0, 5.0, 5.0]);
    }

    #[test]
    fn the_longest_chain_is_named_in_its_order() {
        assert_eq!(tasks().longest_chain(), [0, 1]);
        assert_eq!(tasks().remaining_seconds(), [5.0, 2.0, 2.0, 2.0, 2.0]);
    }

    /// Records of 3 s and 1 s, and one of 2 s that reads both of them and one that lies elsewhere.
    #[test]
    fn a_record_waits_for_those_that_it_reads_in_the_same_run() {
        let jobs = [job("a", &[], &[]), job("b", &[], &[]), job("all", &[], &["a", "b", "elsewhere"])];
        let tasks = Tasks::of(&jobs, vec![3.0, 1.0, 2.0]);
        assert_eq!((&tasks.reads[..], &tasks.readers[..]), (&[0, 0, 2][..], &[vec![2], vec![2], vec![]][..]));
        assert_eq!([1, 2].map(|workers| tasks.makespan(workers)), [6.0, 5.0]);
    }

    #[test]
    fn records_that_were_never_made_count_as_nothing_and_are_counted() {
        let root = std::env::temp_dir().join(format!("schedule-{}", std::process::id()));
        let schedule =
            schedule_text(&crate::testing::runner(&root), &[job("a", &[], &[]), job("all", &[], &["a"])], &[1, 16]);
        let lines: Vec<&str> = schedule.lines().map(str::trim_start).collect();
        assert!(lines[0].starts_with("1 workers:") && lines[1].starts_with("16 workers:"), "{schedule}");
        assert!(lines[2].starts_with("critical path, 0.0 s: nothing/"), "{schedule}");
        assert_eq!(lines[3], "2 of 2 records have never been made and count as 0 s");
    }
}
