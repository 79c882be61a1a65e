//! Four parameters: both Young's moduli and both Poisson's ratios of the levels that identification used, by bounded
//! Gauss-Newton to convergence. Paper: section V, the search with four parameters.
//!
//! Moduli are searched in logarithms; ν in the logarithm of ½ − ν, which is what a nearly incompressible body feels.
//!
//! Stands on: the levels, the ladder, fit. Never knows: a film.

use fem::StaticSettings;
use fit::optimisers::{self, gauss_newton};
use fit::{Bounds, Evaluation, Needs, Search};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::levels::Levels;
use super::stop::Stop;
use crate::fault::{Fault, Outcome};
use crate::model::{Elastic, Ladder, Model, Want};
use crate::records::{self, Certainty, Four, Identified, Mesh};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct FourParameters;

/// `[four_parameters]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What ν of the body could be: the box that is searched.
    body_nu: [f64; 2],
    /// The same of the spine.
    spine_nu: [f64; 2],
    /// Simulations at most.
    iterations: usize,
    /// It has converged when no logarithm moves by more.
    step_tolerance: f64,
    /// As in `[identify]`.
    static_tolerance: f64,
    /// As in `[identify]`.
    side_by_side: usize,
}

/// The parameters, as messages and figures name them.
const NAMES: [&str; 4] = ["E of body", "E of spine", "compressibility of body", "compressibility of spine"];

impl Stage for FourParameters {
    type Settings = Settings;
    type Needs = (Mesh, Identified);
    type Makes = records::FourParameters;
    const STORY: &'static str = "both Poisson's ratios are sought as well";
    const EDITION: u32 = 2;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.youngs_modulus, s.poissons_ratio, s.plausible]);
        json!({ "body": region(&solid.body), "spine": region(&solid.spine), "clamp": card.clamp.below_x,
                "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>() })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<records::FourParameters> {
        let (mesh, found) = needs;
        let rest = found.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
        let model = Model::new(&mesh, &of.card)?.seen_at(&mesh, &of.card, &rest);
        let levels = Levels::kept(&found.levels, &found.doubt, found.length)?;
        let search = search(of, set, &model, &found)?;
        let mut losses = Vec::new();
        let best = walk(set, &model, &levels, &search, &mut losses, desk)?;
        let certainty = certainty(&best)?;
        let iterates = losses.iter().map(|(at, loss)| (four(&elastic(&model, at)), *loss)).collect();
        let four_best = four(&elastic(&model, &best.at));
        let plausible = [of.card.solid.body.plausible, of.card.solid.spine.plausible, set.body_nu, set.spine_nu];
        Ok(records::FourParameters { best: four_best, loss: best.loss, iterates, plausible, certainty })
    }
}

/// The box, begun at the two moduli that were identified.
fn search(of: &Specimen, set: &Settings, model: &Model, found: &Identified) -> Outcome<Search> {
    let nominal = model.nominal;
    let solids = [&of.card.solid.body, &of.card.solid.spine];
    let moduli = |k: usize| [0, 1].map(|r: usize| (solids[r].plausible[k] / nominal.youngs_moduli[r]).ln());
    let ratio = |r: usize, nu: f64| ((0.5 - nu) / (0.5 - nominal.poissons_ratios[r])).ln();
    let [low, high] = [0, 1].map(moduli);
    let low = [&low[..], &[ratio(0, set.body_nu[1]), ratio(1, set.spine_nu[1])]].concat();
    let high = [&high[..], &[ratio(0, set.body_nu[0]), ratio(1, set.spine_nu[0])]].concat();
    let bounds = Bounds { low, high };
    let [body, spine] = nominal.youngs_moduli;
    let wish = [(found.best.body_e_pa / body).ln(), (found.best.spine_e_pa / spine).ln(), 0.0, 0.0];
    let start = bounds.clamp(&wish);
    Search::new(&NAMES, start, bounds).map_err(Fault::from_tool)
}

fn elastic(model: &Model, at: &[f64]) -> Elastic {
    let Elastic { youngs_moduli: [body, spine], poissons_ratios } = model.nominal;
    let ratio = |r: usize| 0.5 - (0.5 - poissons_ratios[r]) * at[2 + r].exp();
    Elastic { youngs_moduli: [body * at[0].exp(), spine * at[1].exp()], poissons_ratios: [ratio(0), ratio(1)] }
}

fn four(at: &Elastic) -> Four {
    let ([body_e_pa, spine_e_pa], [body_nu, spine_nu]) = (at.youngs_moduli, at.poissons_ratios);
    Four { body_e_pa, spine_e_pa, body_nu, spine_nu }
}

/// Gauss-Newton to convergence; every point and its loss is kept.
fn walk(
    set: &Settings,
    model: &Model,
    levels: &Levels,
    search: &Search,
    losses: &mut Vec<(Vec<f64>, f64)>,
    desk: &dyn Desk,
) -> Outcome<Evaluation> {
    let statics = StaticSettings { tolerance: set.static_tolerance, halvings: 2, ..StaticSettings::default() };
    let mut ladder = Ladder::new(model.clone(), levels.rungs.clone(), statics, set.side_by_side);
    let newton = gauss_newton::Settings {
        step_tolerance: set.step_tolerance,
        iterations: set.iterations,
        ..gauss_newton::Settings::default()
    };
    let settings = optimisers::Settings { gauss_newton: newton, ..optimisers::Settings::default() };
    let Some(member) = optimisers::by_name(gauss_newton::NAME) else {
        return Err(Fault::from_tool("`fit` lists no gauss_newton"));
    };
    let mut optimiser = (member.build)(search, &settings).map_err(Fault::from_tool)?;
    let mut evaluate = |at: &Vec<f64>| -> Outcome<Evaluation> {
        desk.progress(losses.len() as f64 / set.iterations as f64, "four parameters");
        let constants = elastic(model, at);
        let Ok(shown) = ladder.climb(&constants, Want::AllSlopes) else {
            return Ok(Evaluation::of_loss(at.clone(), f64::INFINITY));
        };
        let markers: Vec<_> = shown.iter().map(|l| l.markers.clone()).collect();
        let loss = levels.loss(&markers);
        losses.push((at.clone(), loss));
        let Elastic { youngs_moduli: [body, spine], poissons_ratios: [n, m] } = constants;
        let residuals = levels.residuals(&shown, &[body, spine, n - 0.5, m - 0.5])?;
        Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(at.clone(), loss) })
    };
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Stop> {
        batch.iter().map(|at| evaluate(at).map_err(Stop)).collect()
    };
    Ok(fit::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?.best)
}

fn certainty(best: &Evaluation) -> Outcome<Certainty> {
    let Some(residuals) = &best.residuals else {
        return Err(Fault::from_tool("the best point of the search came without its residuals"));
    };
    let posterior = residuals.posterior(4).map_err(Fault::from_tool)?;
    Ok(Certainty {
        sigma: (0..4).map(|k| posterior.sigma(k)).collect(),
        correlation: posterior.correlation(0, 1),
        chi_square: residuals.reduced_chi_square(4),
        words: posterior.in_words(&NAMES),
        advice: Vec::new(),
    })
}
