//! Findings: metrics of the paper's claims that are derived from several records.

use serde::{Deserialize, Serialize};

use crate::records::{Finding, Findings as Record, Identified, LoadCell, Surface, Thrust, Validation};
use crate::subject::Condition;
use diagnostics::Result;
use workflow::needs::Every;
use workflow::stage::{Stage, StageContext};

/// Rise of χ² that separates two minima: one standard deviation; less is noise.
const RISE: f64 = 1.0;

/// The stage.
pub struct Findings;

/// `[findings]` in `study.toml`: nothing to set.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

impl Stage for Findings {
    type Settings = Settings;
    type Card = ();
    type Needs = (Every<Identified>, Every<Validation, Condition>, Every<Thrust>, Every<LoadCell>);
    type Makes = Record;
    const DESCRIPTION: &'static str = "metrics that decide claims are derived";
    const VERSION: u32 = 5;

    fn run((): &(), _: &Settings, needs: Self::Needs, _: &dyn StageContext) -> Result<Record> {
        let (Every(identified), Every(validated), Every(thrusts), Every(cells)) = needs;
        let mut found = Vec::new();
        for (specimen, one) in &identified {
            found.extend(
                of_identified(one).into_iter().map(|(what, value, unit)| finding(&specimen.0, what, value, unit)),
            );
        }
        for (trial, one) in &validated {
            found.extend(undamped(one).map(|v| finding(&trial.0, "undamped_rmse_increase_percent", v, "%")));
        }
        for (specimen, one) in &thrusts {
            found.extend(of_thrust(one).into_iter().map(|(what, v, unit)| finding(&specimen.0, what, v, unit)));
        }
        for (specimen, one) in &cells {
            let lowest = one.example.measured.iter().copied().fold(0.0, f64::min);
            found.push(finding(&specimen.0, "measured_minimum_over_noise", lowest / one.noise, ""));
        }
        Ok(Record { found })
    }
}

fn finding(of: &str, what: &str, value: f64, unit: &str) -> Finding {
    Finding { name: format!("{of}.{what}"), value, unit: unit.into() }
}

/// Minima are counted where profiles exist: a grid with two missing points in a row has none.
fn of_identified(found: &Identified) -> Vec<(&'static str, f64, &'static str)> {
    let levels = found.levels.iter().map(|level| (level.pressure(), level.largest_error()));
    let (pressures, errors): (Vec<f64>, Vec<f64>) = levels.unzip();
    let counted = found.profiles.iter().map(|p| minima(&p.chi_square)).max();
    let mut all = vec![
        ("landscape_minima", landscape_minima(&found.surface) as f64, ""),
        ("static_error_rank_correlation", correlation(&ranks(&pressures), &ranks(&errors)), ""),
    ];
    all.extend(counted.map(|count| ("minima", count as f64, "")));
    all
}

/// By how much the error grows when the relaxation, and with it all damping, is left out, % of the length.
fn undamped(validation: &Validation) -> Option<f64> {
    let way = validation.scored.iter().find(|way| way.name == "elastic")?;
    Some(100.0 * (way.rmse - validation.rmse) / validation.length)
}

/// Means are over the runs held out by the card; the share of negative force is that of the plotted run.
fn of_thrust(thrust: &Thrust) -> Vec<(&'static str, f64, &'static str)> {
    let sum = |of: fn(&crate::records::Means) -> f64| thrust.means.iter().map(of).sum::<f64>();
    let mut found = vec![("theory_over_measured", sum(|m| m.theory_n) / sum(|m| m.measured_n), "")];
    for trace in thrust.traces.iter().filter(|trace| !trace.training) {
        found.push(("theory_lowest_mn", 1e3 * trace.theory.iter().copied().fold(f64::INFINITY, f64::min), "mN"));
        found.push(("negative_share_percent", negative_share(&trace.measured), "%"));
    }
    found
}

/// The part of the impulse, without sign, that is negative, %.
fn negative_share(force: &[f64]) -> f64 {
    let all: f64 = force.iter().map(|f| f.abs()).sum();
    100.0 * force.iter().map(|f| (-f).max(0.0)).sum::<f64>() / all.max(f64::MIN_POSITIVE)
}

