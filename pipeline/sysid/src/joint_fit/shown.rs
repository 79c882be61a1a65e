//! The results of a joint fit as text, tables, metrics and materials.

use std::fmt;
use std::path::Path;

use super::Report;
use super::fit::{Fit, Which};
use super::ladder::{LawResult, Prediction, supported_law};
use super::test::Condition;
use crate::identified_materials::{IdentifiedMaterial, IdentifiedMaterials, file_of};
use crate::metrics_file;
use diagnostics::{Diagnostic, Result};

/// Writes the scoreboard `real_<name>.csv`, the parameters `real_<name>_parameters.csv`, the materials and the metrics into `folder`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub(super) fn write(report: &Report, folder: &Path) -> Result<()> {
    let stem = format!("real_{}", report.page.name);
    let materials = materials_text(report)?;
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text);
    std::fs::create_dir_all(folder)
        .and_then(|()| write(&format!("{stem}.csv"), &scoreboard_csv(report)))
        .and_then(|()| write(&format!("{stem}_parameters.csv"), &parameter_table(report)))
        .and_then(|()| write(&file_of(&report.page.name), &materials))
        .map_err(|e| Diagnostic::io(folder, e, "name another folder with --out"))?;
    metrics_file::replace(folder, &report.page.name, metric_entries(report))
}

/// One number of the scoreboard.
pub(super) struct Line {
    condition: String,
    quantity: String,
    unit: &'static str,
    /// `left out`, `fitted` or `held out`.
    role: &'static str,
    recorded: Option<f64>,
    /// With the half width of its interval; none with the cause.
    predicted: std::result::Result<(f64, f64), String>,
    extrapolated: bool,
    /// In proportion to the level, from the conditions of the same test that were fitted.
    linear: Option<f64>,
}

impl Line {
    fn error_percent(&self) -> Option<f64> {
        let (value, _) = self.predicted.as_ref().ok()?;
        Some(100.0 * (value / self.recorded? - 1.0))
    }

