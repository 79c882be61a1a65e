//! Validate: a flapping motion that identification did not use, simulated with the identified moduli and compared at the tip
//! marker with the mean of its repeats. Paper: section VI, dynamic experiments.
//!
//! One simulation serves all repeats of a condition: its actuation is the mean of their measured pressures, aligned
//! at the first command. It uses the reduced model; its first part is integrated by the full model too, and the difference is
//! reported. In water the reduced model has the added mass and the drag identified from a release; the full model has
//! no water, and is not compared.

use fem::{DynamicSettings, Scheme};
use hydro::{Coefficients, Tail};
use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Point2, Second};
use signal::resample::Samples;

use super::amplitude::{self, Predicted};
use super::baselines::{self, QuasiStatic};
use super::deviations::UncertainSilicone;
use super::repeats::{self, AlignedRepeats};
use ::thrust::outline::Outline;
use ::thrust::real_time::{self, Surroundings};
use ::thrust::underwater::UnderwaterModel;
use diagnostics::{Diagnostic, Result};
use records::selections::{InWater, Repeats};
use records::subject::Trial;
use records::{Drag, Identified, Interval, Mesh, Motion, PAPER_MODEL, Reduced, Relaxation, ScoredModel, Validation};
use sysid::actuated::{Actuation, MotionSimulation, dynamic_settings, exposed_path, lateral_lag};
use sysid::{Body, ReducedBody};
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Validate;

/// `[validate]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Time step of the second-order scheme, s.
    step: Second,
    /// How long the shutter is open, of the time between frames.
    exposure: f64,
    /// Time step of implicit Euler, the paper's scheme, s.
    euler_step: Second,
    /// Duration after the first command over which the uncertainty of the amplitude is computed, s.
    interval_duration: Second,
    /// Duration after the first command that is also integrated by the full model, to measure the error of the reduction, s.
    whole_model_duration: Second,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    body: Body,
    /// The flapping frequency that was commanded, Hz.
    frequency: Option<Hertz>,
}

impl Part<Trial> for Card {
    fn part_of(of: &Trial) -> Self {
        Self { body: Body::of(&of.card), frequency: flapping_frequency(of) }
    }
}

impl Stage for Validate {
    type Settings = Settings;
    type Card = Card;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, InWater<Drag>, Repeats<Motion>);
    type Makes = Validation;
    const DESCRIPTION: &'static str = "flapping is predicted and compared with validation trials";
    const VERSION: u32 = 18;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Validation> {
        let ((mesh, identified, reduced), relaxation, InWater(drag), Repeats(films)) = needs;
        let marker = card.body.tip_marker();
        let rest_positions = films.first().map(|m| m.rest.clone()).unwrap_or_default();
        let tail_in_water =
            |d: &Drag| Outline::new(&card.body, &mesh.solid).whole(d.density, d.sections).map_err(Diagnostic::from);
        let (tail, spots) = drag.as_ref().map(tail_in_water).transpose()?.unzip();
        let model = mesh
            .model(&card.body)?
            .with_markers_at(&mesh.solid, &card.body, &rest_positions)
            .with_spots(spots.unwrap_or_default());
        let silicone = relaxation.silicone(&model, &identified)?;
        let repeats = repeats::align_repeats(&films, marker)?;
        let reduced_body = ReducedBody::of(&model, &silicone, &reduced.data)?;
        let elastic = reduced_body.with(&model, &identified.elastic(&model).into());
        let prediction = Prediction {
            card,
            set,
            simulation: MotionSimulation { model: &model, silicone, marker },
            reduced_body: &reduced_body,
            water: drag.as_ref().zip(tail.as_ref()),
            films: &films,
            repeats,
        };
        let paths = prediction.paths_of_models(&elastic)?;
        context.progress(0.4, "with what identification left open");
        let uncertain = UncertainSilicone { model: &model, identified: &identified, relaxation: &relaxation };
        let amplitude = prediction.amplitude_interval(uncertain, &paths.viscoelastic)?;
        context.progress(0.6, "comparing with the full model");
        let (reduction, twin_error) = prediction.reduction_and_twin_errors()?;
        context.progress(0.9, "in real time");
        let real_time_factor = prediction.real_time_factor(context)?;
        Ok(prediction.into_record(paths, &identified, Checks { amplitude, reduction, twin_error, real_time_factor }))
    }
}

