//! Table `bench_realism`: properties of the instruments in the recordings, beside those of real ones.
//!
//! The measured column is of a proportional valve and a 1 kg load cell on such a tail, and of a similar tank.

use lab::card::{Experiment, Medium};
use plot::Column;
use si::{Hertz, MILLIBAR};

use super::instruments::{finite_range, log_scatter};
use diagnostics::Result;
use records::subject::{Specimen, Study, Trial};
use records::{CorrectedForce, Motion, PAPER_MODEL, Relaxation, Tank, Thrust, Validation};
use signal::step_response::{Pulse, pulses};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct BenchRealism;

/// Levels count as equal within this difference, mbar.
const NEAR: f64 = 15.0;
/// mbar, and the time constants measured from there, ms.
const EMPTIED: [(f64, [f64; 2]); 3] = [(90.0, [25.0, 29.0]), (190.0, [38.0, 40.0]), (240.0, [44.0, 48.0])];
/// Hz, and what a square wave of 300 mbar is held at, mbar.
const HELD: [(f64, f64); 5] = [(1.0, 276.0), (2.0, 265.0), (3.0, 258.0), (3.5, 245.0), (4.0, 237.0)];
/// Specimen, mbar, N after five seconds in still water.
const STILL: [(&str, f64, [f64; 2]); 5] = [
    ("nemo", 100.0, [0.017, 0.017]),
    ("nemo", 200.0, [0.056, 0.056]),
    ("nemo", 250.0, [0.163, 0.232]),
    ("dory", 400.0, [0.07, 0.07]),
    ("bruce", 500.0, [0.071, 0.071]),
];

/// Records of the instruments.
type Instruments = (Every<Motion, Trial>, Every<CorrectedForce, Trial>, Every<Tank, Specimen>, Every<Thrust, Specimen>);
/// Records of the silicone, and of predictions by the paper's own model.
type Silicone = (Every<Relaxation, Specimen>, Every<Validation, Trial>);

