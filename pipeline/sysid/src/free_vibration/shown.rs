//! The results of a page as text, table, metrics and figure.

use std::fmt;
use std::path::Path;

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};
use si::{Second, Series};

use super::Report;
use super::features::{NAMES, best_shift};
use super::ladder::{LawResult, Row, supported_law};
use super::warnings::warnings;
use crate::identified_materials::{IdentifiedMaterial, IdentifiedMaterials, file_of};
use crate::metrics_file;
use diagnostics::{Diagnostic, Result};

/// Writes `real_<name>.csv`, `real_<name>.svg`, `real_<name>_materials.toml` and `metrics.json` into `folder`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub(super) fn write(report: &Report, folder: &Path) -> Result<()> {
    let figure = fall_figure(report).svg()?;
    let stem = format!("real_{}", report.page.name);
    let materials = materials_text(report)?;
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text);
    std::fs::create_dir_all(folder)
        .and_then(|()| write(&format!("{stem}.csv"), &csv_table(report)))
        .and_then(|()| write(&format!("{stem}.svg"), &figure))
        .and_then(|()| write(&file_of(&report.page.name), &materials))
        .map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", folder.display()), e, "name another folder with --out")
        })?;
    metrics_file::replace(folder, &report.page.name, metric_entries(report))
}

/// The joint fits of all laws, for other tests of the same material.
fn materials_text(report: &Report) -> Result<String> {
    let material = |result: &LawResult| -> Result<IdentifiedMaterial> {
        let fitted = &result.joint.fitted;
        let properties = fitted.law.properties(&fitted.values, report.page.modulus_time)?;
        Ok(IdentifiedMaterial {
            name: fitted.law.name.to_owned(),
            material: "yeoh".to_owned(),
            youngs_modulus: properties.youngs_modulus,
            stiffening: properties.stiffening,
            mass_damping: properties.mass_damping,
            stiffness_damping: properties.stiffness_damping,
            branch: properties.relaxation.branches().iter().map(|branch| [branch.strength, branch.time]).collect(),
        })
    };
    let law = report.results.iter().map(material).collect::<Result<_>>()?;
    let supported = report.results[supported_law(&report.results)].joint.fitted.law.name.to_owned();
    let written = toml::to_string(&IdentifiedMaterials { supported, law });
    written.map_err(|e| Diagnostic::new("the identified materials cannot be written", e, "report this as a bug"))
}

/// One number of the table.
struct Line {
    law: String,
    fitted: String,
    recording: String,
    quantity: String,
    unit: String,
    measured: Option<f64>,
    value: f64,
    half_width: Option<f64>,
}

impl Line {
    fn error_percent(&self) -> Option<f64> {
        self.measured.map(|measured| 100.0 * (self.value / measured - 1.0))
    }
}

fn table_lines(report: &Report) -> Vec<Line> {
    let of_result = |result: &LawResult| {
        let rows = std::iter::once(&result.joint).chain(&result.left_out);
        let mut lines: Vec<Line> = rows
            .flat_map(|row| parameter_lines(report, row).into_iter().chain(prediction_lines(report, row)))
            .collect();
        lines.extend(quality_lines(report, result));
        lines
    };
    report.results.iter().flat_map(of_result).collect()
}

fn recording_names(report: &Report, used: &[usize]) -> String {
    used.iter().map(|k| report.page.recording[*k].name()).collect::<Vec<_>>().join(" + ")
}

fn parameter_lines(report: &Report, row: &Row) -> Vec<Line> {
    let fitted = &row.fitted;
    let parameter_line = |(p, quantity): (usize, &super::laws::Quantity)| {
        let scale = quantity.scale(report.page.range);
        let sigma = fitted.covariance[(p, p)].sqrt();
        let half_width = 1.96 * if scale.logarithmic { fitted.values[p] * sigma } else { sigma };
        Line {
            law: fitted.law.name.to_owned(),
            fitted: recording_names(report, &row.used),
            recording: String::new(),
            quantity: scale.name.to_owned(),
            unit: scale.unit.to_owned(),
            measured: None,
            value: fitted.values[p],
            half_width: Some(half_width),
        }
    };
    fitted.law.parameters.iter().enumerate().map(parameter_line).collect()
}

