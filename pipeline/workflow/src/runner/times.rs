//! Where the time goes: what the records of each stage took when they were made, as their manifests say, and how many are left to make.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::Runner;
use super::graph::Job;
use super::plan;
use super::store::Store;
use crate::needs::RecordId;
use crate::subject::Universe;

/// One record: how long it took, where it was made, and whether a run would make it.
struct Record<'a> {
    id: &'a RecordId,
    /// s.
    seconds: Option<f64>,
    /// MiB.
    peak_memory: Option<f64>,
    left: bool,
}

/// The records of one stage, figure or table.
struct StageTime<'a> {
    stage: &'a str,
    records: Vec<&'a Record<'a>>,
}

/// One line a stage in the order of the pipeline, then the sum.
pub(super) fn times_text<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>]) -> String {
    let (store, up_to_date) = (Store::new(&runner.folders), plan::up_to_date(runner, jobs));
    let records: Vec<Record> = jobs.iter().map(|job| planned_record(job, &store, &up_to_date)).collect();
    format_table(&records)
}

fn planned_record<'a, U: Universe>(job: &'a Job<U>, store: &Store, up_to_date: &BTreeSet<RecordId>) -> Record<'a> {
    let measured = store.measured(&job.id);
    let (seconds, peak_memory) = (measured.map(|m| m.seconds), measured.and_then(|m| m.peak_memory));
    Record { id: &job.id, seconds, peak_memory, left: !up_to_date.contains(&job.id) }
}

fn format_table(records: &[Record]) -> String {
    let total = StageTime { stage: "all", records: records.iter().collect() };
    let mut text = format!(
        "{:<20} {:>7} {:>6} {:>10} {:>6} {:>9}  longest record\n",
        "stage", "records", "left", "time (s)", "share", "MiB"
    );
    for stage in by_stage(records).iter().chain([&total]) {
        writeln!(text, "{}", stage.table_row(total.total_seconds())).expect("a string takes any text");
    }
    let remaining = total.records.iter().filter(|record| record.left);
    let (measured, unmeasured): (Vec<&&Record>, Vec<&&Record>) = remaining.partition(|record| record.seconds.is_some());
    let seconds: f64 = measured.iter().filter_map(|record| record.seconds).sum();
    let count = measured.len() + unmeasured.len();
    let never = if unmeasured.is_empty() { String::new() } else { format!("; {} were never made", unmeasured.len()) };
    write!(text, "left to make: {count} of {} records, which took {seconds:.1} s before{never}", records.len())
        .expect("a string takes any text");
    text
}

/// The records of each stage, in the order in which stages first appear.
fn by_stage<'a>(records: &'a [Record<'a>]) -> Vec<StageTime<'a>> {
    let mut stages: Vec<StageTime> = Vec::new();
    for record in records {
        match stages.iter_mut().find(|stage| stage.stage == record.id.stage) {
            Some(stage) => stage.records.push(record),
            None => stages.push(StageTime { stage: record.id.stage, records: vec![record] }),
        }
    }
    stages
}

impl StageTime<'_> {
    fn total_seconds(&self) -> f64 {
        // a sum of nothing would be printed as -0.0
        self.records.iter().filter_map(|record| record.seconds).fold(0.0, |sum, seconds| sum + seconds)
    }

    fn table_row(&self, total: f64) -> String {
        let measured = self.records.iter().filter_map(|record| Some((record.seconds?, record.id)));
        let longest = measured.max_by(|a, b| a.0.total_cmp(&b.0));
        let longest = longest.map_or_else(|| "–".to_owned(), |(seconds, id)| format!("{id} {seconds:.1} s"));
        let peak = self.records.iter().filter_map(|record| record.peak_memory).reduce(f64::max);
        let peak = peak.map_or_else(|| "–".to_owned(), |peak| format!("{peak:.0}"));
        let remaining = self.records.iter().filter(|record| record.left).count();
        let share = 100.0 * self.total_seconds() / total.max(f64::MIN_POSITIVE);
        format!(
            "{:<20} {:>7} {remaining:>6} {:>10.1} {share:>5.1}% {peak:>9}  {longest}",
            self.stage,
            self.records.len(),
            self.total_seconds()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(stage: &'static str, subject: &str) -> RecordId {
        RecordId { stage, subject: subject.to_owned() }
    }

    #[test]
    fn stages_stand_in_their_order_with_their_sums_and_what_is_left() {
        let ids = [id("mesh", "a"), id("track", "a"), id("mesh", "b"), id("track", "b")];
        let record = |k: usize, seconds: Option<f64>, left| Record { id: &ids[k], seconds, peak_memory: seconds, left };
        let table_text = format_table(&[
            record(0, Some(1.0), false),
            record(1, Some(6.0), true),
            record(2, Some(3.0), false),
            record(3, None, true),
        ]);
        let lines: Vec<Vec<&str>> = table_text.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(lines[1], ["mesh", "2", "0", "4.0", "40.0%", "3", "mesh/b", "3.0", "s"]);
        assert_eq!(lines[2], ["track", "2", "2", "6.0", "60.0%", "6", "track/a", "6.0", "s"]);
        assert_eq!(lines[3][..5], ["all", "4", "2", "10.0", "100.0%"]);
        assert!(
            table_text.ends_with("left to make: 2 of 4 records, which took 6.0 s before; 1 were never made"),
            "{table_text}"
        );
    }
}