/// Minima of a profile, each separated from the next by a rise and a fall of more than [`RISE`]; a flat minimum counts once.
fn minima(chi_square: &[f64]) -> usize {
    let (mut count, mut falling, mut extreme) = (0, true, f64::INFINITY);
    for &value in chi_square {
        extreme = if falling { extreme.min(value) } else { extreme.max(value) };
        if (value - extreme).abs() > RISE {
            count += usize::from(falling);
            (falling, extreme) = (!falling, value);
        }
    }
    count + usize::from(falling)
}

/// Points of the landscape below all their neighbours, corners included; a narrow minimum between grid points gives several.
fn landscape_minima(surface: &Surface) -> usize {
    let (columns, rows) = (surface.body_e_pa.len(), surface.spine_e_pa.len());
    let loss = |row: usize, column: usize| surface.loss[row * columns + column];
    let around = |at: usize, len: usize| at.saturating_sub(1)..(at + 2).min(len);
    let lowest = |row: usize, column: usize| {
        let mut cells = around(row, rows).flat_map(|r| around(column, columns).map(move |c| (r, c)));
        cells.all(|(r, c)| (r, c) == (row, column) || loss(r, c) > loss(row, column))
    };
    (0..rows).map(|row| (0..columns).filter(|&column| lowest(row, column)).count()).sum()
}

/// Ranks in rising order; ties have the mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |v: f64| values.iter().filter(|w| **w < v).count() as f64;
    let same = |v: f64| values.iter().filter(|w| **w <= v).count() as f64 - below(v);
    values.iter().map(|&v| below(v) + 0.5 * (same(v) - 1.0)).collect()
}

/// Pearson's correlation; 0 where one of both is constant.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product =
        |x: &[f64], mx: f64, y: &[f64], my: f64| -> f64 { x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum() };
    let scale = (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt();
    if scale > 0.0 { product(a, ma, b, mb) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bowl_has_one_minimum_and_two_bowls_have_two() {
        let along = |f: fn(f64) -> f64| minima(&(0..41).map(|i| f(f64::from(i) / 20.0 - 1.0)).collect::<Vec<_>>());
        assert_eq!(along(|x| 100.0 * x * x), 1);
        assert_eq!(along(|x| 100.0 * (x * x - 0.4).powi(2)), 2);
    }

    #[test]
    fn a_landscape_of_one_bowl_has_one_lowest_point_and_of_two_bowls_two() {
        let axis: Vec<f64> = (0..9).map(|i| f64::from(i) / 8.0).collect();
        let count = |f: fn(f64, f64) -> f64| {
            let loss = axis.iter().flat_map(|y| axis.iter().map(|x| f(*x, *y)).collect::<Vec<_>>()).collect();
            landscape_minima(&Surface { body_e_pa: axis.clone(), spine_e_pa: axis.clone(), loss })
        };
        assert_eq!(count(|x, y| (x - 0.5).powi(2) + (y - 0.25).powi(2)), 1);
        assert_eq!(count(|x, y| (x * (x - 1.0)).powi(2) + (y - 0.25).powi(2)), 2);
    }

    #[test]
    fn ripples_in_a_valley_and_ends_of_a_slope_are_no_second_minimum() {
        let along = |f: fn(f64) -> f64| minima(&(0..41).map(|i| f(f64::from(i) / 20.0 - 1.0)).collect::<Vec<_>>());
        assert_eq!(along(|x| 100.0 * x * x + 0.3 * (40.0 * x).cos()), 1);
        assert_eq!((along(|x| 10.0 * x), along(|x| -10.0 * x), along(|_| 0.0)), (1, 1, 1));
    }

    #[test]
    fn what_rises_together_is_fully_correlated_in_rank() {
        let rank = |values: &[f64]| ranks(values);
        assert!((correlation(&rank(&[1.0, 2.0, 5.0]), &rank(&[0.1, 0.2, 9.0])) - 1.0).abs() < 1e-12);
        assert!((correlation(&rank(&[1.0, 2.0, 5.0]), &rank(&[3.0, 2.0, 1.0])) + 1.0).abs() < 1e-12);
        assert_eq!(rank(&[2.0, 2.0, 1.0]), [1.5, 1.5, 0.0]);
    }

    #[test]
    fn the_negative_share_of_a_force_is_that_of_its_impulse() {
        assert!((negative_share(&[3.0, -1.0]) - 25.0).abs() < 1e-12);
    }
}
