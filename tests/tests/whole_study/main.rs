//! A whole study in a minute: the virtual bench records a coarse tail, and every stage, figure and table for one tail is made of it. Its numbers are
//! those of `numbers.toml`, so that a change anywhere between recording and paper that changes a number is seen.
#![allow(clippy::unwrap_used)]

mod digest;
mod outputs;
mod project;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use project::Project;
use workflow::runner::Goal;

/// By how much another processor's rounding may change a number: a share of it, or this much if that is more.
const SHARE: f64 = 0.02;
const LEAST: f64 = 1e-4;

/// The numbers of a run by name.
fn numbers(json: &str) -> BTreeMap<String, f64> {
    let all: serde_json::Value = serde_json::from_str(json).unwrap();
    let metrics = all.as_array().unwrap();
    let number = |m: &serde_json::Value| Some((m["id"].as_str()?.to_owned(), m["value"].as_f64()?));
    metrics.iter().filter_map(number).filter(|(id, _)| !is_of_time(id)).collect()
}

/// Whether a number says how long something took.
fn is_of_time(id: &str) -> bool {
    ["seconds", "real_time_factor", "gradient_over_forward"].iter().any(|word| id.contains(word))
}

/// What differs, as lines of the file.
fn drifted(expected: &BTreeMap<String, f64>, found: &BTreeMap<String, f64>) -> String {
    let mut lines = String::new();
    for (id, value) in found {
        match expected.get(id) {
            Some(other) if (value - other).abs() <= (SHARE * other.abs()).max(LEAST) => {}
            Some(other) => writeln!(lines, "\"{id}\" = {value:.4e} # was {other:.4e}").unwrap(),
            None => writeln!(lines, "\"{id}\" = {value:.4e} # is new").unwrap(),
        }
    }
    let lost = expected.keys().filter(|id| !found.contains_key(*id));
    lost.for_each(|id| writeln!(lines, "# \"{id}\" is not made").unwrap());
    lines
}

#[test]
fn a_coarse_tail_goes_from_the_bench_to_every_figure_with_the_expected_numbers() {
    let project = Project::recorded("whole");
    let runner = project.open();
    let made = study::run(&runner, &Goal::default(), false).unwrap();
    assert_eq!((made.kept, made.failed, made.skipped), (0, 0, 0));
    let expected: BTreeMap<String, f64> = toml::from_str(include_str!("numbers.toml")).unwrap();
    let found = numbers(&std::fs::read_to_string(runner.folders.metrics()).unwrap());
    let lines = drifted(&expected, &found);
    assert!(lines.is_empty(), "numbers.toml has other numbers:\n{lines}");
    study::page(&runner).unwrap();
    let changed = outputs::changed(&project.0);
    assert!(changed.is_empty(), "outputs.txt has other files:\n{changed}");
    // nothing is made twice
    let again = study::run(&runner, &Goal::default(), false).unwrap();
    assert_eq!((again.made, again.kept), (0, made.made));
}
