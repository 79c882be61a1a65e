//! Figures `dynamics` and `dynamics_water`: the identified model against validation trials, in air and in water. Paper, figure 7.
//!
//! One panel a condition: lateral displacement of the tip marker, measured (mean and deviation of the repeats) and
//! simulated, with the pressures under it.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Panel, Placed, palette};
use si::{MILLIBAR, MILLIMETRE, Point2};

use super::order::{in_order, title};
use super::origin_note;
use crate::records::Validation;
use crate::subject::{Study, Trial};
use diagnostics::{Diagnostic, Result};
use workflow::figure;
use workflow::needs::Every;
use workflow::record::Record;
use workflow::subject::Subject;

/// The figure.
pub struct Dynamics;

impl figure::Figure for Dynamics {
    type Of = Study;
    type Needs = Every<Validation, Trial>;
    const NAME: &'static str = "dynamics";
    const CAPTION: &'static str = "the identified model and validation trials in air";
    const VERSION: u32 = 4;

    fn is_made_for(study: &Study) -> bool {
        validated(study, false)
    }

    fn draw(Every(trials): Self::Needs) -> Result<Figure> {
        drawn(trials.into_iter().filter(|(trial, _)| !trial.is_in_water()).collect())
    }
}

/// The figure of trials in water.
pub struct DynamicsWater;

impl figure::Figure for DynamicsWater {
    type Of = Study;
    type Needs = Every<Validation, Trial>;
    const NAME: &'static str = "dynamics_water";
    const CAPTION: &'static str = "the identified model and validation trials under water";
    const VERSION: u32 = 1;

    fn is_made_for(study: &Study) -> bool {
        validated(study, true)
    }

    fn draw(Every(trials): Self::Needs) -> Result<Figure> {
        drawn(trials.into_iter().filter(|(trial, _)| trial.is_in_water()).collect())
    }
}

/// Whether any trial in water (or in air) has a prediction.
fn validated(study: &Study, wet: bool) -> bool {
    Trial::all(study).iter().any(|trial| trial.is_in_water() == wet && Validation::is_made_for(trial))
}

/// Two conditions a row, each over its pressures.
fn drawn(trials: Vec<(Trial, Validation)>) -> Result<Figure> {
    if trials.is_empty() {
        return Err(Diagnostic::new("there is no validation to show", "no trial has that role", "add one to a card"));
    }
    let trials = in_order(trials);
    let mut figure = Figure::new(DOUBLE_COLUMN_MM);
    for pair in trials.chunks(2) {
        let moved: Vec<Placed> = pair.iter().map(|(t, v)| motion(v).titled(&text(t, v))).collect();
        let driven: Vec<Placed> =
            pair.iter().map(|(t, v)| Placed::from(Panel::Axes(pressures(t, v))).without_panel_label()).collect();
        figure = figure.row(46.0, moved).row(28.0, driven);
    }
    Ok(figure.noted(&origin_note(trials.iter().map(|(t, _)| t.card.as_ref()))))
}

/// The condition, its repeats and the error.
fn text(trial: &Trial, v: &Validation) -> String {
    format!(
        "{} {} (N = {}): RMSE {:.2} mm, {:.2} %",
        title(&trial.card.name),
        trial.condition().replace("mbar_", " mbar ").replace("hz", " Hz").replace('_', " "),
        v.repeats,
        v.rmse / MILLIMETRE,
        v.rmse_percent()
    )
}

fn curve(time: &[f64], value: impl Iterator<Item = f64>) -> Vec<Point2> {
    time.iter().zip(value).map(|(&t, v)| [t, v]).collect()
}

fn motion(v: &Validation) -> Panel {
    let sideways = |path: &[Point2]| curve(&v.time, path.iter().map(|p| p[1] / MILLIMETRE));
    let label = format!("lateral, marker {}", v.marker);
    let edge = |sign: f64| {
        let both = v.measured.iter().zip(&v.deviation);
        both.map(|(m, d)| (m[1] + sign * d[1]) / MILLIMETRE).collect::<Vec<f64>>()
    };
    let axes = Axes::new(Axis::linear("time", "s").without_tick_labels(), Axis::linear(&label, "mm"))
        .with(Mark::band(v.time.clone(), edge(-1.0), edge(1.0), palette::MEASURED))
        .with(Mark::line(sideways(&v.measured), palette::MEASURED).sized(1.4).labelled("measured"))
        .with(Mark::line(sideways(&v.simulated), palette::SIMULATED).dashed(Dash::Dashed).labelled("simulated"));
    Panel::Axes(axes.legend(Legend::Over))
}

fn pressures(trial: &Trial, v: &Validation) -> Axes {
    let axes = Axes::new(Axis::linear("time", "s"), Axis::linear("pressure", "mbar"));
    let looks = [(palette::PRESSURE, Dash::Solid), (palette::PRESSURE.towards(palette::BLACK, 0.5), Dash::Dashed)];
    let names = trial.card.chamber.iter().map(|c| c.name.as_str());
    let axes = v.pressures.iter().zip(names).enumerate().fold(axes, |axes, (i, (pressure, name))| {
        let (colour, dash) = looks[i % looks.len()];
        let line = Mark::line(curve(&v.time, pressure.iter().map(|p| p / MILLIBAR)), colour).dashed(dash);
        axes.with(line.labelled(name))
    });
    axes.legend(Legend::Over)
}
