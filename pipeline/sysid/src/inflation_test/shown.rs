//! The results of an inflation test as text, table, metrics and figure.

use std::fmt;
use std::path::Path;

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};

use super::fits::Row;
use super::warnings::{no_fit, warnings};
use super::{JOINT, Report};
use crate::metrics_file;
use diagnostics::{Diagnostic, Result};

/// Writes `real_<name>.csv`, `real_<name>.svg` and the metrics into `folder`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub(super) fn write(report: &Report, folder: &Path) -> Result<()> {
    let stem = format!("real_{}", report.page.name);
    for (ending, text) in [("csv", csv_table(report)), ("svg", displacement_figure(report).svg()?)] {
        let path = folder.join(format!("{stem}.{ending}"));
        std::fs::write(&path, text).map_err(|e| Diagnostic::io(&path, e, "name another folder with --out"))?;
    }
    metrics_file::replace(folder, &report.page.name, metric_entries(report))
}

/// One number of a recording: name, unit, measured and predicted.
type Number = (&'static str, &'static str, f64, Option<f64>);

fn compared_numbers(report: &Report, row: &Row, k: usize) -> [Number; 3] {
    let (measured, predicted) = (report.recorded[k].features, row.predictions[k].features);
    [
        ("tip", "mm", 1e3 * measured.early, predicted.map(|f| 1e3 * f.early)),
        ("tip at the end of the hold", "mm", 1e3 * measured.late, predicted.map(|f| 1e3 * f.late)),
        ("creep over the hold", "%", 100.0 * measured.creep(), predicted.map(|f| 100.0 * f.creep())),
    ]
}

fn recording_names(report: &Report, used: &[usize]) -> String {
    used.iter().map(|k| report.page.recording[*k].name.as_str()).collect::<Vec<_>>().join(" + ")
}

fn csv_table(report: &Report) -> String {
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
    let mut text =
        "material,fitted,modulus_ratio,c20_over_c10,missing_mbar,wall_mm,recording,quantity,unit,measured,predicted,error\n"
            .to_owned();
    for row in &report.rows {
        let fit = |value: f64| if no_fit(report, row).is_some() { String::new() } else { format!("{value:.5}") };
        let head = format!(
            "\"{}\",{},{},{},{:.3},{}",
            row.name,
            recording_names(report, &row.used),
            fit(row.modulus_ratio),
            fit(row.material.stiffening[0]),
            1e-2 * row.missing,
            word(row.wall.map(|wall| 1e3 * wall))
        );
        for (k, recording) in report.page.recording.iter().enumerate() {
            for (quantity, unit, measured, predicted) in compared_numbers(report, row, k) {
                // of a displacement in per cent, of creep in points
                let error =
                    predicted.map(
                        |predicted| if unit == "%" { predicted - measured } else { error_percent(predicted, measured) },
                    );
                let name = &recording.name;
                let [measured, predicted, error] = [Some(measured), predicted, error].map(word);
                text += &format!("{head},{name},{quantity},{unit},{measured},{predicted},{error}\n");
            }
        }
    }
    for (k, recording) in report.page.recording.iter().enumerate() {
        let wall = word(report.explaining_wall(k).map(|wall| 1e3 * wall));
        text += &format!(",,,,,,{},wall that explains the tip,mm,,{wall},\n", recording.name);
    }
    warnings(report).iter().for_each(|warning| text += &format!("\"warning: {warning}\",,,,,,,,,,,\n"));
    text
}

fn error_percent(predicted: f64, measured: f64) -> f64 {
    100.0 * (predicted / measured - 1.0)
}

