//! Figure `four_parameters`: both moduli and both Poisson's ratios, identified together. Paper, figure 6.
//!
//! One panel a parameter: its value at each simulation, the plausible range as a band, and the final point with its 95 % interval, cut off
//! at the panel's edge where the recordings do not determine the parameter. Which combinations are determined, and how
//! well, is noted below. Each specimen has a row of its own.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Figure, Legend, Mark, Marker, Panel, palette};
use si::Point2;

use super::order::{in_order, title};
use super::origin_note;
use crate::records;
use crate::subject::{Specimen, Study};
use diagnostics::{Diagnostic, Result};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct FourParameters;

impl figure::Figure for FourParameters {
    type Of = Study;
    type Needs = Every<records::FourParameters, Specimen>;
    const NAME: &'static str = "four_parameters";
    const CAPTION: &'static str = "both moduli and both Poisson's ratios, identified together";
    const VERSION: u32 = 3;

    fn draw(Every(all): Self::Needs) -> Result<Figure> {
        if all.is_empty() {
            return Err(Diagnostic::new(
                "there is no search to show",
                "no specimen has one",
                "study run four_parameters",
            ));
        }
        let all = in_order(all);
        let mut figure = Figure::new(DOUBLE_COLUMN_MM);
        for (specimen, found) in &all {
            let name = title(&specimen.card.name);
            figure =
                figure.row(44.0, [0, 1, 2, 3].map(|k| parameter(found, k).titled(&format!("{name}: {}", TITLES[k]))));
        }
        let least = |(specimen, found): &(Specimen, records::FourParameters)| {
            format!("{}: {}.", title(&specimen.card.name), found.uncertainty.words)
        };
        let words = all.iter().map(least).chain([origin_note(all.iter().map(|(s, _)| s.card.as_ref()))]);
        Ok(figure.noted(&words.collect::<Vec<_>>().join(" ")))
    }
}

const TITLES: [&str; 4] = ["E of the body", "E of the spine", "ν of the body", "ν of the spine"];
const UNITS: [&str; 4] = ["MPa", "GPa", "", ""];
const SCALES: [f64; 4] = [1e-6, 1e-9, 1.0, 1.0];

fn parameter(found: &records::FourParameters, k: usize) -> Panel {
    let points: Vec<Point2> =
        found.iterates.iter().enumerate().map(|(i, (four, _))| [(i + 1) as f64, four.in_display_units()[k]]).collect();
    let last = points.len().max(2) as f64;
    let [low, high] = found.plausible[k].map(|v| SCALES[k] * v);
    let margin = 0.08 * (high - low);
    let axes = Axes::new(
        Axis::linear("simulations", "").range(1.0, last),
        Axis::linear(TITLES[k], UNITS[k]).range(low - margin, high + margin),
    );
    let end = vec![[last, found.best.in_display_units()[k]]];
    let axes = axes.legend(if k == 0 { Legend::Over } else { Legend::None });
    let ends = found.intervals()[k].map(|v| v.clamp(low - margin, high + margin));
    let interval = Mark::line(vec![[last, ends[0]], [last, ends[1]]], palette::OPTIMUM).labelled("95 %");
    Panel::Axes(
        axes.with(Mark::band(vec![1.0, last], vec![low; 2], vec![high; 2], palette::MUTED).labelled("plausible"))
            .with(Mark::line(points.clone(), palette::method("gauss_newton")))
            .with(Mark::points(points, Marker::Disc, palette::method("gauss_newton")).sized(3.6).labelled("tried"))
            .with(interval)
            .with(Mark::points(end, Marker::Ring, palette::OPTIMUM).sized(6.0).labelled("final")),
    )
}
