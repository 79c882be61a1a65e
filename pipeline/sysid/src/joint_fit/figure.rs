//! The scoreboard as a figure: the error of each prediction of a condition that was left out, with its interval, beside that of the
//! neo-Hookean law and of proportion to the pressure.

use plot::{Axes, Axis, Colour, DOUBLE_COLUMN_MM, Figure, Mark, Marker, Panel, Side, palette};

use super::Report;
use super::ladder::supported_law;
use super::scoreboard::{Line, condition_lines, plain_lines};

/// Errors beyond this are drawn at the edge, with their number, %.
const FARTHEST: f64 = 100.0;
/// Height of a row, mm.
const ROW_MM: f64 = 3.4;
/// The left end of the axis, where the names of rows stand, %.
const NAMES: f64 = -290.0;

/// What is predicted without having been fitted, of the supported law; none where no law is supported.
pub(super) fn scoreboard_figure(report: &Report) -> Option<Figure> {
    let result = &report.results[supported_law(&report.results, &report.tests)?];
    let lines = condition_lines(report, result);
    let plain = plain_lines(report);
    let rows: Vec<(&Line, Option<&Line>)> = lines
        .iter()
        .enumerate()
        .map(|(k, line)| (line, plain.as_ref().map(|plain| &plain[k])))
        .filter(|(line, _)| line.role != "fitted" && line.recorded.is_some())
        .collect();
    let count = rows.len() as f64;
    let horizontal = Axis::linear("error of the prediction", "%").range(NAMES, FARTHEST + 20.0);
    let mut axes = Axes::new(horizontal, Axis::linear("", "").range(-count, 1.0).without_tick_labels());
    axes = axes.with(Mark::vertical_line(0.0, palette::MUTED));
    for (k, (line, _)) in rows.iter().enumerate() {
        let y = -(k as f64);
        let beyond = if line.extrapolated { " *" } else { "" };
        let name = format!("{}, {}{beyond}", line.condition, line.quantity);
        axes = axes.with(Mark::text([NAMES, y], &name, Side::Right, palette::BLACK).sized(6.0));
        if let Some([low, high]) = interval_percent(line) {
            axes = axes.with(Mark::line(vec![[low, y], [high, y]], palette::SIMULATED));
        }
    }
    let error_of_linear = |line: &Line| Some(100.0 * (line.linear? / line.recorded? - 1.0));
    let linear: Vec<Option<f64>> = rows.iter().map(|(line, _)| error_of_linear(line)).collect();
    let neo_hookean: Vec<Option<f64>> = rows.iter().map(|(_, plain)| plain.and_then(Line::error_percent)).collect();
    let predicted: Vec<Option<f64>> = rows.iter().map(|(line, _)| line.error_percent()).collect();
    for (errors, marker, colour, name) in [
        (linear, Marker::Cross, palette::MUTED, "in proportion to the pressure"),
        (neo_hookean, Marker::Ring, palette::SPINE, "neo-Hookean law"),
        (predicted, Marker::Disc, palette::SIMULATED, result.law.name),
    ] {
        axes = with_errors(axes, &errors, (marker, colour, name));
    }
    let figure = Figure::new(DOUBLE_COLUMN_MM).row(ROW_MM * (count + 2.0), vec![Panel::Axes(axes)]);
    Some(figure.noted("measured data, not from the virtual bench; lines: intervals of 95 %; *: extrapolated"))
}

fn with_errors(axes: Axes, errors: &[Option<f64>], (marker, colour, name): (Marker, Colour, &str)) -> Axes {
    let error_at = |k: usize| errors[k].map(|error| [error.clamp(-FARTHEST, FARTHEST), -(k as f64)]);
    let points = (0..errors.len()).filter_map(error_at).collect();
    let axes = axes.with(Mark::points(points, marker, colour).labelled(name));
    let beyond = errors.iter().enumerate().filter_map(|(k, error)| Some((k, error.filter(|error| *error > FARTHEST)?)));
    beyond.fold(axes, |axes, (k, error)| {
        let text = Mark::text([FARTHEST, -(k as f64)], &format!("{error:+.0}"), Side::Right, colour);
        axes.with(text.sized(5.0))
    })
}

/// The interval as errors, within what is drawn, %.
fn interval_percent(line: &Line) -> Option<[f64; 2]> {
    let (value, width) = *line.predicted.as_ref().ok()?;
    let recorded = line.recorded?;
    let error = |value: f64| (100.0 * (value / recorded - 1.0)).clamp(-FARTHEST, FARTHEST);
    let ends = [error(value - width), error(value + width)];
    Some([ends[0].min(ends[1]), ends[0].max(ends[1])])
}
