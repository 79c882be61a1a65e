//! Runs: flapping trials stacked in one table, so that other stages can train on them without preparing them again.

use std::ops::Range;

use lab::card::Split;
use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal, Point2};

use ::thrust::Run;
use ::thrust::run::TheoryTerms;
use workflow::columns::Columns;
use workflow::record::RecordError;

/// Data of a run beside its samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Head {
    id: String,
    amplitude_pa: Pascal,
    frequency_hz: Hertz,
    split: Option<String>,
    rate_hz: Hertz,
    samples: usize,
    markers: usize,
    chambers: usize,
}

impl Head {
    /// Of a run.
    pub fn of_run(run: &Run) -> Self {
        Self {
            id: run.id.clone(),
            amplitude_pa: run.amplitude,
            frequency_hz: run.frequency,
            split: run.split.map(|s| s.word().to_owned()),
            rate_hz: run.rate,
            samples: run.len(),
            markers: run.moved.first().map_or(0, Vec::len),
            chambers: run.pressure.first().map_or(0, Vec::len),
        }
    }

    fn split_of_head(&self) -> Option<Split> {
        [Split::Train, Split::Test].into_iter().find(|split| self.split.as_deref() == Some(split.word()))
    }
}

/// One term of theory.
type Column = (&'static str, fn(&TheoryTerms) -> f64);
/// The terms of theory, by their columns.
const COLUMNS: [Column; 5] = [
    ("simplified_n", |p| p.trailing_edge),
    ("edge_flux_n", |p| p.edge_flux),
    ("momentum_rate_n", |p| p.momentum_rate),
    ("drag_n", |p| p.drag),
    ("tip_acceleration_m_s2", |p| p.tip_acceleration),
];

/// Runs of one specimen, stacked.
pub(super) fn runs_table(runs: &[Run]) -> Columns {
    let heads: Vec<Head> = runs.iter().map(Head::of_run).collect();
    let (markers, chambers) = heads.first().map_or((0, 0), |h| (h.markers, h.chambers));
    let each = |value: &dyn Fn(&Run, usize) -> f64| -> Vec<f64> {
        runs.iter().flat_map(|run| (0..run.len()).map(|i| value(run, i)).collect::<Vec<_>>()).collect()
    };
    let mut table = Columns::default().numbers("time_s", each(&|r, i| r.time[i]));
    table = table.numbers("force_n", each(&|r, i| r.force[i]));
    for (marker, (k, axis)) in (0..markers).flat_map(|m| [(m, (0, "x")), (m, (1, "y"))]) {
        table = table
            .numbers(&format!("{axis}{marker}_m"), each(&|r, i| r.moved[i][marker][k]))
            .numbers(&format!("v{axis}{marker}_m_s"), each(&|r, i| r.speed[i][marker][k]));
    }
    for chamber in 0..chambers {
        table = table
            .numbers(&format!("p{chamber}_pa"), each(&|r, i| r.pressure[i][chamber]))
            .numbers(&format!("vp{chamber}_pa_s"), each(&|r, i| r.pressure_rate[i][chamber]));
    }
    COLUMNS.iter().fold(table, |table, (name, term)| table.numbers(name, each(&|r, i| term(&r.terms[i]))))
}

/// The runs of a table.
///
/// # Errors
/// [`RecordError`] when a column is absent or its length differs from that of the heads.
pub(super) fn read_runs(heads: &[Head], table: &Columns) -> Result<Vec<Run>, RecordError> {
    let rows = heads.iter().try_fold(0_usize, |sum, head| sum.checked_add(head.samples));
    let rows =
        rows.ok_or_else(|| super::inconsistent_file("thrust.json", "its runs have more samples than there can be"))?;
    let column = |name: &str| -> Result<Vec<f64>, RecordError> {
        let values = table.f64(name)?;
        if values.len() == rows { Ok(values) } else { Err(RecordError::Absent(format!("{name} of {rows} samples"))) }
    };
    let (markers, chambers) = heads.first().map_or((0, 0), |h| (h.markers, h.chambers));
    if heads.iter().any(|head| (head.markers, head.chambers) != (markers, chambers)) {
        return Err(super::inconsistent_file("thrust.json", "its runs differ in markers or chambers"));
    }
    let columns = RunColumns::of_table(&column, (markers, chambers))?;
    let mut start = 0;
    let run = |head: &Head| {
        let rows = start..start + head.samples;
        start = rows.end;
        columns.run_of(head, rows)
    };
    Ok(heads.iter().map(run).collect())
}

/// The columns of stacked runs, by what they hold.
struct RunColumns {
    time: Vec<f64>,
    force: Vec<f64>,
    displacement: Vec<Vec<f64>>,
    speed: Vec<Vec<f64>>,
    pressure: Vec<Vec<f64>>,
    pressure_rate: Vec<Vec<f64>>,
    terms: Vec<Vec<f64>>,
}

impl RunColumns {
    /// Those of so many markers and chambers, each read by `column`.
    fn of_table(
        column: &dyn Fn(&str) -> Result<Vec<f64>, RecordError>,
        (markers, chambers): (usize, usize),
    ) -> Result<Self, RecordError> {
        let several = |names: Vec<String>| names.iter().map(|n| column(n)).collect::<Result<Vec<_>, _>>();
        let of_marks = |prefix: &str, unit: &str| {
            several((0..markers).flat_map(|m| ["x", "y"].map(|a| format!("{prefix}{a}{m}_{unit}"))).collect())
        };
        let of_chambers =
            |prefix: &str, unit: &str| several((0..chambers).map(|c| format!("{prefix}{c}_{unit}")).collect());
        Ok(Self {
            time: column("time_s")?,
            force: column("force_n")?,
            displacement: of_marks("", "m")?,
            speed: of_marks("v", "m_s")?,
            pressure: of_chambers("p", "pa")?,
            pressure_rate: of_chambers("vp", "pa_s")?,
            terms: COLUMNS.iter().map(|(name, _)| column(name)).collect::<Result<_, _>>()?,
        })
    }

    /// The run in some of the rows.
    fn run_of(&self, head: &Head, rows: Range<usize>) -> Run {
        // length: a column along x and one along y were read of each marker
        let points = |columns: &[Vec<f64>], i: usize| {
            columns.chunks_exact(2).map(|xy| [xy[0][i], xy[1][i]]).collect::<Vec<Point2>>()
        };
        let numbers = |columns: &[Vec<f64>], i: usize| columns.iter().map(|c| c[i]).collect::<Vec<f64>>();
        Run {
            id: head.id.clone(),
            amplitude: head.amplitude_pa,
            frequency: head.frequency_hz,
            split: head.split_of_head(),
            rate: head.rate_hz,
            time: self.time[rows.clone()].to_vec(),
            force: self.force[rows.clone()].to_vec(),
            moved: rows.clone().map(|i| points(&self.displacement, i)).collect(),
            speed: rows.clone().map(|i| points(&self.speed, i)).collect(),
            pressure: rows.clone().map(|i| numbers(&self.pressure, i)).collect(),
            pressure_rate: rows.clone().map(|i| numbers(&self.pressure_rate, i)).collect(),
            terms: rows.map(|i| self.terms_of(i)).collect(),
        }
    }

    fn terms_of(&self, row: usize) -> TheoryTerms {
        TheoryTerms {
            trailing_edge: self.terms[0][row],
            edge_flux: self.terms[1][row],
            momentum_rate: self.terms[2][row],
            drag: self.terms[3][row],
            tip_acceleration: self.terms[4][row],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::thrust::models::testing::run;

    #[test]
    fn runs_survive_their_table_bit_for_bit() {
        let mut runs = vec![run(1.0, 2e4, 1), run(2.0, 1e4, 2)];
        (runs[0].split, runs[1].split) = (Some(Split::Train), Some(Split::Test));
        runs[1].pressure_rate.iter_mut().enumerate().for_each(|(i, p)| p[1] = i as f64 / 7.0);
        let heads: Vec<Head> = runs.iter().map(Head::of_run).collect();
        let bytes = runs_table(&runs).to_parquet().unwrap();
        assert_eq!(read_runs(&heads, &Columns::from_parquet(&bytes).unwrap()).unwrap(), runs);
    }

    #[test]
    fn a_table_shorter_than_its_heads_is_refused() {
        let runs = [run(1.0, 2e4, 1)];
        let heads = [Head { samples: 401, ..Head::of_run(&runs[0]) }];
        assert!(read_runs(&heads, &runs_table(&runs)).is_err());
    }
}
