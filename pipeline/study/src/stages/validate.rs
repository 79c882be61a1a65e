//! Validate: a flapping motion that identification did not use, simulated with the identified moduli and compared at the tip
//! marker with the mean of its repeats. Paper: section VI, dynamic experiments.
//!
//! One simulation serves all repeats of a condition: its actuation is the mean of their measured pressures, aligned
//! at the first command. It uses the reduced model; its first part is integrated by the full model too, and the difference is
//! reported. In water the reduced model has the added mass and the drag identified from a release; the full model has
//! no water, and is not compared.

use fem::{DynamicSettings, Scheme};
use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Point2, Second};
use signal::resample::Samples;

use super::amplitude::{self, Predicted};
use super::baselines::{self, QuasiStatic};
use super::deviations::Open;
use super::repeats;
use ::thrust::outline::Outline;
use ::thrust::real_time::{self, Surroundings};
use ::thrust::underwater::UnderwaterModel;
use diagnostics::{Diagnostic, Result};
use records::selections::{InWater, Repeats};
use records::subject::Trial;
use records::{Drag, Identified, Mesh, Motion, PAPER_MODEL, Reduced, Relaxation, ScoredModel, Validation};
use sysid::actuated::{Actuation, MotionSimulation, dynamic_settings, filmed, lag};
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
        Self { body: Body::of(&of.card), frequency: frequency(of) }
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
        let rest = films.first().map(|m| m.rest.clone()).unwrap_or_default();
        let whole =
            |d: &Drag| Outline::new(&card.body, &mesh.solid).whole(d.density, d.sections).map_err(Diagnostic::from);
        let wet = drag.as_ref().map(whole).transpose()?;
        let (tail, spots) = wet.unzip();
        let model = mesh
            .model(&card.body)?
            .with_markers_at(&mesh.solid, &card.body, &rest)
            .with_spots(spots.unwrap_or_default());
        let silicone = relaxation.silicone(&model, &identified)?;
        let simulation = MotionSimulation { model: &model, silicone, marker };
        let seen = repeats::gather(&films, marker)?;
        let ends = (seen.time[0], seen.time[seen.time.len() - 1]);
        let actuation = Actuation { begin: ends.0, end: ends.1, steps: None, gauges: &seen.gauges };
        let reduced_body = ReducedBody::of(&model, &simulation.silicone, &reduced.data)?;
        let elastic = reduced_body.with(&model, &identified.elastic(&model).into());
        let second_order = dynamic_settings(Scheme::Bdf2, set.step);
        let euler = dynamic_settings(Scheme::ImplicitEuler, set.euler_step);
        // from this study's model back to the paper's own: without relaxation, without a scheme of second order, without water
        let ways = [
            ("viscoelastic", &reduced_body, second_order, true),
            ("elastic", &elastic, second_order, true),
            ("implicit_euler", &elastic, euler, true),
            (PAPER_MODEL, &elastic, euler, false),
        ];
        let simulate =
            |body: &ReducedBody, settings: &DynamicSettings, by: Option<_>, actuation: &Actuation| match (by, &tail) {
                (Some(by), Some(tail)) => {
                    UnderwaterModel::new(body, tail, &simulation, card.body.markers.len()).path(settings, by, actuation)
                }
                _ => simulation.run(body, settings, actuation),
            };
        let by = |wet: bool| drag.as_ref().filter(|_| wet).map(|d| d.by);
        let (mut scored, mut paths, mut simulated) = (Vec::new(), Vec::new(), Vec::new());
        for (name, body, way, wet) in ways {
            let path = simulate(body, &way, by(wet), &actuation)?;
            let seen_path = filmed(&path, &seen.time, set.exposure);
            scored.push(ScoredModel { name: name.into(), rmse: repeats::rms(&seen.mean, &seen_path) });
            simulated.push(path);
            paths.push(seen_path);
        }
        context.progress(0.4, "with what identification left open");
        let predicted = Predicted {
            open: Open { model: &model, identified: &identified, relaxation: &relaxation },
            reduced_body: &reduced_body,
            drag: drag.as_ref(),
            settings: &second_order,
        };
        let first = Actuation { end: (seen.moves + set.interval_duration).min(ends.1), ..actuation };
        let sigma = predicted.sigma(&simulate, &first)?;
        let amplitude = amplitude::interval(&simulated[0], &seen.time, sigma);
        context.progress(0.6, "comparing with the full model");
        let checked =
            Actuation { end: (seen.moves + set.whole_model_duration).min(ends.1), begin: seen.moves, ..actuation };
        let dry = drag.is_none().then(|| reduction(&simulation, &reduced_body, &second_order, &checked));
        let (reduction, twin_error) = dry.transpose()?.map_or((None, None), |(off, twin)| (Some(off), twin));
        context.progress(0.9, "in real time");
        let stations: Vec<usize> = (card.body.markers.len()..reduced_body.markers()).collect();
        let (rows, half) = (reduced_body.rows(&stations), model.system.mesh().symmetry_plane_z);
        let around = |(drag, tail): (&Drag, _)| Surroundings { tail, rows: &rows, by: drag.by, half };
        let water = drag.as_ref().zip(tail.as_ref()).map(around);
        let began = context.thread_seconds();
        let twin = real_time::path((&reduced_body, water.as_ref()), marker, set.step, &actuation)?;
        let real_time_factor = twin.map(|_| (ends.1 - ends.0) / (context.thread_seconds() - began));
        let by_paper_model = paths.pop().unwrap_or_default();
        let simulated = paths.swap_remove(0);
        let pressures: Vec<Vec<f64>> = seen.gauges.iter().map(|g| g.onto(&seen.time)).collect();
        let quasi_static = QuasiStatic { pressures: &pressures, identified: &identified, marker };
        let guesses = baselines::all(&seen, &quasi_static, card.frequency);
        Ok(Validation {
            marker: films.first().map(|m| m.markers[marker].name.clone()).unwrap_or_default(),
            repeats: films.len(),
            lag: card.frequency.map(|f| lag(&seen.time, &seen.mean, &simulated, f)),
            rmse: scored[0].rmse,
            amplitude,
            length: card.body.length,
            zero_motion_rmse: repeats::rms(&seen.mean, &vec![[0.0; 2]; seen.mean.len()]),
            scored,
            baselines: guesses,
            reduction,
            twin_error,
            real_time_factor,
            coordinates: reduced_body.coordinates(),
            time: seen.time,
            measured: seen.mean,
            deviation: seen.deviation,
            simulated,
            by_paper_model,
            chambers: pressures.len(),
            pressures,
        })
    }
}

