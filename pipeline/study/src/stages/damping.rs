//! Damping: the decay of the body's free vibration, from the last release of the films that identification may use.
//!
//! At the end of a staircase's last hold the chamber is opened and the tail vibrates freely. This motion is simulated in reduced coordinates with
//! several values of stiffness damping; the one with the smallest error is kept. No validation film is read.

use fem::Scheme;
use serde::{Deserialize, Serialize};
use si::{Metre, Second};

use super::fitting::mean_rest;
use super::simulation::{self, Actuation, MotionSimulation};
use crate::records::{self, Identified, Mesh, Motion, Reduced};
use crate::selections::IdentificationTrials;
use diagnostics::{Diagnostic, Result};
use sysid::{Body, ReducedBody};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Damping;

/// `[damping]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Time step of the second-order scheme, s.
    step: Second,
    /// Duration of the pressure ramp before the release, s: slow against the free vibration.
    ramp: Second,
    /// Duration after the release that is compared, s.
    duration: Second,
    /// Least and greatest stiffness damping, s.
    range: [Second; 2],
    /// Number of samples between them, even in the logarithm.
    samples: usize,
}

impl Stage for Damping {
    type Settings = Settings;
    type Card = Body;
    type Needs = (Mesh, Identified, Reduced, IdentificationTrials<Motion>);
    type Makes = records::Damping;
    const DESCRIPTION: &'static str = "the decay of a free vibration gives the damping";
    const VERSION: u32 = 5;

    fn run(
        card: &Self::Card,
        set: &Settings,
        needs: Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::Damping> {
        let (mesh, identified, reduced, films) = needs;
        let Some((_, motion)) = films.0.first() else {
            return Err(Diagnostic::new(
                "there is no film to identify damping from",
                "no trial has that role",
                "add one",
            ));
        };
        let model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &mean_rest(&films));
        let elastic = simulation::identified(&model, &identified);
        let simulation = MotionSimulation { model: &model, elastic, marker: card.tip_marker() };
        let gauges = simulation::gauges(motion)?;
        let begin = last_release(motion)?;
        let actuation =
            Actuation { begin: begin - set.ramp, end: begin + set.duration, ramp: set.ramp, gauges: &gauges };
        let reduced_body = ReducedBody::of(&model, &elastic, &reduced.data)?;
        let measured = &motion.markers[simulation.marker].at;
        let frames: Vec<usize> =
            (0..motion.time.len()).filter(|&i| motion.time[i] > begin && motion.time[i] < actuation.end).collect();
        let mut tried = Vec::new();
        for k in 0..set.samples {
            let part = k as f64 / (set.samples.max(2) - 1) as f64;
            let beta = set.range[0] * (set.range[1] / set.range[0]).powf(part);
            let path = simulation.run(
                &reduced_body,
                &simulation::dynamic_settings(Scheme::Bdf2, set.step, beta),
                &actuation,
            )?;
            let times: Vec<Second> = frames.iter().map(|&i| motion.time[i]).collect();
            let error =
                error(&simulation::onto(&path, &times), &frames.iter().map(|&i| measured[i]).collect::<Vec<_>>());
            tried.push((beta, error));
            context.progress((k + 1) as f64 / set.samples as f64, "releasing");
        }
        let (stiffness_damping, rmse) = lowest(&tried);
        Ok(records::Damping { stiffness_damping, rmse, tried })
    }
}

/// When the last command fell to nothing, s on the film's clock.
fn last_release(motion: &Motion) -> Result<Second> {
    let asked = |i: usize| motion.gauges.iter().any(|g| g.command[i] > 0.0);
    let last = (1..motion.log_time.len()).rev().find(|&i| asked(i - 1) && !asked(i));
    last.map(|i| motion.log_time[i]).ok_or_else(|| {
        Diagnostic::new("no chamber is ever released in the film", "its command never falls to 0", "film on")
    })
}

/// Root mean square difference of both about their own means: the equilibrium position does not depend on damping.
fn error(simulated: &[[f64; 2]], measured: &[[f64; 2]]) -> Metre {
    let off: Vec<[f64; 2]> = simulated.iter().zip(measured).map(|(s, m)| [s[0] - m[0], s[1] - m[1]]).collect();
    let count = off.len().max(1) as f64;
    let mean = [0, 1].map(|k| off.iter().map(|o| o[k]).sum::<f64>() / count);
    (off.iter().map(|o| (o[0] - mean[0]).powi(2) + (o[1] - mean[1]).powi(2)).sum::<f64>() / count).sqrt()
}

/// The vertex of the parabola through the lowest sample and its neighbours, over the logarithm.
fn lowest(tried: &[(Second, Metre)]) -> (Second, Metre) {
    let best = (0..tried.len()).min_by(|&a, &b| tried[a].1.total_cmp(&tried[b].1)).unwrap_or(0);
    if best == 0 || best + 1 >= tried.len() {
        return tried.get(best).copied().unwrap_or((0.0, f64::NAN));
    }
    let [a, b, c] = [-1, 0, 1].map(|k: isize| tried[best.saturating_add_signed(k)].1.powi(2));
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    let ratio = tried[best + 1].0 / tried[best].0;
    (tried[best].0 * ratio.powf(shift), tried[best].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_in_the_logarithm_is_met_at_its_lowest() {
        let square = |beta: f64| (1.0 + (beta / 3e-3).ln().powi(2)).sqrt();
        let tried: Vec<(f64, f64)> = [1e-3, 2e-3, 4e-3, 8e-3].iter().map(|&b| (b, square(b))).collect();
        assert!((lowest(&tried).0 / 3e-3 - 1.0).abs() < 1e-9);
    }
}
