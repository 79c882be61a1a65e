//! Damping: how fast the body's swing dies, from the last release of the films that identification may see.
//!
//! At the end of a staircase's last hold the chamber is opened and the tail swings back. The motion from there is simulated, in reduced coordinates, with
//! several stiffness dampings; the one whose tail follows the film best is kept. No validation film is touched.
//!
//! Stands on: the swing. Never knows: a validation trial; its needs hand it none.

use fem::Scheme;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Second};

use super::fitting::mean_rest;
use super::swing::{self, Drive, Swing};
use crate::fault::{Fault, Outcome};
use crate::model::{Model, Small};
use crate::needs::Learning;
use crate::records::{self, Identified, Mesh, Motion, Reduced};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Damping;

/// `[damping]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Time step of the second-order scheme, s.
    step: Second,
    /// How long before the release the simulated tail is bent, s: gently against its swing.
    ease: Second,
    /// How long after the release the film is followed, s.
    follow: Second,
    /// Least and greatest stiffness damping that are tried, s.
    range: [Second; 2],
    /// How many are tried between them, evenly in their logarithm.
    tries: usize,
}

impl Stage for Damping {
    type Settings = Settings;
    type Needs = (Mesh, Identified, Reduced, Learning<Motion>);
    type Makes = records::Damping;
    const STORY: &'static str = "a released tail's swing becomes its damping";
    const EDITION: u32 = 4;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio, s.density]);
        json!({ "body": region(&solid.body), "spine": region(&solid.spine), "clamp": card.clamp.below_x })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<records::Damping> {
        let (mesh, identified, reduced, films) = needs;
        let Some((_, motion)) = films.0.first() else {
            return Err(Fault::new("there is no film to learn damping from", "no trial has that role", "add one"));
        };
        let model = Model::new(&mesh, &of.card)?.seen_at(&mesh, &of.card, &mean_rest(&films));
        let elastic = swing::identified(&model, &identified);
        let swing = Swing { model: &model, elastic, marker: swing_marker(of) };
        let gauges = swing::gauges(motion)?;
        let begin = last_release(motion)?;
        let drive = Drive { begin: begin - set.ease, end: begin + set.follow, eased: set.ease, gauges: &gauges };
        let small = Small::of(&model, &elastic, &reduced.kept)?;
        let measured = &motion.markers[swing.marker].at;
        let frames: Vec<usize> =
            (0..motion.time.len()).filter(|&i| motion.time[i] > begin && motion.time[i] < drive.end).collect();
        let mut tried = Vec::new();
        for k in 0..set.tries {
            let part = k as f64 / (set.tries.max(2) - 1) as f64;
            let beta = set.range[0] * (set.range[1] / set.range[0]).powf(part);
            let path = swing.run(&small, &swing::march(Scheme::Bdf2, set.step, beta), &drive)?;
            let times: Vec<Second> = frames.iter().map(|&i| motion.time[i]).collect();
            let error = error(&swing::onto(&path, &times), &frames.iter().map(|&i| measured[i]).collect::<Vec<_>>());
            tried.push((beta, error));
            desk.progress((k + 1) as f64 / set.tries as f64, "releasing");
        }
        let (stiffness_damping, rmse) = lowest(&tried);
        Ok(records::Damping { stiffness_damping, rmse, tried })
    }
}

/// The marker farthest out.
pub fn swing_marker(of: &Specimen) -> usize {
    let order = |a: &usize, b: &usize| of.card.marker[*a].at[0].total_cmp(&of.card.marker[*b].at[0]);
    (0..of.card.marker.len()).max_by(order).unwrap_or(0)
}

/// When the last command fell to nothing, s on the film's clock.
fn last_release(motion: &Motion) -> Outcome<Second> {
    let asked = |i: usize| motion.gauges.iter().any(|g| g.command[i] > 0.0);
    let last = (1..motion.log_time.len()).rev().find(|&i| asked(i - 1) && !asked(i));
    last.map(|i| motion.log_time[i])
        .ok_or_else(|| Fault::new("no chamber is ever released in the film", "its command never falls to 0", "film on"))
}

/// Root of the mean square of what is left when both are taken from their own means: where it swings about is not damping.
fn error(simulated: &[[f64; 2]], measured: &[[f64; 2]]) -> Metre {
    let off: Vec<[f64; 2]> = simulated.iter().zip(measured).map(|(s, m)| [s[0] - m[0], s[1] - m[1]]).collect();
    let count = off.len().max(1) as f64;
    let mean = [0, 1].map(|k| off.iter().map(|o| o[k]).sum::<f64>() / count);
    (off.iter().map(|o| (o[0] - mean[0]).powi(2) + (o[1] - mean[1]).powi(2)).sum::<f64>() / count).sqrt()
}

/// The lowest point of the parabola through the lowest try and its neighbours, over the logarithm.
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