/// One line: quantity, unit, digits, range of real instruments, range in these recordings.
struct Line(String, &'static str, usize, [f64; 2], Option<[f64; 2]>);

impl Table for BenchRealism {
    type Of = Study;
    type Needs = (Instruments, Silicone);
    const NAME: &'static str = "bench_realism";
    const CAPTION: &'static str = "instruments in the recordings and real instruments";
    const VERSION: u32 = 3;

    fn fill((instruments, silicone): Self::Needs) -> Result<plot::Table> {
        let (Every(motions), Every(pulls), Every(tanks), Every(thrusts)) = instruments;
        let columns = [Column::text("quantity"), Column::text("unit")]
            .into_iter()
            .chain(Column::beside_published("range", "").map(real_column))
            .chain([Column::text("verdict")])
            .collect();
        let lines = [
            valve_lines(&motions),
            load_cell_lines(&pulls),
            wave_lines(&tanks),
            still_water_lines(&thrusts),
            silicone_lines(&silicone),
        ]
        .into_iter()
        .flatten();
        let table = plot::Table::new(columns, lines.filter_map(quantity_row).collect())?;
        Ok(table
            .noted("Real: a proportional valve, a 1 kg load cell, a similar tank and like silicones, measured; of the paper only the error of its model on its hardware."))
    }
}

/// The column of values measured on such instruments, not published in the paper.
fn real_column(column: Column) -> Column {
    if column.published { Column { title: "real".into(), ..column } } else { column }
}

fn quantity_row(Line(quantity, unit, digits, real, ours): Line) -> Option<Vec<String>> {
    let ours = ours?;
    let evaluated = |[low, high]: [f64; 2]| match high - low < 0.5 * 10_f64.powi(-(digits as i32)) {
        true => format!("{low:.digits$}"),
        false => format!("{low:.digits$} to {high:.digits$}"),
    };
    let lies_outside = ours[1] < real[0] || real[1] < ours[0];
    let lies_inside = real[0] <= ours[0] && ours[1] <= real[1];
    let verdict = if lies_inside {
        "inside"
    } else if lies_outside {
        "outside"
    } else {
        "overlaps"
    };
    Some(vec![quantity, unit.into(), evaluated(ours), evaluated(real), verdict.into()])
}

/// The identified silicone beside published ones; the error of the paper's own model in air beside that on the paper's hardware.
fn silicone_lines((Every(relaxed), Every(validated)): &Silicone) -> Vec<Line> {
    let spectrum_range =
        |f: Hertz, k: usize| finite_range(relaxed.iter().filter_map(|(_, r)| Some(r.spectrum.at(f).ok()?[k])));
    let storage = |r: &Relaxation| Some(100.0 * (r.spectrum.at(8.0).ok()?[0] / r.spectrum.at(1.0).ok()?[0] - 1.0));
    let paper = |v: &Validation| Some(1e3 * v.scored.iter().find(|s| s.name == PAPER_MODEL)?.rmse);
    let in_air = validated.iter().filter(|(t, _)| !t.is_in_water());
    vec![
        Line("silicone: loss factor at 1 Hz".into(), "", 3, [0.06, 0.08], spectrum_range(1.0, 1)),
        Line("silicone: loss factor at 8 Hz".into(), "", 3, [0.08, 0.13], spectrum_range(8.0, 1)),
        Line(
            "silicone: storage modulus from 1 to 8 Hz".into(),
            "%",
            0,
            [5.0, 12.0],
            finite_range(relaxed.iter().filter_map(|(_, r)| storage(r))),
        ),
        Line(
            "the paper's own model: error in air".into(),
            "mm",
            1,
            [0.6, 3.0],
            finite_range(in_air.filter_map(|(_, v)| paper(v))),
        ),
    ]
}

fn valve_lines(motions: &[(Trial, Motion)]) -> Vec<Line> {
    let pulses_of_trials: Vec<(&Trial, Pulse)> = motions
        .iter()
        .flat_map(|(t, m)| {
            m.gauges.iter().flat_map(move |g| pulses(&m.log_time, g.signals()).into_iter().map(move |p| (t, p)))
        })
        .collect();
    let is_near = |p: &Pulse, mbar: f64| (p.held / MILLIBAR - mbar).abs() < NEAR;
    let is_staircase = |t: &Trial| matches!(t.trial.experiment, Experiment::Staircase { .. });
    let staircase_range = |value: &dyn Fn(&Pulse) -> Option<f64>| {
        finite_range(pulses_of_trials.iter().filter(|(t, _)| is_staircase(t)).filter_map(|(_, p)| value(p)))
    };
    let range_near = |mbar, value: fn(&Pulse) -> f64| staircase_range(&move |p| is_near(p, mbar).then(|| value(p)));
    let is_low = |p: &Pulse| p.asked < 260.0 * MILLIBAR;
    let line = |what: &str, unit, real, ours| Line(what.into(), unit, 0, real, ours);
    let mut lines = vec![
        line("fill near 100 mbar: dead time", "ms", [70.0, 85.0], range_near(90.0, |p| 1e3 * p.fill_dead)),
        line("fill near 200 mbar: dead time", "ms", [40.0, 45.0], range_near(190.0, |p| 1e3 * p.fill_dead)),
        line(
            "fill up to 250 mbar: within 5 %",
            "ms",
            [150.0, 230.0],
            staircase_range(&|p| is_low(p).then_some(1e3 * p.fill)),
        ),
        line(
            "steady pressure below the command by",
            "mbar",
            [5.0, 15.0],
            staircase_range(&|p| Some((p.asked - p.held) / MILLIBAR)),
        ),
        line("exhaust near 200 mbar: dead time", "ms", [38.0, 58.0], range_near(190.0, |p| 1e3 * p.empty_dead)),
    ];
    lines.extend(EMPTIED.map(|(mbar, real)| {
        line(&format!("exhaust from {mbar} mbar: time constant"), "ms", real, range_near(mbar, |p| 1e3 * p.empty))
    }));
    lines.extend(HELD.map(|held| square_wave_line(held, &pulses_of_trials)));
    lines
}

/// The pressure that a square wave of 300 mbar at some Hz is held at, beside that of a real valve, mbar.
fn square_wave_line((hz, mbar): (f64, f64), pulses_of_trials: &[(&Trial, Pulse)]) -> Line {
    let is_same = |t: &Trial, p: &Pulse| flaps_at(t, hz) && (p.asked / MILLIBAR - 300.0).abs() < 1.0;
    let ours = finite_range(pulses_of_trials.iter().filter(|(t, p)| is_same(t, p)).map(|(_, p)| p.held / MILLIBAR));
    Line(format!("square wave of 300 mbar at {hz} Hz: held"), "mbar", 0, [mbar - 6.0, mbar + 6.0], ours)
}

fn flaps_at(trial: &Trial, hz: f64) -> bool {
    matches!(trial.trial.experiment, Experiment::Flapping { frequency, .. } if (frequency - hz).abs() < 0.01)
}

fn load_cell_lines(pulls: &[(Trial, CorrectedForce)]) -> Vec<Line> {
    let noise_before_command = |pull: &CorrectedForce| {
        let samples_at_rest = pull.time.iter().zip(&pull.raw).filter(|(t, _)| **t < pull.commanded[0]);
        1e3 * log_scatter(&samples_at_rest.map(|(_, f)| *f).collect::<Vec<_>>())
    };
    let drift = |pull: &CorrectedForce| Some(1e3 * (pull.zero.last()? - pull.zero.first()?).abs());
    let in_water = || pulls.iter().filter(|(t, _)| t.trial.medium == Medium::Water);
    vec![
        Line(
            "noise in water".into(),
            "mN",
            1,
            [1.0, 3.0],
            finite_range(in_water().map(|(_, p)| noise_before_command(p))),
        ),
        Line(
            "drift of the zero in a run".into(),
            "mN",
            1,
            [0.0, 45.0],
            finite_range(pulls.iter().filter_map(|(_, p)| drift(p))),
        ),
    ]
}

fn wave_lines(tanks: &[(Specimen, Tank)]) -> Vec<Line> {
    // a mode that does not rise over the noise of one tank has no wave there: waves are sorted by the bands of their modes
    let wave_range = |k: usize| finite_range(tanks.iter().filter_map(|(_, tank)| tank.wave_of(k)));
    vec![
        Line("tank: first wave".into(), "Hz", 2, [1.0, 1.2], wave_range(0)),
        Line("tank: second wave".into(), "Hz", 2, [1.8, 2.0], wave_range(1)),
    ]
}

/// The cross-talk at pressures at which real tails were held.
fn still_water_lines(thrusts: &[(Specimen, Thrust)]) -> Vec<Line> {
    let ours = |name: &str, mbar: f64| {
        let (_, thrust) = thrusts.iter().find(|(s, _)| s.name() == name)?;
        let curve = thrust.crosstalk.pressures_pa.iter().zip(&thrust.crosstalk.forces_n);
        finite_range(curve.filter(|(p, _)| (**p / MILLIBAR - mbar).abs() < NEAR).map(|(_, f)| *f))
    };
    let line = |(name, mbar, real): (&str, f64, [f64; 2])| {
        Line(format!("static force of {name} in water at {mbar} mbar"), "N", 3, real, ours(name, mbar))
    };
    STILL.map(line).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(real: [f64; 2], ours: [f64; 2]) -> String {
        quantity_row(Line("a".into(), "ms", 0, real, Some(ours))).unwrap().pop().unwrap()
    }

    #[test]
    fn a_range_lies_inside_overlaps_or_lies_outside() {
        assert_eq!(verdict([1.0, 4.0], [2.0, 3.0]), "inside");
        assert_eq!(verdict([1.0, 4.0], [3.0, 5.0]), "overlaps");
        assert_eq!(verdict([1.0, 4.0], [5.0, 6.0]), "outside");
    }

    #[test]
    fn what_was_not_recorded_has_no_line() {
        assert!(quantity_row(Line("a".into(), "ms", 0, [0.0, 1.0], None)).is_none());
    }
}
