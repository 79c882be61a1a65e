//! Identify: the Young's moduli with which the simulation follows the quasi-static films best. Paper: section V.
//!
//! The plane of both moduli is searched in logarithms over the card's nominal values. The answer is the Gauss-Newton method's; on
//! the specimens that are compared, every other method of `fit` searches the same plane.
//!
//! Stands on: the model, fit. Never knows: a validation trial; its needs hand it none.

use fit::optimisers::{self, gauss_newton, grid};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Second};

use super::fitting::{Films, Fitting};
use crate::fault::{Fault, Outcome};
use crate::records::{Identified, Mesh};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Identify;

/// `[identify]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The part at the end of each hold that counts as settled, 0 to 1.
    pub(super) settled: f64,
    /// The shortest hold that counts, s.
    pub(super) shortest_hold: Second,
    /// Standard deviation of a measured displacement beside its covariance: what the model leaves out, m.
    pub(super) discrepancy: Metre,
    /// Standard deviation of the share by which all displacements of a film are off together, no unit.
    pub(super) share: f64,
    /// Specimens whose plane every method searches, to be compared; the others are left to Gauss-Newton.
    pub(super) compared: Vec<String>,
    /// Points an axis of the exhaustive search.
    pub(super) grid_points: usize,
    /// CMA-ES's generations at most, ten simulations each; the paper made four.
    pub(super) cma_es_generations: usize,
    /// Where its draws come from.
    pub(super) cma_es_seed: u64,
    /// Length of Adam's step, in logarithms of moduli.
    pub(super) adam_step: f64,
    /// How fast it shrinks, 1/iterations.
    pub(super) adam_step_decay: f64,
    /// β₁ of Adam.
    pub(super) adam_mean_memory: f64,
    /// β₂ of Adam.
    pub(super) adam_square_memory: f64,
    /// Adam's simulations at most.
    pub(super) adam_iterations: usize,
    /// Gauss-Newton's simulations at most.
    pub(super) gauss_newton_iterations: usize,
    /// A search has converged when no logarithm of a modulus moves by more.
    pub(super) step_tolerance: f64,
    /// Newton has converged when no node moves by more than this part of the specimen's size.
    pub(super) static_tolerance: f64,
    /// Equilibria solved side by side.
    pub(super) side_by_side: usize,
    /// Points an axis of the drawn landscape.
    pub(super) landscape_points: usize,
}

impl Stage for Identify {
    type Settings = Settings;
    type Needs = (Mesh, Films);
    type Makes = Identified;
    const STORY: &'static str = "quasi-static motion becomes Young's moduli";
    const EDITION: u32 = 6;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region =
            |s: &lab::card::Solid| json!([s.material, s.youngs_modulus, s.poissons_ratio, s.density, s.plausible]);
        json!({ "body": region(&solid.body), "spine": region(&solid.spine), "clamp": card.clamp.below_x, "length": card.length, "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>() })
    }

    fn run(of: &Specimen, set: &Settings, (mesh, films): Self::Needs, desk: &dyn Desk) -> Outcome<Identified> {
        let fitting = Fitting::new(of, set, &mesh, &films)?;
        let compared = set.compared.contains(&of.card.name);
        let chosen = || optimisers::ALL.iter().filter(|member| compared || member.name == gauss_newton::NAME);
        let (mut searches, mut best, mut told) = (Vec::new(), None, Vec::new());
        for (i, member) in chosen().enumerate() {
            desk.progress((i + 1) as f64 / (chosen().count() + 1) as f64, member.name);
            let began = desk.seconds();
            let found = fitting.search(member)?;
            searches.push(fitting.record(member.name, &found.history, desk.seconds() - began));
            match member.name {
                grid::NAME => told = found.told,
                gauss_newton::NAME => best = Some(found),
                _ => {}
            }
        }
        let Some(best) = best else {
            return Err(Fault::new("identification needs gauss_newton", "`fit` does not list it", "restore it"));
        };
        let gradient_difference = compared.then(|| fitting.gradient_difference()).transpose()?;
        fitting.conclude(best, &told, searches, gradient_difference, desk)
    }
}
