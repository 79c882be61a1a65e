//! The scoreboard: every condition as a law predicts it, left out where it is fitted otherwise.

use super::Report;
use super::fit::Which;
use super::ladder::{LawResult, Prediction};
use super::test::Condition;

/// One number of the scoreboard.
pub(super) struct Line {
    pub condition: String,
    pub quantity: String,
    pub unit: &'static str,
    /// `left out`, `fitted` or `held out`.
    pub role: &'static str,
    pub recorded: Option<f64>,
    /// With the half width of its interval; none with the cause.
    pub predicted: std::result::Result<(f64, f64), String>,
    pub extrapolated: bool,
    /// In proportion to the level, from the conditions of the same test that were fitted.
    pub linear: Option<f64>,
}

impl Line {
    pub(super) fn error_percent(&self) -> Option<f64> {
        let (value, _) = self.predicted.as_ref().ok()?;
        Some(100.0 * (value / self.recorded? - 1.0))
    }

    pub fn is_inside(&self) -> Option<bool> {
        let (value, width) = self.predicted.as_ref().ok()?;
        Some((value - self.recorded?).abs() <= *width)
    }
}

/// Whether a level lies beyond those of the other conditions of its test that are fitted; and the quantity `n` in proportion to the level.
fn beyond_and_linear(report: &Report, used: &[Which], which: Which, n: usize) -> (bool, Option<f64>) {
    let (t, c) = which;
    let conditions = report.tests[t].conditions();
    let fitted_conditions: Vec<&Condition> =
        used.iter().filter(|which| which.0 == t && which.1 != c).map(|which| &conditions[which.1]).collect();
    let level = conditions[c].level;
    // a condition that is fitted alone lies within itself
    let is_alone = fitted_conditions.is_empty() && used.contains(&which);
    let is_beyond = !is_alone
        && (fitted_conditions.iter().all(|other| other.level < level)
            || fitted_conditions.iter().all(|other| other.level > level));
    let pairs: Vec<(f64, f64)> =
        fitted_conditions.iter().filter_map(|other| Some((other.level, other.quantities.get(n)?.measured?))).collect();
    let products: f64 = pairs.iter().map(|(level, value)| level * value).sum();
    let squares: f64 = pairs.iter().map(|(level, _)| level * level).sum();
    (is_beyond, (squares > 0.0).then(|| level * products / squares))
}

/// Every condition as `result` predicts it: left out where it is fitted otherwise.
pub(super) fn condition_lines(report: &Report, result: &LawResult) -> Vec<Line> {
    let used = &result.used;
    let mut lines = Vec::new();
    for (t, test) in report.tests.iter().enumerate() {
        for (c, condition) in test.conditions().iter().enumerate() {
            let left_out = result.left_out.iter().find(|(which, _)| *which == (t, c));
            let (role, prediction): (_, &Prediction) = match left_out {
                Some((_, prediction)) => ("left out", prediction),
                None if used.contains(&(t, c)) => ("fitted", &result.all[t][c]),
                None => ("held out", &result.all[t][c]),
            };
            for (n, quantity) in condition.quantities.iter().enumerate() {
                let (beyond, linear) = beyond_and_linear(report, used, (t, c), n);
                let predicted =
                    prediction.as_ref().map(|values| (values[n].0.value, values[n].1)).map_err(String::clone);
                lines.push(Line {
                    condition: condition.name.clone(),
                    quantity: quantity.name.clone(),
                    unit: quantity.unit,
                    role,
                    recorded: quantity.measured,
                    predicted,
                    extrapolated: beyond,
                    linear: linear.filter(|_| quantity.name.starts_with("tip")),
                });
            }
        }
    }
    lines
}

/// What the neo-Hookean law says, where it was fitted.
pub(super) fn plain_lines(report: &Report) -> Option<Vec<Line>> {
    let plain = report.results.iter().find(|result| result.law.terms.is_empty())?;
    Some(condition_lines(report, plain))
}

/// The share of the intervals of all conditions that were not fitted that hold what was recorded, %; none where none was recorded.
pub(super) fn share_inside(lines: &[Line]) -> Option<f64> {
    let inside: Vec<bool> = lines.iter().filter(|line| line.role != "fitted").filter_map(Line::is_inside).collect();
    let held = inside.iter().filter(|inside| **inside).count();
    (!inside.is_empty()).then(|| 100.0 * held as f64 / inside.len() as f64)
}