fn prediction_lines(report: &Report, row: &Row) -> Vec<Line> {
    let recording_lines = |k: usize| {
        let (measured, prediction) = (report.measured[k].to_array(), &row.predictions[k]);
        let value = prediction.features.to_array();
        let line = |n: usize| Line {
            law: row.fitted.law.name.to_owned(),
            fitted: recording_names(report, &row.used),
            recording: report.page.recording[k].name().to_owned(),
            quantity: NAMES[n].0.to_owned(),
            unit: NAMES[n].1.to_owned(),
            measured: Some(measured[n]),
            value: value[n],
            half_width: Some(prediction.half_widths[n]),
        };
        [0, 1, 2, 3].map(line)
    };
    (0..report.recorded.len()).flat_map(recording_lines).collect()
}

fn quality_lines(report: &Report, result: &LawResult) -> Vec<Line> {
    let fitted = &result.joint.fitted;
    let line = |quantity: &str, unit: &str, value: f64| Line {
        law: fitted.law.name.to_owned(),
        fitted: recording_names(report, &result.joint.used),
        recording: String::new(),
        quantity: quantity.to_owned(),
        unit: unit.to_owned(),
        measured: None,
        value,
        half_width: None,
    };
    let mut lines = vec![
        line("discrepancy", "% of the static deflection", 100.0 * fitted.discrepancy),
        line("correlation time of the discrepancy", "s", fitted.correlation_time),
        line("information criterion over the best", "", result.criterion),
    ];
    lines.extend(
        result.left_out_difference().map(|d| line("difference when left out", "% of the static deflection", 100.0 * d)),
    );
    lines
}

fn csv_table(report: &Report) -> String {
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
    let mut text = "law,fitted,recording,quantity,unit,measured,value,half_width_95,error_percent\n".to_owned();
    for line in table_lines(report) {
        let Line { law, fitted, recording, quantity, unit, .. } = &line;
        text += &format!(
            "{law},{fitted},{recording},{quantity},{unit},{},{},{},{}\n",
            word(line.measured),
            word(Some(line.value)),
            word(line.half_width),
            word(line.error_percent())
        );
    }
    warnings(report).iter().for_each(|warning| text += &format!(",,,\"warning: {warning}\",,,,,\n"));
    text
}

/// Errors of the supported law at the recordings that were not fitted.
fn metric_entries(report: &Report) -> Vec<serde_json::Value> {
    let result = &report.results[supported_law(&report.results)];
    let mut entries = Vec::new();
    for (k, recording) in report.page.recording.iter().enumerate().filter(|(_, recording)| !recording.fitted) {
        let (measured, value) = (report.measured[k].to_array(), result.joint.predictions[k].features.to_array());
        for n in 0..4 {
            let id = format!("real.{}.{}.{}_error_percent", report.page.name, recording.name(), NAMES[n].0);
            let error = 100.0 * (value[n] / measured[n] - 1.0).abs();
            entries.push(metrics_file::entry(&id, Some(error), "%"));
        }
    }
    entries
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for result in &self.results {
            let fitted = &result.joint.fitted;
            writeln!(f, "{} fitted to {}", fitted.law.name, recording_names(self, &result.joint.used))?;
            for line in parameter_lines(self, &result.joint) {
                let Line { quantity, unit, value, half_width, .. } = line;
                writeln!(f, "  {quantity:<22} {value:>12.5} ± {:.5} {unit}", half_width.unwrap_or_default())?;
            }
            let left_out =
                result.left_out_difference().map_or_else(String::new, |d| format!(", {:.2} % left out", 100.0 * d));
            writeln!(
                f,
                "  discrepancy {:.2} % of the static deflection{left_out}; information criterion + {:.1}",
                100.0 * fitted.discrepancy,
                result.criterion
            )?;
            for row in std::iter::once(&result.joint).chain(&result.left_out) {
                write_predictions(f, self, row)?;
            }
        }
        writeln!(f, "supported: {}", self.results[supported_law(&self.results)].joint.fitted.law.name)?;
        warnings(self).iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        let published = self.page.published.iter();
        published
            .into_iter()
            .try_for_each(|p| writeln!(f, "published: {:.1} kPa, {}", 1e-3 * p.youngs_modulus, p.source))
    }
}