    fn is_inside(&self) -> Option<bool> {
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

/// Condition left out × predicted × interval × recorded × the same by the neo-Hookean law and in proportion to the pressure, of every law.
fn scoreboard_csv(report: &Report) -> String {
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.4}"));
    let mut text = "law,supported,condition,role,quantity,unit,recorded,predicted,half_width_95,error_percent,inside,extrapolated,neo_hookean,linear_in_pressure,gap\n".to_owned();
    let best = supported_law(&report.results, &report.tests);
    let plain =
        report.results.iter().find(|result| result.law.terms.is_empty()).map(|result| condition_lines(report, result));
    for (k, result) in report.results.iter().enumerate() {
        for (i, line) in condition_lines(report, result).iter().enumerate() {
            let (value, width) =
                line.predicted.as_ref().map_or((None, None), |(value, width)| (Some(*value), Some(*width)));
            let plain = plain.as_ref().and_then(|plain| plain[i].predicted.as_ref().ok()).map(|(value, _)| *value);
            let inside = line.is_inside().map_or("", |inside| if inside { "yes" } else { "no" });
            let gap = line.predicted.as_ref().err().and_then(|cause| cause.lines().next()).unwrap_or_default();
            text += &format!(
                "{},{},\"{}\",{},\"{}\",{},{},{},{},{},{inside},{},{},{},\"{}\"\n",
                result.law.name,
                if best == Some(k) { "yes" } else { "" },
                line.condition,
                line.role,
                line.quantity,
                line.unit,
                word(line.recorded),
                word(value),
                word(width),
                word(line.error_percent()),
                if line.extrapolated { "yes" } else { "" },
                word(plain),
                word(line.linear),
                gap.replace('"', "'"),
            );
        }
    }
    text
}

fn parameter_table(report: &Report) -> String {
    let mut text = "law,parameter,unit,value,deviation,on_bound\n".to_owned();
    for result in &report.results {
        let fit = Fit { law: result.law, tests: &report.tests };
        for (p, parameter) in fit.parameters().iter().enumerate() {
            let coordinate = result.joint.point[p];
            let deviation = parameter.deviation(coordinate, result.joint.covariance[(p, p)].sqrt());
            let bound = if parameter.is_on_bound(coordinate) { "yes" } else { "" };
            let (name, unit) = (&parameter.name, parameter.unit);
            text += &format!(
                "{},\"{name}\",{unit},{:.6},{deviation:.6},{bound}\n",
                result.law.name,
                parameter.value(coordinate)
            );
        }
        for (test, scale) in report.tests.iter().zip(&result.joint.scales) {
            text += &format!("{},\"factor of the deviations of {}\",,{scale:.4},,\n", result.law.name, test.name());
        }
    }
    text
}

fn materials_text(report: &Report) -> Result<String> {
    let material = |result: &LawResult| -> Result<IdentifiedMaterial> {
        let constants = result.law.constants(&result.joint.point)?;
        Ok(IdentifiedMaterial {
            name: result.law.name.to_owned(),
            material: result.law.material.to_owned(),
            youngs_modulus: constants.youngs_modulus,
            stiffening: constants.stiffening,
            mass_damping: constants.mass_damping,
            stiffness_damping: 0.0,
            branch: constants.relaxation.branches().iter().map(|branch| [branch.strength, branch.time]).collect(),
        })
    };
    let law = report.results.iter().map(material).collect::<Result<_>>()?;
    let best = supported_law(&report.results, &report.tests).unwrap_or_default();
    let materials = IdentifiedMaterials { supported: report.results[best].law.name.to_owned(), law };
    let text = toml::to_string(&materials);
    text.map_err(|e| Diagnostic::new("the identified materials cannot be written", e, "report this as a bug"))
}

/// Absolute errors of the supported law at every condition that was left out or held out, and the share of its intervals that hold.
fn metric_entries(report: &Report) -> Vec<serde_json::Value> {
    let Some(best) = supported_law(&report.results, &report.tests) else { return Vec::new() };
    let lines = condition_lines(report, &report.results[best]);
    let key = |text: &str| text.to_lowercase().replace([' ', '%'], "_");
    let error = |line: &Line| {
        let id = format!("real.{}.{}.{}_error_percent", report.page.name, key(&line.condition), key(&line.quantity));
        metrics_file::entry(&id, line.error_percent().map(f64::abs), "%")
    };
    let mut entries: Vec<_> = lines.iter().filter(|line| line.recorded.is_some()).map(error).collect();
    let inside: Vec<bool> = lines.iter().filter_map(Line::is_inside).collect();
    let share = 100.0 * inside.iter().filter(|inside| **inside).count() as f64 / inside.len().max(1) as f64;
    entries.push(metrics_file::entry(&format!("real.{}.inside_percent", report.page.name), Some(share), "%"));
    entries
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let best = supported_law(&self.results, &self.tests);
        for (k, result) in self.results.iter().enumerate() {
            let mark = if best == Some(k) { ", supported" } else { "" };
            writeln!(
                f,
                "{}{mark}: loss {:.2}, factors of the deviations {:.2?}",
                result.law.name, result.joint.loss, result.joint.scales
            )?;
            write_parameters(f, self, result)?;
            condition_lines(self, result).iter().try_for_each(|line| write_line(f, line))?;
        }
        self.refused.iter().try_for_each(|(law, cause)| writeln!(f, "warning: {law} is left out: {cause}"))?;
        match best {
            None => writeln!(f, "warning: no law predicts every condition that was left out: none is supported"),
            Some(_) => Ok(()),
        }
    }
}

fn write_parameters(f: &mut fmt::Formatter<'_>, report: &Report, result: &LawResult) -> fmt::Result {
    let fit = Fit { law: result.law, tests: &report.tests };
    for (p, parameter) in fit.parameters().iter().enumerate() {
        let coordinate = result.joint.point[p];
        let deviation = parameter.deviation(coordinate, result.joint.covariance[(p, p)].sqrt());
        let bound = if parameter.is_on_bound(coordinate) { ", on the end of its range: not identified" } else { "" };
        let (name, unit, value) = (&parameter.name, parameter.unit, parameter.value(coordinate));
        writeln!(f, "    {name} {value:.5} ± {deviation:.5} {unit}{bound}")?;
    }
    Ok(())
}

fn write_line(f: &mut fmt::Formatter<'_>, line: &Line) -> fmt::Result {
    write!(f, "    {:<18} {:<9} {:<28}", line.condition, line.role, line.quantity)?;
    match &line.predicted {
        Err(cause) => write!(f, " not predicted: {}", cause.lines().next().unwrap_or_default())?,
        Ok((value, width)) => write!(f, " {value:.3} ± {width:.3} {}", line.unit)?,
    }
    if let (Some(recorded), Some(error)) = (line.recorded, line.error_percent()) {
        let outside = if line.is_inside() == Some(false) { ", outside" } else { "" };
        write!(f, " ({recorded:.3}, {error:+.1} %{outside})")?;
    }
    writeln!(f, "{}", if line.extrapolated { ", extrapolated" } else { "" })
}
