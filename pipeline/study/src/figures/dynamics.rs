//! Figure `dynamics`: the identified model follows trials it never saw. Paper, figure 7.
//!
//! One panel a condition: sideways displacement of the marker farthest out, measured (mean and deviation of the repeats) and
//! simulated, with the pressures under it.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Mark, Panel, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::origin_note;
use crate::fault::{Fault, Outcome};
use crate::figure;
use crate::needs::Every;
use crate::records::Validation;

/// The figure.
pub struct Dynamics;

impl figure::Figure for Dynamics {
    type Needs = Every<Validation>;
    const NAME: &'static str = "dynamics";
    const SHOWS: &'static str = "the identified model follows trials it never saw";
    const EDITION: u32 = 2;

    fn draw(Every(trials): Self::Needs) -> Outcome<Figure> {
        if trials.is_empty() {
            return Err(Fault::new("there is no validation to show", "no trial has that role", "add one to a card"));
        }
        let mut figure = Figure::new(DOUBLE_COLUMN_MM);
        for (trial, validation) in &trials {
            let title = format!(
                "{} {} (N = {}): RMSE {:.2} mm, {:.2} % of the length",
                trial.card.name,
                trial.condition().replace('_', " "),
                validation.repeats,
                validation.rmse / MILLIMETRE,
                validation.rmse_percent()
            );
            figure = figure
                .row(52.0, [motion(validation).titled(&title)])
                .row(30.0, [Panel::Axes(pressures(validation)).titled("chamber pressures").unlettered()]);
        }
        Ok(figure.noted(&origin_note(trials.iter().map(|(t, _)| t.card.as_ref()))))
    }
}

fn curve(time: &[f64], value: impl Iterator<Item = f64>) -> Vec<Point2> {
    time.iter().zip(value).map(|(&t, v)| [t, v]).collect()
}

fn motion(v: &Validation) -> Panel {
    let sideways = |path: &[Point2]| curve(&v.time, path.iter().map(|p| p[1] / MILLIMETRE));
    let label = format!("sideways, marker {}", v.marker);
    let edge = |sign: f64| {
        let both = v.measured.iter().zip(&v.deviation);
        both.map(|(m, d)| (m[1] + sign * d[1]) / MILLIMETRE).collect::<Vec<f64>>()
    };
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear(&label, "mm"))
        .with(Mark::band(v.time.clone(), edge(-1.0), edge(1.0), palette::MEASURED))
        .with(Mark::line(sideways(&v.measured), palette::MEASURED).sized(1.4).labelled("measured"))
        .with(Mark::line(sideways(&v.simulated), palette::SIMULATED).dashed(Dash::Dashed).labelled("simulated"));
    Panel::Axes(axes)
}

fn pressures(v: &Validation) -> Axes {
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("pressure", "mbar"));
    v.pressures.iter().enumerate().fold(axes, |axes, (i, pressure)| {
        let line = Mark::line(curve(&v.time, pressure.iter().map(|p| p / MILLIBAR)), palette::series(i + 1));
        axes.with(line.labelled(&format!("chamber {}", i + 1)))
    })
}
