//! Figure `four_parameters`: both moduli and both Poisson's ratios, identified together. Paper, figure 6.
//!
//! One panel a parameter: its value at each simulation from the data sheet's on, the plausible range as a band, and the final point with its
//! 95 % interval, cut off at the panel's edge. Where the interval spans the plausible range the recordings do not determine the parameter,
//! and the panel says so. Then the loss. Each specimen has a row of its own.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Figure, Legend, Mark, Marker, Panel, Placed, Side, palette};
use si::Point2;

use super::order::{capitalised, in_order};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct FourParameters;

impl figure::Figure for FourParameters {
    type Of = Study;
    type Needs = Every<records::FourParameters, Specimen>;
    const NAME: &'static str = "four_parameters";
    const CAPTION: &'static str = "both moduli and both Poisson's ratios, identified together";
    const VERSION: u32 = 5;

    fn draw(Every(searches): Self::Needs) -> Result<Figure> {
        if searches.is_empty() {
            return Err(Diagnostic::new(
                "there is no search to show",
                "no specimen has one",
                "study run four_parameters",
            ));
        }
        let searches = in_order(searches);
        let mut figure = Figure::new(DOUBLE_COLUMN_MM);
        for (i, (specimen, search)) in searches.iter().enumerate() {
            // one legend serves all rows: over a narrow panel it takes as much room as the panel
            let legend = |k: usize| if (i, k) == (0, 0) { Legend::Over } else { Legend::None };
            let parameters = [0, 1, 2, 3].map(|k| Placed::from(parameter_panel(search, k, legend(k))));
            let [first, other_panels @ ..] = parameters;
            let other_panels =
                other_panels.into_iter().chain([Placed::from(loss_panel(search))]).map(Placed::without_panel_label);
            let row = [first.titled(&capitalised(&specimen.card.name))].into_iter().chain(other_panels);
            figure = figure.row(if i == 0 { 56.0 } else { 40.0 }, row.collect::<Vec<Placed>>());
        }
        Ok(figure.noted(&origin_note(searches.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

const LABELS: [&str; 4] = ["E, body", "E, spine", "ν, body", "ν, spine"];
const UNITS: [&str; 4] = ["MPa", "GPa", "", ""];
const SCALES: [f64; 4] = [1e-6, 1e-9, 1.0, 1.0];

fn parameter_panel(search: &records::FourParameters, k: usize, legend: Legend) -> Panel {
    let points: Vec<Point2> =
        search.iterates.iter().enumerate().map(|(i, (four, _))| [(i + 1) as f64, four.in_display_units()[k]]).collect();
    let last = points.len().max(2) as f64;
    let [low, high] = search.plausible[k].map(|v| SCALES[k] * v);
    let margin = 0.08 * (high - low);
    let axes = Axes::new(
        Axis::linear("simulations", "").range(1.0, last),
        Axis::linear(LABELS[k], UNITS[k]).range(low - margin, high + margin),
    );
    let end = vec![[last, search.best.in_display_units()[k]]];
    let axes = axes.legend(legend);
    let ends = search.intervals()[k].map(|v| v.clamp(low - margin, high + margin));
    // a uniform distribution over the plausible range has 95 % of itself in 95 % of it
    let determined = ends[1] - ends[0] < 0.95 * (high - low);
    let undetermined = (!determined)
        .then(|| Mark::text([0.5 * (1.0 + last), high], "not determined", Side::Below, palette::OPTIMUM).sized(6.0));
    let interval = Mark::line(vec![[last, ends[0]], [last, ends[1]]], palette::OPTIMUM).labelled("95 %");
    let axes = axes
        .with(Mark::band(vec![1.0, last], vec![low; 2], vec![high; 2], palette::MUTED).labelled("plausible"))
        .with(Mark::line(points.clone(), palette::method("gauss_newton")))
        .with(Mark::points(points, Marker::Disc, palette::method("gauss_newton")).sized(3.6).labelled("tried"))
        .with(interval)
        .with(Mark::points(end, Marker::Ring, palette::OPTIMUM).sized(6.0).labelled("final"));
    Panel::Axes(undetermined.into_iter().fold(axes, Axes::with))
}

/// The loss at each simulation.
fn loss_panel(search: &records::FourParameters) -> Panel {
    let points: Vec<Point2> =
        search.iterates.iter().enumerate().map(|(i, (_, loss))| [(i + 1) as f64, *loss]).collect();
    let colour = palette::method("gauss_newton");
    let axes = Axes::new(Axis::linear("simulations", "").range(1.0, points.len().max(2) as f64), Axis::log("loss", ""));
    let axes =
        axes.with(Mark::line(points.clone(), colour)).with(Mark::points(points, Marker::Disc, colour).sized(3.6));
    Panel::Axes(axes.legend(Legend::None))
}
