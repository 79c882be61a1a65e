//! The results of a joint fit as text, tables, metrics and materials.

use std::fmt;
use std::path::Path;

use super::Report;
use super::figure::scoreboard_figure;
use super::fit::Fit;
use super::ladder::{LawResult, supported_law};
use super::scoreboard::{Line, condition_lines, plain_lines, share_inside};
use crate::identified_materials::{IdentifiedMaterial, IdentifiedMaterials, file_of};
use crate::metrics_file;
use diagnostics::{Diagnostic, Result};

/// Writes the scoreboard `real_<name>.csv` and `.svg`, the parameters `real_<name>_parameters.csv`, the materials and the metrics into `folder`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub(super) fn write(report: &Report, folder: &Path) -> Result<()> {
    let stem = format!("real_{}", report.page.name);
    let materials = materials_text(report)?;
    let figure = scoreboard_figure(report).map(|figure| figure.svg()).transpose()?;
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text);
    std::fs::create_dir_all(folder)
        .and_then(|()| write(&format!("{stem}.csv"), &scoreboard_csv(report)))
        .and_then(|()| write(&format!("{stem}_parameters.csv"), &parameter_table(report)))
        .and_then(|()| write(&file_of(&report.page.name), &materials))
        .and_then(|()| figure.map_or(Ok(()), |figure| write(&format!("{stem}.svg"), &figure)))
        .map_err(|e| Diagnostic::io(folder, e, "name another folder with --out"))?;
    metrics_file::replace(folder, &report.page.name, metric_entries(report))
}

/// Condition left out × predicted × interval × recorded × the same by the neo-Hookean law and in proportion to the pressure, of every law.
fn scoreboard_csv(report: &Report) -> String {
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.4}"));
    let mut text = "law,supported,condition,role,quantity,unit,recorded,predicted,half_width_95,error_percent,inside,extrapolated,neo_hookean,linear_in_pressure,gap\n".to_owned();
    let best = supported_law(&report.results, &report.tests);
    let plain = plain_lines(report);
    for (k, result) in report.results.iter().enumerate() {
        let lines = condition_lines(report, result);
        for (i, line) in lines.iter().enumerate() {
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
        let (law, share) = (result.law.name, word(share_inside(&lines)));
        text += &format!("{law},,all that were not fitted,,intervals of 95 % that hold,%,95,{share},,,,,,,\n");
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
    entries.push(metrics_file::entry(&format!("real.{}.inside_percent", report.page.name), share_inside(&lines), "%"));
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
            let lines = condition_lines(self, result);
            lines.iter().try_for_each(|line| write_line(f, line))?;
            let share = share_inside(&lines).map_or_else(|| "none".to_owned(), |share| format!("{share:.0} %"));
            writeln!(f, "    intervals of 95 % that hold, of all that was not fitted: {share}")?;
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
