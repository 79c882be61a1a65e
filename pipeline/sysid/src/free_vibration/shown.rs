//! A table of identified beside published values, and a figure of the displacements.

use std::fmt;
use std::path::Path;

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};
use si::Series;

use super::Report;
use super::warnings::warnings;
use diagnostics::{Diagnostic, Result};

/// One line of the table: what, unit, measured, one value a law, published.
struct Line {
    what: &'static str,
    unit: &'static str,
    measured: Option<f64>,
    laws: Vec<f64>,
    published: Option<f64>,
}

/// Writes `real_<name>.csv` and `real_<name>.svg` into `folder`.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written.
pub fn write(report: &Report, folder: &Path) -> Result<()> {
    let figure = figure(report).svg()?;
    let stem = format!("real_{}", report.page.name);
    let write = |ending: &str, text: &str| std::fs::write(folder.join(format!("{stem}.{ending}")), text);
    std::fs::create_dir_all(folder)
        .and_then(|()| write("csv", &csv(report)))
        .and_then(|()| write("svg", &figure))
        .map_err(|e| {
            Diagnostic::new(format!("{} cannot be written", folder.display()), e, "name another folder with --out")
        })
}

fn lines(report: &Report) -> Vec<Line> {
    let mean = |values: &dyn Fn(usize) -> f64| {
        (0..report.recorded.len()).map(values).sum::<f64>() / report.recorded.len() as f64
    };
    let each = |value: &dyn Fn(&super::ByLaw) -> f64| report.laws.iter().map(value).collect::<Vec<f64>>();
    let published = report.page.published.as_ref().map(|p| 1e-3 * p.youngs_modulus);
    let line = |what, unit, measured, laws, published| Line { what, unit, measured, laws, published };
    let settled =
        mean(&|i| 1e3 * report.recorded[i].settled.iter().sum::<f64>() / report.recorded[i].settled.len() as f64);
    let vibrations = &report.vibrations;
    vec![
        line(
            "Young's modulus, from the static deflection",
            "kPa",
            None,
            each(&|l| 1e-3 * l.found.youngs_modulus),
            published,
        ),
        line("its standard deviation", "%", None, each(&|l| 100.0 * l.found.sigma), None),
        line("static deflection (used)", "mm", Some(settled), each(&|l| 1e3 * l.found.settled), None),
        line("decay rate (used)", "1/s", Some(mean(&|i| vibrations[i].decay)), each(&|l| l.vibration.decay), None),
        line("stiffness damping", "ms", None, each(&|l| 1e3 * l.beta), None),
        line(
            "frequency (predicted)",
            "Hz",
            Some(mean(&|i| vibrations[i].frequency)),
            each(&|l| l.vibration.frequency),
            None,
        ),
        line(
            "damping ratio",
            "",
            Some(mean(&|i| vibrations[i].damping_ratio())),
            each(&|l| l.vibration.damping_ratio()),
            None,
        ),
        line(
            "first extremum (predicted)",
            "mm",
            Some(mean(&|i| 1e3 * vibrations[i].lowest)),
            each(&|l| 1e3 * l.vibration.lowest),
            None,
        ),
        line(
            "first extremum (predicted)",
            "ms",
            Some(mean(&|i| 1e3 * vibrations[i].when)),
            each(&|l| 1e3 * l.vibration.when),
            None,
        ),
    ]
}

fn csv(report: &Report) -> String {
    let laws: Vec<&str> = report.laws.iter().map(|l| l.law.as_str()).collect();
    let mut text = format!("quantity,unit,measured,{},published\n", laws.join(","));
    let word = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
    for line in lines(report) {
        let laws: Vec<String> = line.laws.iter().map(|v| word(Some(*v))).collect();
        let (measured, published) = (word(line.measured), word(line.published));
        text += &format!("\"{}\",{},{measured},{},{published}\n", line.what, line.unit, laws.join(","));
    }
    let none = ",".repeat(laws.len());
    warnings(report).iter().for_each(|warning| text += &format!("\"warning: {warning}\",,,{none}\n"));
    text
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<42} {:>10}", self.page.name, "measured")?;
        self.laws.iter().try_for_each(|law| write!(f, " {:>12}", law.law))?;
        writeln!(f, " {:>10}", "published")?;
        let word = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"));
        for line in lines(self) {
            let head =
                if line.unit.is_empty() { line.what.to_owned() } else { format!("{} ({})", line.what, line.unit) };
            write!(f, "{head:<42} {:>10}", word(line.measured))?;
            line.laws.iter().try_for_each(|v| write!(f, " {:>12}", word(Some(*v))))?;
            writeln!(f, " {:>10}", word(line.published))?;
        }
        let names: Vec<&str> = self.recorded.iter().map(|r| r.name.as_str()).collect();
        writeln!(f, "recorded: {}", names.join(", "))?;
        warnings(self).iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        self.page.published.iter().try_for_each(|p| writeln!(f, "published: {}", p.source))
    }
}

fn figure(report: &Report) -> Figure {
    let window = report.page.swing[1];
    let points = |fall: &Series| {
        let until = fall.values().iter().enumerate().map(|(i, v)| [fall.time(i), 1e3 * v]);
        until.take_while(|p| p[0] <= window).collect::<Vec<_>>()
    };
    let recorded = report.recorded.iter().enumerate().map(|(i, r)| {
        let line = Mark::line(points(&r.fall), palette::MUTED);
        if i == 0 { line.labelled("recorded") } else { line }
    });
    let colours = [palette::SIMULATED, palette::SPINE, palette::NETWORK];
    let laws = report.laws.iter().zip(colours.into_iter().cycle());
    let laws = laws
        .map(|(l, colour)| Mark::line(points(&l.fall), colour).dashed(Dash::Dashed).labelled(&l.law.replace('_', "-")));
    let axes = Axes::new(Axis::linear("time after the release", "s"), Axis::linear("displacement", "mm"));
    let axes = recorded.chain(laws).fold(axes, Axes::with);
    let title = format!("{}: static deflection and predicted vibration", report.page.name.replace('_', " "));
    Figure::new(DOUBLE_COLUMN_MM)
        .row(60.0, [Panel::Axes(axes).titled(&title)])
        .noted("measured data, not from the virtual bench")
}