/// Root mean square difference of the reduced from the full model's motion, over the largest displacement of the latter; and the largest
/// distance of the reduced model as a twin, m, where its laws have one.
fn reduction(
    simulation: &MotionSimulation,
    reduced_body: &ReducedBody,
    settings: &DynamicSettings,
    actuation: &Actuation,
) -> Result<(f64, Option<Metre>)> {
    let twin = real_time::path((reduced_body, None), simulation.marker, settings.step, actuation)?;
    let (whole, reduced) = (simulation.whole(settings, actuation)?, simulation.run(reduced_body, settings, actuation)?);
    let steps = whole[0].values().len();
    let path = |[x, y]: &[Samples; 2]| (0..steps).map(|i| [x.values()[i], y.values()[i]]).collect::<Vec<Point2>>();
    let (whole, reduced, twin) = (path(&whole), path(&reduced), twin.map(|twin| path(&twin)));
    let farthest = whole.iter().map(|p| p[0].hypot(p[1])).fold(f64::MIN_POSITIVE, f64::max);
    let distance = |(a, b): (&Point2, &Point2)| (a[0] - b[0]).hypot(a[1] - b[1]);
    let off = twin.map(|twin| whole.iter().zip(&twin).map(distance).fold(0.0, f64::max));
    Ok((repeats::rms(&whole, &reduced) / farthest, off))
}

/// The commanded flapping frequency, Hz.
fn frequency(of: &Trial) -> Option<f64> {
    match of.trial.experiment {
        Experiment::Flapping { frequency, .. } => Some(frequency),
        Experiment::Staircase { .. } => None,
    }
}