/// The prediction of one condition, and the films that it is compared with.
struct Prediction<'a> {
    card: &'a Card,
    set: &'a Settings,
    simulation: MotionSimulation<'a>,
    /// The reduced model with the identified relaxation.
    reduced_body: &'a ReducedBody,
    /// Identified drag and the tail's sections; none in air.
    water: Option<(&'a Drag, &'a Tail)>,
    films: &'a [Motion],
    repeats: AlignedRepeats,
}

/// Predicted paths of the tip marker.
struct PredictedPaths {
    /// Of the first model, as functions of the film's time.
    viscoelastic: [Samples; 2],
    /// Of all models, as the camera sees them, m: models × frames × 2.
    filmed: Vec<Vec<Point2>>,
    /// Their errors, in the same order.
    scored: Vec<ScoredModel>,
}

/// The interval of the amplitude, and what the reduction costs.
struct Checks {
    amplitude: Interval,
    reduction: Option<f64>,
    twin_error: Option<Metre>,
    real_time_factor: Option<f64>,
}

impl Prediction<'_> {
    /// The measured actuation over the whole film.
    fn actuation(&self) -> Actuation<'_> {
        let time = &self.repeats.time;
        Actuation { begin: time[0], end: time[time.len() - 1], steps: None, gauges: &self.repeats.gauges }
    }

    /// The end of an interval that begins with the first command, within the film, s.
    fn end_after(&self, duration: Second) -> Second {
        (self.repeats.moves + duration).min(self.actuation().end)
    }

    /// The path of the tip marker of `body`, in water where coefficients are given.
    fn simulated_path(
        &self,
        body: &ReducedBody,
        settings: &DynamicSettings,
        coefficients: Option<Coefficients>,
        actuation: &Actuation,
    ) -> Result<[Samples; 2]> {
        match (coefficients, self.water) {
            (Some(coefficients), Some((_, tail))) => {
                UnderwaterModel::new(body, tail, &self.simulation, self.card.body.markers.len()).path(
                    settings,
                    coefficients,
                    actuation,
                )
            }
            _ => self.simulation.run(body, settings, actuation),
        }
    }

    /// The second-order scheme.
    fn second_order(&self) -> DynamicSettings {
        dynamic_settings(Scheme::Bdf2, self.set.step)
    }

    /// The condition by this study's model, then by each model on the way back to the paper's; `elastic` is the body without
    /// relaxation.
    fn paths_of_models(&self, elastic: &ReducedBody) -> Result<PredictedPaths> {
        let (second_order, euler) = (self.second_order(), dynamic_settings(Scheme::ImplicitEuler, self.set.euler_step));
        // from this study's model back to the paper's own: without relaxation, without a scheme of second order, without water
        let models = [
            ("viscoelastic", self.reduced_body, second_order, true),
            ("elastic", elastic, second_order, true),
            ("implicit_euler", elastic, euler, true),
            (PAPER_MODEL, elastic, euler, false),
        ];
        let (mut scored, mut paths, mut all_filmed) = (Vec::new(), Vec::new(), Vec::new());
        for (name, body, settings, wet) in models {
            let coefficients = self.water.filter(|_| wet).map(|(drag, _)| drag.by);
            let path = self.simulated_path(body, &settings, coefficients, &self.actuation())?;
            let filmed_path = exposed_path(&path, &self.repeats.time, self.set.exposure);
            scored.push(ScoredModel { name: name.into(), rmse: repeats::rms(&self.repeats.mean, &filmed_path) });
            paths.push(path);
            all_filmed.push(filmed_path);
        }
        Ok(PredictedPaths { viscoelastic: paths.swap_remove(0), filmed: all_filmed, scored })
    }

    /// The amplitude on a path with its relative standard deviation, which the first part of the motion gives.
    fn amplitude_interval(&self, silicone: UncertainSilicone, path: &[Samples; 2]) -> Result<Interval> {
        let predicted = Predicted {
            silicone,
            reduced_body: self.reduced_body,
            drag: self.water.map(|(drag, _)| drag),
            settings: &self.second_order(),
        };
        let first_part = Actuation { end: self.end_after(self.set.interval_duration), ..self.actuation() };
        let simulate =
            |body: &ReducedBody, settings: &DynamicSettings, coefficients: Option<_>, actuation: &Actuation| {
                self.simulated_path(body, settings, coefficients, actuation)
            };
        let sigma = predicted.relative_sigma(&simulate, &first_part)?;
        Ok(amplitude::rms_interval(path, &self.repeats.time, sigma))
    }

    /// The errors of reduction and twin against the full model, over the first part of the motion; none in water, which that
    /// model lacks.
    fn reduction_and_twin_errors(&self) -> Result<(Option<f64>, Option<Metre>)> {
        if self.water.is_some() {
            return Ok((None, None));
        }
        let end = self.end_after(self.set.whole_model_duration);
        let checked = Actuation { begin: self.repeats.moves, end, ..self.actuation() };
        let (reduction, twin_error) =
            reduction_error(&self.simulation, self.reduced_body, &self.second_order(), &checked)?;
        Ok((Some(reduction), twin_error))
    }

    /// Simulated time over the time that the twin takes on one core; none where a law is none that a twin has.
    fn real_time_factor(&self, context: &dyn StageContext) -> Result<Option<f64>> {
        let (body, simulation, actuation) = (self.reduced_body, &self.simulation, self.actuation());
        let stations: Vec<usize> = (self.card.body.markers.len()..body.markers()).collect();
        let (rows, half) = (body.rows(&stations), simulation.model.system.mesh().symmetry_plane_z);
        let water = self.water.map(|(drag, tail)| Surroundings { tail, rows: &rows, by: drag.by, half });
        let began = context.thread_seconds();
        let twin = real_time::path((body, water.as_ref()), simulation.marker, self.set.step, &actuation)?;
        Ok(twin.map(|_| (actuation.end - actuation.begin) / (context.thread_seconds() - began)))
    }

    /// The record, with the baselines beside the models.
    fn into_record(self, paths: PredictedPaths, identified: &Identified, checks: Checks) -> Validation {
        let Self { card, simulation, reduced_body, films, repeats: compared, .. } = self;
        let PredictedPaths { filmed: mut paths, scored, .. } = paths;
        let Checks { amplitude, reduction, twin_error, real_time_factor } = checks;
        let (marker, by_paper_model) = (simulation.marker, paths.pop().unwrap_or_default());
        let simulated = paths.swap_remove(0);
        let pressures: Vec<Vec<f64>> = compared.gauges.iter().map(|g| g.onto(&compared.time)).collect();
        let quasi_static = QuasiStatic { pressures: &pressures, identified, marker };
        Validation {
            marker: films.first().map(|m| m.markers[marker].name.clone()).unwrap_or_default(),
            repeats: films.len(),
            lag: card.frequency.map(|f| lateral_lag(&compared.time, &compared.mean, &simulated, f)),
            rmse: scored[0].rmse,
            amplitude,
            length: card.body.length,
            zero_motion_rmse: repeats::rms(&compared.mean, &vec![[0.0; 2]; compared.mean.len()]),
            scored,
            baselines: baselines::baseline_errors(&compared, &quasi_static, card.frequency),
            reduction,
            twin_error,
            real_time_factor,
            coordinates: reduced_body.coordinates(),
            time: compared.time,
            measured: compared.mean,
            deviation: compared.deviation,
            simulated,
            by_paper_model,
            chambers: pressures.len(),
            pressures,
        }
    }
}