fn write_predictions(f: &mut fmt::Formatter<'_>, report: &Report, row: &Row) -> fmt::Result {
    for (k, prediction) in row.predictions.iter().enumerate() {
        let role = if row.used.contains(&k) { "fitted" } else { "predicted" };
        write!(
            f,
            "    {:<12} {role:<9} from {:<22}",
            report.page.recording[k].name(),
            recording_names(report, &row.used)
        )?;
        let (measured, value) = (report.measured[k].to_array(), prediction.features.to_array());
        for n in 0..4 {
            let covered = (value[n] - measured[n]).abs() <= prediction.half_widths[n];
            write!(
                f,
                "  {} {:+.1} %{}",
                NAMES[n].0,
                100.0 * (value[n] / measured[n] - 1.0),
                if covered { "" } else { "!" }
            )?;
        }
        writeln!(f)?;
    }
    Ok(())
}

fn fall_figure(report: &Report) -> Figure {
    let window = report.page.swing[1];
    let points = |fall: &Series, shift: Second| {
        let curve = fall.values().iter().enumerate().map(|(i, v)| [fall.time(i) + shift, 1e3 * v]);
        curve.skip_while(|p| p[0] < 0.0).take_while(|p| p[0] <= window).collect::<Vec<_>>()
    };
    let shown = [(0, palette::SPINE), (supported_law(&report.results), palette::SIMULATED)];
    let panel = |k: usize| {
        let axes = Axes::new(Axis::linear("time after the release", "s"), Axis::linear("displacement", "mm"));
        let axes = axes.with(Mark::line(points(&report.recorded[k].fall, 0.0), palette::MUTED).labelled("recorded"));
        let laws = shown.iter().map(|(result, colour)| {
            let row = &report.results[*result].joint;
            let name = row.fitted.law.name.replace('_', " ");
            // the time of the release is fitted with the law, or read off by eye
            let (shift, _) = best_shift(&row.predictions[k].fall, &report.recorded[k].fall);
            Mark::line(points(&row.predictions[k].fall, shift), *colour).dashed(Dash::Dashed).labelled(&name)
        });
        let recording = &report.page.recording[k];
        let role = if recording.fitted { "fitted" } else { "predicted" };
        let title = format!("{}, {role}", recording.name().replace('_', " "));
        Panel::Axes(laws.fold(axes, Axes::with)).titled(&title)
    };
    let panels: Vec<_> = (0..report.recorded.len()).map(panel).collect();
    let mut figure = Figure::new(DOUBLE_COLUMN_MM);
    let mut remaining = panels.into_iter().peekable();
    while remaining.peek().is_some() {
        figure = figure.row(55.0, remaining.by_ref().take(2).collect::<Vec<_>>());
    }
    figure.noted("measured data, not from the virtual bench; predictions are aligned in time")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_vibration::testing;

    /// The line of the table that begins so.
    fn line<'a>(table: &'a str, start: &str) -> &'a str {
        table.lines().find_map(|line| line.strip_prefix(start)).unwrap_or("is not there")
    }

    #[test]
    fn the_table_holds_every_fit_with_its_parameters_predictions_and_quality() {
        let table = csv_table(&testing::report());
        // 95 % within 1.96 deviations: 2 % of 100 kPa, 120 % of 2 ms, and 0.25 of a parameter that may be negative
        assert_eq!(line(&table, "elastic_beta,a + c,,youngs_modulus,"), "Pa,,100000.00000,3920.00000,");
        assert_eq!(line(&table, "elastic_beta,c,,stiffness_damping,"), "s,,0.00200,0.00470,");
        assert_eq!(line(&table, "springpot_yeoh,a,,c20_over_c10,"), ",,-0.50000,0.49000,");
        // 8.4 Hz are 5 % more than 8 Hz and 20 % more than 7 Hz
        assert_eq!(line(&table, "elastic_beta,a + c,a,frequency,"), "Hz,8.00000,8.40000,0.50000,5.00000");
        assert_eq!(line(&table, "springpot_yeoh,c,b,frequency,"), "Hz,7.00000,8.40000,0.50000,20.00000");
        assert_eq!(line(&table, "elastic_beta,a + c,c,static,"), "mm,-10.00000,-10.00000,0.25000,0.00000");
        assert_eq!(line(&table, "elastic_beta,a + c,,discrepancy,"), "% of the static deflection,,2.00000,,");
        assert_eq!(line(&table, "elastic_beta,a + c,,information criterion over the best,"), ",,7.25000,,");
        // the root mean square of 3 % and 4 %
        let left_out = line(&table, "elastic_beta,a + c,,difference when left out,");
        assert_eq!(left_out, "% of the static deflection,,3.53553,,");
        // each law: three fits with their parameters and twelve features, and four lines of quality; then the warnings
        assert_eq!(table.lines().count(), 1 + (3 * (2 + 12) + 4) + (3 * (4 + 12) + 4) + 4);
        assert_eq!(table.lines().filter(|line| line.starts_with(",,,\"warning: ")).count(), 4);
    }

    #[test]
    fn the_metrics_are_the_errors_of_the_supported_law_at_what_was_not_fitted() {
        let metrics = metric_entries(&testing::report());
        let found: Vec<_> = metrics.iter().map(|m| (m["id"].as_str().unwrap(), m["value"].as_f64().unwrap())).collect();
        let names = ["frequency", "static", "first_minimum", "decay"];
        for ((id, value), (name, should)) in found.iter().zip(names.iter().zip([20.0, 0.0, 0.0, 0.0])) {
            assert_eq!(*id, format!("real.bar.b.{name}_error_percent"));
            assert!((value - should).abs() < 1e-9, "{id} {value}");
        }
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn the_text_marks_what_lies_outside_its_interval() {
        let text = testing::report().to_string();
        let lines: Vec<String> = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        let rest = "static +0.0 % first_minimum +0.0 % decay +0.0 %";
        let should = [
            "elastic_beta fitted to a + c".to_owned(),
            "youngs_modulus 100000.00000 ± 3920.00000 Pa".to_owned(),
            "discrepancy 2.00 % of the static deflection, 3.54 % left out; information criterion + 7.2".to_owned(),
            format!("a fitted from a + c frequency +5.0 % {rest}"),
            format!("b predicted from a + c frequency +20.0 %! {rest}"),
            format!("a predicted from c frequency +5.0 % {rest}"),
            format!("c fitted from c frequency -6.7 %! {rest}"),
            "supported: springpot_yeoh".to_owned(),
            "published: 150.0 kPa, a book".to_owned(),
        ];
        for line in should {
            assert!(lines.contains(&line), "{line} is not in\n{text}");
        }
    }

    #[test]
    fn the_figure_has_a_panel_for_each_recording_in_mm() {
        let figure = fall_figure(&testing::report()).svg().unwrap();
        for word in ["a, fitted", "b, predicted", "c, fitted", "displacement", "elastic beta", "springpot yeoh"] {
            assert!(figure.contains(word), "{word}");
        }
        // −16 mm at first
        assert!(figure.contains("−15") && !figure.contains("−20"), "{figure}");
    }
}
