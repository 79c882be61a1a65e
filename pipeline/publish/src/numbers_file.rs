//! `paper/numbers.csv`: the numbers of the paper profile that text and claims use, tracked with the source, so that the PDF can be made without
//! the records. Where there are records it is written anew from them; the paper is set from the file in either case, so that both give the same
//! bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::expected::{Expected, MetricEntry};
use diagnostics::{Diagnostic, Result, input};
use workflow::metric::Metric;
use workflow::runner::write_atomically;

/// The file, below the paper's source.
pub(crate) const FILE: &str = "numbers.csv";
/// The source of a number that was computed by a run.
pub(crate) const RECORDS: &str = "records";
/// Beyond this many digits a number is no part of the paper, and its last ones change from machine to machine.
const DIGITS: usize = 6;

/// A line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Number {
    /// The metric's name.
    metric: String,
    /// In its unit.
    value: f64,
    /// Empty for pure numbers.
    unit: String,
    /// `records`, `tables` or `expected`.
    from: String,
}

/// The numbers of a paper.
pub(crate) struct Numbers {
    /// Each with its expectation.
    pub entries: Vec<MetricEntry>,
    /// How many are from each source.
    pub sources: BTreeMap<String, usize>,
}

/// Reads the file; where there is none, no numbers.
///
/// # Errors
/// A [`Diagnostic`] when it is not understood.
pub(crate) fn read(paper: &Path, expected: &Expected) -> Result<Numbers> {
    let path = paper.join(FILE);
    let text =
        if path.exists() { input::read_text(&path, input::LOG).map_err(|e| unreadable(&e))? } else { String::new() };
    let lines: Vec<Number> = csv::Reader::from_reader(text.as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .map_err(|e| unreadable(&e))?;
    let mut sources = BTreeMap::new();
    lines.iter().for_each(|line| *sources.entry(line.from.clone()).or_insert(0) += 1);
    let entry = |line: Number| expected.judge(Metric::new(line.metric, line.value, &line.unit));
    Ok(Numbers { entries: lines.into_iter().map(entry).collect(), sources })
}

/// Writes the numbers of a run that the paper knows by name, with the ends of their intervals.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be written.
pub(crate) fn write(paper: &Path, metrics: &[MetricEntry], known: &BTreeSet<String>) -> Result<()> {
    let base = |id: &str| id.trim_end_matches(".low").trim_end_matches(".high").to_owned();
    let used = metrics.iter().map(|entry| &entry.metric).filter(|metric| known.contains(&base(&metric.id)));
    let mut writer = csv::Writer::from_writer(Vec::new());
    for Metric { id, value, unit } in used {
        let number =
            Number { metric: id.clone(), value: rounded(*value), unit: unit.clone(), from: RECORDS.to_owned() };
        writer.serialize(number).map_err(|e| unwritable(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| unwritable(&e))?;
    write_atomically(&paper.join(FILE), &bytes).map_err(|e| unwritable(&e))
}

fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

fn unreadable(error: &dyn std::fmt::Display) -> Diagnostic {
    Diagnostic::new(
        "paper/numbers.csv cannot be read",
        error,
        "restore it with git, or write it anew: study run, study paper",
    )
}

fn unwritable(error: &dyn std::fmt::Display) -> Diagnostic {
    Diagnostic::new("paper/numbers.csv cannot be written", error, "check its permissions and the free disk space")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_that_the_paper_names_come_back_rounded_and_others_are_not_kept() {
        let folder = std::env::temp_dir().join(format!("numbers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let expected = Expected::default();
        let metrics = [("a.b", 0.123_456_789), ("a.b.low", 0.1), ("c", 2.0)];
        let metrics = metrics.map(|(id, value)| expected.judge(Metric::new(id, value, "mm")));
        write(&folder, &metrics, &BTreeSet::from(["a.b".to_owned()])).unwrap();
        let numbers = read(&folder, &expected).unwrap();
        let values: Vec<(&str, f64)> = numbers.entries.iter().map(|e| (e.metric.id.as_str(), e.metric.value)).collect();
        assert_eq!(values, [("a.b", 0.123_457), ("a.b.low", 0.1)]);
        assert_eq!(numbers.sources, BTreeMap::from([(RECORDS.to_owned(), 2)]));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