/// Root mean square difference of the reduced from the full model's motion, over the largest displacement of the latter; and the largest
/// distance of the reduced model as a twin, m, where its laws have one.
fn reduction_error(
    simulation: &MotionSimulation,
    reduced_body: &ReducedBody,
    settings: &DynamicSettings,
    actuation: &Actuation,
) -> Result<(f64, Option<Metre>)> {
    let twin = real_time::path((reduced_body, None), simulation.marker, settings.step, actuation)?;
    let (full, reduced) =
        (simulation.run_full_model(settings, actuation)?, simulation.run(reduced_body, settings, actuation)?);
    let steps = full[0].values().len();
    let path = |[x, y]: &[Samples; 2]| (0..steps).map(|i| [x.values()[i], y.values()[i]]).collect::<Vec<Point2>>();
    let (full, reduced, twin) = (path(&full), path(&reduced), twin.map(|twin| path(&twin)));
    let farthest = full.iter().map(|p| p[0].hypot(p[1])).fold(f64::MIN_POSITIVE, f64::max);
    let distance = |(a, b): (&Point2, &Point2)| (a[0] - b[0]).hypot(a[1] - b[1]);
    let twin_distance = twin.map(|twin| full.iter().zip(&twin).map(distance).fold(0.0, f64::max));
    Ok((repeats::rms(&full, &reduced) / farthest, twin_distance))
}

/// The commanded flapping frequency, Hz.
fn flapping_frequency(trial: &Trial) -> Option<f64> {
    match trial.trial.experiment {
        Experiment::Flapping { frequency, .. } => Some(frequency),
        Experiment::Staircase { .. } => None,
    }
}
