//! Resources of a rule: time, memory and threads, from records that were measured.

use crate::runner::Measured;

/// What is asked for where nothing was measured: most stages need less.
const DEFAULT: Resources = Resources { threads: 1, memory: 2048, runtime: 60 };
/// Asked for over measured: machines differ, and a job that is stopped is lost.
const MARGIN: f64 = 3.0;
/// The same of memory, which depends on the inputs alone.
const MEMORY_MARGIN: f64 = 1.5;
/// Of the program itself, MB: a short job is measured before it has touched all of it.
const LEAST_MEMORY: u64 = 512;
/// More threads than this were never measured to be of use to one record.
const MOST_THREADS: f64 = 8.0;

/// What one job of a rule asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resources {
    /// Cores.
    pub threads: u64,
    /// MB (`mem_mb`).
    pub memory: u64,
    /// Minutes.
    pub runtime: u64,
}

impl Resources {
    /// Those of the largest of these records.
    pub fn of(measured: &[Measured]) -> Self {
        let largest = |value: &dyn Fn(&Measured) -> Option<f64>| measured.iter().filter_map(value).reduce(f64::max);
        let seconds = largest(&|record| Some(record.seconds));
        let memory = largest(&|record| record.peak_memory);
        // The longest record decides: short ones keep few cores busy and end soon.
        let longest = measured
            .iter()
            .filter(|record| record.cpu_seconds.is_some())
            .max_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let busy = longest.and_then(|record| Some(record.cpu_seconds? / record.seconds.max(1e-3)));
        Self {
            threads: busy.map_or(DEFAULT.threads, |cores| cores.round().clamp(1.0, MOST_THREADS) as u64),
            memory: memory.map_or(DEFAULT.memory, |mb| ((MEMORY_MARGIN * mb).ceil() as u64).max(LEAST_MEMORY)),
            runtime: seconds.map_or(DEFAULT.runtime, |s| (MARGIN * s / 60.0).ceil().max(1.0) as u64),
        }
    }

    /// In words, with what they are from.
    pub fn in_words(measured: &[Measured]) -> String {
        let largest = |value: &dyn Fn(&Measured) -> Option<f64>| measured.iter().filter_map(value).reduce(f64::max);
        if measured.is_empty() {
            return "not measured".into();
        }
        let shown = |value: Option<f64>, unit: &str| value.map_or("not measured".into(), |v| format!("{v:.1} {unit}"));
        let (seconds, memory) = (largest(&|record| Some(record.seconds)), largest(&|record| record.peak_memory));
        format!("of {} records: at most {}, {}", measured.len(), shown(seconds, "s"), shown(memory, "MB"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resources_are_those_of_the_largest_record_with_a_margin_and_defaults_where_nothing_was_measured() {
        assert_eq!(Resources::of(&[]), DEFAULT);
        let short = Measured { seconds: 2.0, cpu_seconds: Some(2.0), peak_memory: Some(1000.0) };
        let long = Measured { seconds: 100.0, cpu_seconds: Some(190.0), peak_memory: Some(800.0) };
        assert_eq!(Resources::of(&[short, long]), Resources { threads: 2, memory: 1500, runtime: 5 });
        let unknown = Measured { seconds: 1.0, cpu_seconds: None, peak_memory: None };
        assert_eq!(Resources::of(&[unknown]), Resources { runtime: 1, ..DEFAULT });
        assert_eq!(Resources::in_words(&[short, long]), "of 2 records: at most 100.0 s, 1000.0 MB");
    }
}
