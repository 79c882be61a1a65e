//! Table `trials`: training and test trials of the thrust models, beside the published column. Paper, table II.

use lab::card::{Experiment, Split};
use plot::{Alignment, Column};
use si::MILLIBAR;

use diagnostics::{Diagnostic, Result};
use records::Thrust;
use records::subject::{Specimen, Study};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct Trials;

impl Table for Trials {
    type Of = Study;
    type Needs = Every<Thrust, Specimen>;
    const NAME: &'static str = "trials";
    const CAPTION: &'static str = "training and test trials of the thrust models";
    const VERSION: u32 = 2;

    fn is_made_for(study: &Study) -> bool {
        Every::<Thrust>::any(study)
    }

    fn fill(Every(thrusts): Self::Needs) -> Result<plot::Table> {
        let columns = [Column::text("specimen"), Column::text("mode")]
            .into_iter()
            .chain(Column::beside_published("trials", ""))
            .chain(words_beside_published("pressure", "mbar"))
            .chain(words_beside_published("frequency", "Hz"))
            .collect();
        let rows = thrusts.iter().flat_map(|(s, _)| [Split::Train, Split::Test].map(|split| split_row(s, split)));
        plot::Table::new(columns, rows.collect()).map_err(Diagnostic::from)
    }
}

fn words_beside_published(group: &str, unit: &str) -> [Column; 2] {
    Column::beside_published(group, unit).map(|column| Column { alignment: Alignment::Left, ..column })
}

fn split_row(specimen: &Specimen, split: Split) -> Vec<String> {
    let trials = specimen.trials();
    let trials_of_split: Vec<_> =
        trials.iter().filter(|t| t.has_force_in_water() && t.trial.split == Some(split)).collect();
    let actuations = trials_of_split.iter().filter_map(|t| match t.trial.experiment {
        Experiment::Flapping { amplitude, frequency, .. } => Some((amplitude / MILLIBAR, frequency)),
        Experiment::Staircase { .. } => None,
    });
    let (pressures, frequencies): (Vec<f64>, Vec<f64>) = actuations.unzip();
    let mode = if split == Split::Train { "training" } else { "test" };
    let published = published_trials(&specimen.name(), split);
    let counted = [trials_of_split.len().to_string(), distinct_values(pressures), distinct_values(frequencies)];
    let pairs = counted.into_iter().zip(published).flat_map(|(a, b)| [a, b.to_owned()]);
    [specimen.name(), mode.into()].into_iter().chain(pairs).collect()
}

fn distinct_values(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    values.iter().map(|v| format!("{v:.0}")).collect::<Vec<_>>().join(", ")
}

/// The paper's table II: trials, mbar, Hz.
fn published_trials(specimen: &str, split: Split) -> [&'static str; 3] {
    match (specimen, split) {
        ("nemo", Split::Train) => ["32", "200, 300", "1, 2, 3, 4"],
        ("nemo", Split::Test) => ["8", "200, 300", "1, 2, 3, 4"],
        ("bruce", Split::Train) => ["30", "500, 750", "1, 2, 3"],
        ("bruce", Split::Test) => ["10", "500, 750", "4"],
        _ => [""; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_listed_once_each_in_rising_order() {
        assert_eq!(distinct_values(vec![300.0, 200.0, 300.0 + 1e-9, 200.0]), "200, 300");
    }
}
