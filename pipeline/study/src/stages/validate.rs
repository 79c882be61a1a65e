//! Validate: a flapping motion that identification never saw, simulated by implicit Euler with the identified moduli and
//! compared at the marker farthest out. Paper: section VI, dynamic experiments.
//!
//! Stands on: the model. Never knows: how the moduli were found.

use std::cell::RefCell;

use fem::{March, Scheme, State};
use lab::card::Card;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Pascal, Point2, Second};
use signal::resample::Samples;

use crate::fault::{Fault, Outcome};
use crate::model::Model;
use crate::records::{Identified, Mesh, Motion, Validation};
use crate::stage::{Desk, Stage};
use crate::subject::Trial;

/// The stage.
pub struct Validate;

/// `[validate]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Time step of implicit Euler, s.
    step: Second,
    /// Rayleigh damping proportional to mass, 1/s; the paper has none.
    mass_damping: f64,
    /// Rayleigh damping proportional to stiffness, s; the paper has none.
    stiffness_damping: f64,
}

impl Stage for Validate {
    type Settings = Settings;
    type Needs = (Mesh, Identified, Motion);
    type Makes = Validation;
    const STORY: &'static str = "flapping never seen is predicted and compared";
    const EDITION: u32 = 1;

    fn card(of: &Trial) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio, s.density]);
        json!({
            "body": region(&solid.body),
            "spine": region(&solid.spine),
            "clamp": card.clamp.below_x,
            "length": card.length,
            "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>(),
        })
    }

    fn run(
        of: &Trial,
        set: &Settings,
        (mesh, identified, motion): Self::Needs,
        desk: &dyn Desk,
    ) -> Outcome<Validation> {
        let farthest = farthest(&of.card);
        let measured = &motion.markers[farthest];
        let gauges = gauges(&motion)?;
        let path = simulate(of, set, &mesh, &identified, &gauges, &motion.time, farthest, desk)?;
        let pressures = gauges.iter().map(|g| g.onto(&motion.time)).collect();
        let (rmse, rest_rmse) = (rms(&measured.at, &path), rms(&measured.at, &vec![[0.0; 2]; measured.at.len()]));
        Ok(Validation {
            marker: measured.name.clone(),
            time: motion.time,
            measured: measured.at.clone(),
            simulated: path,
            pressures,
            rmse,
            length: of.card.length,
            rest_rmse,
        })
    }
}

/// The marker with the largest x.
fn farthest(card: &Card) -> usize {
    let order = |a: &usize, b: &usize| card.marker[*a].at[0].total_cmp(&card.marker[*b].at[0]);
    (0..card.marker.len()).max_by(order).unwrap_or(0)
}

fn gauges(motion: &Motion) -> Outcome<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Fault::from_tool)
}

/// Displacement of one marker at the times of the frames, m: frames × 2.
#[allow(clippy::too_many_arguments)]
fn simulate(
    of: &Trial,
    set: &Settings,
    mesh: &Mesh,
    identified: &Identified,
    gauges: &[Samples],
    times: &[Second],
    marker: usize,
    desk: &dyn Desk,
) -> Outcome<Vec<Point2>> {
    let model = Model::new(mesh, &of.card)?;
    let mut solver = model.system.solver();
    model.set_moduli(&mut solver, [identified.best.body_e_pa, identified.best.spine_e_pa])?;
    let (begin, end) = (times[0], times[times.len() - 1]);
    let steps = ((end - begin) / set.step).ceil() as usize;
    let march = March {
        step: set.step,
        scheme: Scheme::ImplicitEuler,
        mass_damping: set.mass_damping,
        stiffness_damping: set.stiffness_damping,
        ..March::default()
    };
    let log = RefCell::new((vec![begin], vec![[0.0; 2]]));
    let pressures = |t: Second| -> Vec<Pascal> { gauges.iter().map(|g| g.at(begin + t)).collect() };
    let mut observe = |t: Second, state: &State| {
        let mut log = log.borrow_mut();
        log.0.push(begin + t);
        log.1.push(Model::in_plane(&model.markers[marker], &state.displacement));
        desk.progress(t / (end - begin), "flapping");
    };
    let initial = State::rest(model.system.mesh().nodes.len());
    solver.march(&march, &initial, &pressures, steps, &mut observe).map_err(Fault::from_tool)?;
    let (at, path) = log.into_inner();
    onto(&at, &path, times)
}

fn onto(at: &[Second], path: &[Point2], times: &[Second]) -> Outcome<Vec<Point2>> {
    let axis = |k: usize| Samples::new(at.to_vec(), path.iter().map(|p| p[k]).collect()).map_err(Fault::from_tool);
    let (x, y) = (axis(0)?, axis(1)?);
    Ok(times.iter().map(|&t| [x.at(t), y.at(t)]).collect())
}

fn rms(a: &[Point2], b: &[Point2]) -> Metre {
    let squares: f64 = a.iter().zip(b).map(|(p, q)| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}