/// Absolute errors at the recordings to which the modulus alone was not fitted: of modulus and stiffening fitted to the others
/// (`tip_error_percent`), of what is missing of the pressure fitted as well, of the modulus fitted alone, and of the material as it was
/// identified elsewhere. Creep is that of the row with most parameters.
fn metric_entries(report: &Report) -> Vec<serde_json::Value> {
    let mut entries = Vec::new();
    let alone = report.rows.iter().position(|row| row.name == "modulus fitted");
    let fit = |row: usize| no_fit(report, &report.rows[row]).is_none();
    for (k, left_out) in report.left_out.iter().enumerate() {
        let stem = format!("real.{}.{}", report.page.name, report.page.recording[k].name);
        let kinds = [
            ("tip", left_out.first().copied()),
            ("tip_with_missing_pressure", left_out.get(1).copied()),
            ("tip_with_modulus_alone", alone),
            ("tip_with_supported_law", Some(0)),
        ];
        for (kind, row) in kinds.into_iter().filter(|(_, row)| !left_out.is_empty() && row.is_some()) {
            let tip = row.filter(|row| fit(*row)).map(|row| compared_numbers(report, &report.rows[row], k)[0]);
            let error = tip.and_then(|(_, _, measured, predicted)| Some(error_percent(predicted?, measured).abs()));
            entries.push(metrics_file::entry(&format!("{stem}.{kind}_error_percent"), error, "%"));
        }
        let creep = left_out
            .last()
            .copied()
            .or(alone)
            .filter(|row| fit(*row))
            .map(|row| compared_numbers(report, &report.rows[row], k)[2]);
        let points = creep.and_then(|(_, _, measured, predicted)| Some((predicted? - measured).abs()));
        entries.push(metrics_file::entry(&format!("{stem}.creep_error_points"), points, "%"));
    }
    entries
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in &self.rows {
            let fitted =
                if row.used.is_empty() { String::new() } else { format!(" to {}", recording_names(self, &row.used)) };
            let wall = row.wall.map_or_else(String::new, |wall| format!(", walls {:.2} mm", 1e3 * wall));
            let missing = match row.missing {
                0.0 => String::new(),
                missing => format!(", {:.1} mbar missing at first", 1e-2 * missing),
            };
            let (ratio, [c20, _]) = (row.modulus_ratio, row.material.stiffening);
            match no_fit(self, row) {
                Some(_) => writeln!(f, "{}{fitted}: no fit{wall}", row.name)?,
                None => writeln!(f, "{}{fitted}: modulus × {ratio:.3}, C20/C10 {c20:.3}{missing}{wall}", row.name)?,
            }
            for k in 0..self.recorded.len() {
                write_prediction(f, self, (row, k))?;
            }
        }
        for (k, recording) in self.page.recording.iter().enumerate() {
            let wall =
                self.explaining_wall(k).map_or("no wall that was tried".to_owned(), |w| format!("{:.2} mm", 1e3 * w));
            writeln!(f, "walls that explain the tip at {}: {wall}", recording.name)?;
        }
        warnings(self).iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}

fn write_prediction(f: &mut fmt::Formatter<'_>, report: &Report, (row, k): (&Row, usize)) -> fmt::Result {
    let role = if row.used.contains(&k) { "fitted" } else { "predicted" };
    write!(f, "    {:<9} {role:<9}", report.page.recording[k].name)?;
    if let Some(burst) = &row.predictions[k].course.burst {
        return writeln!(f, "  the wall balloons without bound: {}", burst.lines().next().unwrap_or_default());
    }
    for (quantity, unit, measured, predicted) in compared_numbers(report, row, k) {
        let predicted = predicted.unwrap_or(f64::NAN);
        if !predicted.is_finite() {
            write!(f, "  {quantity} not predicted ({measured:.2})")?;
            continue;
        }
        let error = if unit == "%" { String::new() } else { format!(", {:+.1} %", error_percent(predicted, measured)) };
        write!(f, "  {quantity} {predicted:.2} {unit} ({measured:.2}{error})")?;
    }
    writeln!(f)
}

/// Recorded and predicted displacement over time: the material's source as it is, the modulus fitted, and the recording left out.
fn displacement_figure(report: &Report) -> Figure {
    let by_name = |name: &str| report.rows.iter().position(|row| row.name == name);
    let untouched = report.rows.iter().rposition(|row| row.used.is_empty() && row.wall == report.rows[0].wall);
    let panel = |k: usize| {
        let tip = &report.recorded[k].tip;
        let recorded = tip.values().iter().enumerate().map(|(i, u)| [tip.time(i), 1e3 * u]).collect();
        let axes = Axes::new(Axis::linear("time after the step", "s"), Axis::linear("tip", "mm"));
        let axes = axes.with(Mark::line(recorded, palette::MUTED).labelled("recorded"));
        let joint = |fit: usize| report.left_out[k].get(fit).copied().or_else(|| by_name(JOINT[fit].1));
        let rows = [
            (untouched, palette::SPINE, "identified on the bar"),
            (by_name("modulus fitted"), palette::MEASURED, "modulus fitted"),
            (joint(0), palette::SIMULATED, "modulus and stiffening fitted"),
            (joint(1), palette::PRESSURE, "and missing pressure fitted"),
        ];
        let marks = rows.into_iter().filter_map(|(row, colour, label)| {
            let row = report.rows.get(row?).filter(|row| no_fit(report, row).is_none())?;
            let course = &row.predictions[k].course;
            let line = course.tip.iter().map(|(time, u)| [*time, 1e3 * u]).collect();
            Some(Mark::line(line, colour).dashed(Dash::Dashed).labelled(label))
        });
        Panel::Axes(marks.fold(axes, Axes::with)).titled(&report.page.recording[k].name)
    };
    let mut figure = Figure::new(DOUBLE_COLUMN_MM);
    let mut panels = (0..report.recorded.len()).map(panel).peekable();
    while panels.peek().is_some() {
        figure = figure.row(55.0, panels.by_ref().take(3).collect::<Vec<_>>());
    }
    figure.noted("measured data, not from the virtual bench")
}
