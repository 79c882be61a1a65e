//! Figures `dynamics` and `dynamics_water`: the identified model against validation trials, in air and in water. Paper, figure 7.
//!
//! Of each condition the first cycles: lateral displacement of the tip marker, measured (mean and deviation of the repeats), simulated, and
//! simulated by the paper's own model; what is left of it; and the pressures under it.

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Dash, Figure, Legend, Mark, Panel, Placed, palette};
use si::{MILLIBAR, MILLIMETRE, Point2, Second};

use super::order::{capitalised, in_order};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use lab::card::Experiment;
use records::Validation;
use records::subject::{Study, Trial};
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
    const VERSION: u32 = 5;

    fn is_made_for(study: &Study) -> bool {
        has_prediction(study, false)
    }

    fn draw(Every(trials): Self::Needs) -> Result<Figure> {
        validation_figure(trials.into_iter().filter(|(trial, _)| !trial.is_in_water()).collect())
    }
}

/// The figure of trials in water.
pub struct DynamicsWater;

impl figure::Figure for DynamicsWater {
    type Of = Study;
    type Needs = Every<Validation, Trial>;
    const NAME: &'static str = "dynamics_water";
    const CAPTION: &'static str = "the identified model and validation trials under water";
    const VERSION: u32 = 2;

    fn is_made_for(study: &Study) -> bool {
        has_prediction(study, true)
    }

    fn draw(Every(trials): Self::Needs) -> Result<Figure> {
        validation_figure(trials.into_iter().filter(|(trial, _)| trial.is_in_water()).collect())
    }
}

/// Whether any trial in water (or in air) has a prediction.
fn has_prediction(study: &Study, wet: bool) -> bool {
    Trial::all(study).iter().any(|trial| trial.is_in_water() == wet && Validation::is_made_for(trial))
}

/// Cycles that are shown, from the first command on.
const CYCLES: f64 = 3.0;

/// Two conditions a row, each over its residual and its pressures.
fn validation_figure(trials: Vec<(Trial, Validation)>) -> Result<Figure> {
    if trials.is_empty() {
        return Err(Diagnostic::new("there is no validation to show", "no trial has that role", "add one to a card"));
    }
    let trials = in_order(trials);
    let mut figure = Figure::new(DOUBLE_COLUMN_MM);
    for pair in trials.chunks(2) {
        let shown: Vec<Shown> =
            pair.iter().map(|(trial, validation)| Shown::of_validation(trial, validation)).collect();
        let motions: Vec<Placed> =
            shown.iter().map(|shown| Panel::Axes(shown.motion_axes()).titled(&shown.condition_title())).collect();
        let below = |axes: Axes| Placed::from(Panel::Axes(axes)).without_panel_label();
        let residuals: Vec<Placed> = shown.iter().map(|shown| below(shown.residual_axes())).collect();
        let pressures: Vec<Placed> = shown.iter().map(|shown| below(shown.pressure_axes())).collect();
        figure = figure.row(42.0, motions).row(20.0, residuals).row(26.0, pressures);
    }
    Ok(figure.noted(&origin_note(trials.iter().map(|(t, _)| t.card.as_ref()))))
}

/// The part of a validation that is drawn.
struct Shown<'a> {
    trial: &'a Trial,
    validation: &'a Validation,
    /// From a little before the first command, s.
    begin: Second,
    end: Second,
}

impl<'a> Shown<'a> {
    fn of_validation(trial: &'a Trial, validation: &'a Validation) -> Self {
        let time = &validation.time;
        let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
        let whole_motion = Self { trial, validation, begin: first, end: last };
        let Experiment::Flapping { frequency, .. } = trial.trial.experiment else { return whole_motion };
        let highest = validation.pressures.iter().flatten().copied().fold(0.0, f64::max);
        let fills = |frame: &usize| validation.pressures.iter().any(|chamber| chamber[*frame] > 0.1 * highest);
        let Some(filled) = (0..time.len()).find(fills) else { return whole_motion };
        let cycle = 1.0 / frequency;
        let begin = (time[filled] - 0.2 * cycle).max(first);
        Self { begin, end: (time[filled] + CYCLES * cycle).min(last), ..whole_motion }
    }

