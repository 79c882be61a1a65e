//! Validate: a flapping motion that identification never saw, simulated with the identified moduli and compared, at the marker
//! farthest out, with the mean of its repeats. Paper: section VI, dynamic experiments.
//!
//! One simulation serves all repeats of a condition: it is driven by the mean of their measured pressures, laid over one another
//! at the first command. It runs in reduced coordinates; its first part is marched by the whole model too, and how far the two
//! are apart is said. In water the reduced model swings with the added mass and the drag that a release told; the whole one has
//! no water, and is not asked.
//!
//! Stands on: the swing, the bath of `drag`. Never knows: how the moduli were found.

use fem::{March, Scheme};
use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Point2, Second};
use signal::resample::Samples;

use super::damping::swing_marker;
use super::drag::Bath;
use super::swing::{self, Drive, Swing};
use super::{baselines, repeats};
use crate::fault::{Fault, Outcome};
use crate::model::{Model, Small};
use crate::needs::{InWater, Repeats};
use crate::records::{Damping, Drag, Identified, Mesh, Motion, Reduced, Validation, Way};
use crate::stage::{Desk, Stage};
use crate::subject::{Specimen, Trial};
use crate::thrust::outline::Outline;

/// The stage.
pub struct Validate;

/// `[validate]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Time step of the second-order scheme, s.
    step: Second,
    /// Time step of implicit Euler, the paper's scheme, s.
    euler_step: Second,
    /// How long after the first command the whole model is marched as well, to say how far the reduced one is off, s.
    checked: Second,
}

impl Stage for Validate {
    type Settings = Settings;
    type Needs = ((Mesh, Identified, Reduced), Damping, InWater<Drag>, Repeats<Motion>);
    type Makes = Validation;
    const STORY: &'static str = "flapping never seen is predicted and compared";
    const EDITION: u32 = 8;

    fn card(of: &Trial) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio, s.density]);
        json!({
            "body": region(&solid.body),
            "spine": region(&solid.spine),
            "clamp": card.clamp.below_x,
            "length": card.length,
            "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>(),
            "frequency": frequency(of),
        })
    }

    fn run(of: &Trial, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<Validation> {
        let ((mesh, identified, reduced), damping, InWater(drag), Repeats(films)) = needs;
        let specimen = Specimen { card: of.card.clone() };
        let marker = swing_marker(&specimen);
        let rest = films.first().map(|m| m.rest.clone()).unwrap_or_default();
        let whole =
            |d: &Drag| Outline::new(&of.card, &mesh.solid).whole(d.density, d.sections).map_err(Fault::from_tool);
        let wet = drag.as_ref().map(whole).transpose()?;
        let (tail, spots) = wet.unzip();
        let model = Model::new(&mesh, &of.card)?.seen_at(&mesh, &of.card, &rest).and(spots.unwrap_or_default());
        let swing = Swing { model: &model, elastic: swing::identified(&model, &identified), marker };
        let seen = repeats::gather(&films, marker)?;
        let ends = (seen.time[0], seen.time[seen.time.len() - 1]);
        let drive = Drive { begin: ends.0, end: ends.1, eased: 0.0, gauges: &seen.gauges };
        let small = Small::of(&model, &swing.elastic, &reduced.kept)?;
        let damped = swing::march(Scheme::Bdf2, set.step, damping.stiffness_damping);
        let ways = [
            ("bdf2", damped),
            ("bdf2_undamped", swing::march(Scheme::Bdf2, set.step, 0.0)),
            ("implicit_euler", swing::march(Scheme::ImplicitEuler, set.euler_step, 0.0)),
        ];
        let march = |march: March| match (&drag, &tail) {
            (Some(Drag { by, .. }), Some(tail)) => {
                Bath::new(&small, tail, marker, of.card.marker.len(), march, mesh.solid.half).path(*by, &drive)
            }
            _ => swing.run(&small, &march, &drive),
        };
        let (mut scored, mut paths) = (Vec::new(), Vec::new());
        for (name, way) in ways {
            let path = swing::onto(&march(way)?, &seen.time);
            scored.push(Way { name: name.into(), rmse: repeats::rms(&seen.mean, &path) });
            paths.push(path);
        }
        desk.progress(0.6, "checking it against the whole model");
        let checked = Drive { end: (seen.moves + set.checked).min(ends.1), begin: seen.moves, ..drive };
        let dry = drag.is_none().then(|| reduction(&swing, &small, &damped, &checked));
        let simulated = paths.swap_remove(0);
        let pressures: Vec<Vec<f64>> = seen.gauges.iter().map(|g| g.onto(&seen.time)).collect();
        let guesses = baselines::all(&seen, &pressures, &identified, marker, frequency(of));
        Ok(Validation {
            marker: films.first().map(|m| m.markers[marker].name.clone()).unwrap_or_default(),
            repeats: films.len(),
            lag: frequency(of).map(|f| lag(&seen.time, &seen.mean, &simulated, f)),
            rmse: scored[0].rmse,
            length: of.card.length,
            rest_rmse: repeats::rms(&seen.mean, &vec![[0.0; 2]; seen.mean.len()]),
            scored,
            baselines: guesses,
            reduction: dry.transpose()?,
            coordinates: small.coordinates(),
            time: seen.time,
            measured: seen.mean,
            deviation: seen.deviation,
            simulated,
            pressures,
        })
    }
}

/// Root of the mean squared distance of the reduced model's motion from the whole one's, over the farthest that the whole moves.
fn reduction(swing: &Swing, small: &Small, march: &March, drive: &Drive) -> Outcome<f64> {
    let (whole, reduced) = (swing.whole(march, drive)?, swing.run(small, march, drive)?);
    let steps = whole[0].values().len();
    let path = |[x, y]: &[Samples; 2]| (0..steps).map(|i| [x.values()[i], y.values()[i]]).collect::<Vec<Point2>>();
    let (whole, reduced) = (path(&whole), path(&reduced));
    let farthest = whole.iter().map(|p| p[0].hypot(p[1])).fold(f64::MIN_POSITIVE, f64::max);
    Ok(repeats::rms(&whole, &reduced) / farthest)
}

/// The flapping frequency that was asked for, Hz.
fn frequency(of: &Trial) -> Option<f64> {
    match of.trial.experiment {
        Experiment::Flapping { frequency, .. } => Some(frequency),
        Experiment::Staircase { .. } => None,
    }
}

/// By how much the simulated sideways motion is behind the measured one at the beat's frequency, s.
fn lag(time: &[Second], measured: &[Point2], simulated: &[Point2], frequency: f64) -> Second {
    let turn = std::f64::consts::TAU * frequency;
    let phase = |path: &[Point2]| {
        let part = |by: fn(f64) -> f64| time.iter().zip(path).map(|(t, p)| p[1] * by(turn * t)).sum::<f64>();
        part(f64::sin).atan2(part(f64::cos))
    };
    let behind = phase(simulated) - phase(measured);
    let half = std::f64::consts::PI;
    ((behind + half).rem_euclid(2.0 * half) - half) / turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_ten_milliseconds_behind_is_said_to_be() {
        let time: Vec<f64> = (0..120).map(|i| f64::from(i) / 60.0).collect();
        let path = |late: f64| -> Vec<Point2> {
            time.iter().map(|t| [0.0, (std::f64::consts::TAU * 2.0 * (t - late)).sin()]).collect()
        };
        // two seconds at 2 Hz are whole beats: no leak
        assert!((lag(&time, &path(0.0), &path(0.01), 2.0) - 0.01).abs() < 1e-9);
    }
}