    /// The condition, its repeats and the error over all cycles.
    fn condition_title(&self) -> String {
        let Self { trial, validation, .. } = self;
        format!(
            "{} {} (N = {}): RMSE {:.2} mm, {:.2} %",
            capitalised(&trial.card.name),
            trial.condition().replace("mbar_", " mbar ").replace("hz", " Hz").replace('_', " "),
            validation.repeats,
            validation.rmse / MILLIMETRE,
            validation.rmse_percent()
        )
    }

    /// One value a frame over time, of the frames that are shown.
    fn curve_over_time(&self, value: impl Fn(usize) -> f64) -> Vec<Point2> {
        self.shown_frames().map(|frame| [self.validation.time[frame], value(frame)]).collect()
    }

    fn shown_frames(&self) -> impl Iterator<Item = usize> {
        let time = &self.validation.time;
        (0..time.len()).filter(|frame| (self.begin..=self.end).contains(&time[*frame]))
    }

    fn time_axis(&self) -> Axis {
        Axis::linear("time", "s").range(self.begin, self.end)
    }

    /// Within one standard deviation of the repeats about a value a frame, mm.
    fn deviation_band(&self, middle: impl Fn(usize) -> f64) -> Mark {
        let deviation = |frame: usize| self.validation.deviation[frame][1] / MILLIMETRE;
        let edge = |sign: f64| self.shown_frames().map(|frame| middle(frame) + sign * deviation(frame)).collect();
        let time = self.shown_frames().map(|frame| self.validation.time[frame]).collect();
        Mark::band(time, edge(-1.0), edge(1.0), palette::MEASURED)
    }

    fn motion_axes(&self) -> Axes {
        let lateral = |path: &'a [Point2]| move |frame: usize| path[frame][1] / MILLIMETRE;
        let Validation { measured, simulated, by_paper_model, marker, .. } = self.validation;
        let (measured, simulated) = (lateral(measured), lateral(simulated));
        Axes::new(self.time_axis().without_tick_labels(), Axis::linear(&format!("lateral, {marker}"), "mm"))
            .with(self.deviation_band(measured).labelled("deviation"))
            .with(Mark::line(self.curve_over_time(measured), palette::MEASURED).sized(1.4).labelled("measured"))
            .with(
                Mark::line(self.curve_over_time(lateral(by_paper_model)), palette::SPINE)
                    .sized(0.7)
                    .labelled("paper's model"),
            )
            .with(
                Mark::line(self.curve_over_time(simulated), palette::SIMULATED)
                    .dashed(Dash::Dashed)
                    .labelled("simulated"),
            )
            .legend(Legend::Over)
    }

    /// Simulated less measured, beside the deviation of the repeats.
    fn residual_axes(&self) -> Axes {
        let Validation { measured, simulated, .. } = self.validation;
        let difference = |frame: usize| (simulated[frame][1] - measured[frame][1]) / MILLIMETRE;
        Axes::new(self.time_axis().without_tick_labels(), Axis::linear("residual", "mm"))
            .with(self.deviation_band(|_| 0.0))
            .with(Mark::line(self.curve_over_time(difference), palette::SIMULATED))
            .legend(Legend::None)
    }

    fn pressure_axes(&self) -> Axes {
        let axes = Axes::new(self.time_axis(), Axis::linear("pressure", "mbar"));
        let looks = [(palette::PRESSURE, Dash::Solid), (palette::PRESSURE.towards(palette::BLACK, 0.5), Dash::Dashed)];
        let names = self.trial.card.chamber.iter().map(|chamber| chamber.name.as_str());
        let chambers = self.validation.pressures.iter().zip(names).enumerate();
        let axes = chambers.fold(axes, |axes, (i, (pressure, name))| {
            let (colour, dash) = looks[i % looks.len()];
            let line = Mark::line(self.curve_over_time(|frame| pressure[frame] / MILLIBAR), colour).dashed(dash);
            axes.with(line.labelled(name))
        });
        axes.legend(Legend::Over)
    }
}
