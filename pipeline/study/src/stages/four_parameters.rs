//! Four parameters: both Young's moduli and both Poisson's ratios of the levels that identification used, by bounded
//! Gauss-Newton to convergence. Paper: section V, the search with four parameters.
//!
//! The parameters are the logarithms of the moduli and of ½ − ν, on which the response of a nearly incompressible body depends. The search
//! begins at the card's values.

use fem::StaticSettings;
use optimize::optimisers::{self, gauss_newton};
use optimize::{Bounds, Evaluation, Needs, Problem};
use serde::{Deserialize, Serialize};

use diagnostics::{Diagnostic, Result};
use records::{self, Four, Identified, Mesh, Uncertainty};
use sysid::Interrupted;
use sysid::Misfit;
use sysid::{Body, Derivatives, Elastic, LevelSolver, Model, residuals_of};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct FourParameters;

/// `[four_parameters]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Bounds of ν of the body.
    body_nu: [f64; 2],
    /// Bounds of ν of the spine.
    spine_nu: [f64; 2],
    /// Simulations at most.
    iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    step_tolerance: f64,
    /// As in `[identify]`.
    static_tolerance: f64,
    /// As in `[identify]`.
    parallel_solves: usize,
}

/// Names of the parameters in messages and figures.
const NAMES: [&str; 4] = ["E of body", "E of spine", "compressibility of body", "compressibility of spine"];

impl Stage for FourParameters {
    type Settings = Settings;
    type Card = Body;
    type Needs = (Mesh, Identified);
    type Makes = records::FourParameters;
    const DESCRIPTION: &'static str = "both Poisson's ratios are identified as well";
    const VERSION: u32 = 10;

    fn run(
        card: &Self::Card,
        set: &Settings,
        needs: Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::FourParameters> {
        let (mesh, identified) = needs;
        let rest_positions = identified.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
        let mut model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &rest_positions);
        model.nominal = Elastic { youngs_moduli: model.nominal.youngs_moduli.clone(), ..identified.elastic(&model) };
        let levels = Misfit::of_record(&identified.levels, &identified.noise, identified.length)?;
        let search = search_problem(card, set, &model)?;
        let fit = Fit { set, model: &model, levels: &levels };
        let (best, losses) = fit.minimise_from_rest(&search, context)?;
        let uncertainty = posterior_uncertainty(&best)?;
        let iterates =
            losses.iter().map(|(point, loss)| (four_constants(&elastic_constants(&model, point)), *loss)).collect();
        let four_best = four_constants(&elastic_constants(&model, &best.at));
        let plausible = [card.materials[0].plausible, card.materials[1].plausible, set.body_nu, set.spine_nu];
        Ok(records::FourParameters { best: four_best, loss: best.loss, iterates, plausible, uncertainty })
    }
}

/// The bounds, with the card's constants as the starting point.
fn search_problem(card: &Body, set: &Settings, model: &Model) -> Result<Problem> {
    let nominal = &model.nominal;
    let moduli = |k: usize| [0, 1].map(|r: usize| (card.materials[r].plausible[k] / nominal.youngs_moduli[r]).ln());
    let ratio = |r: usize, nu: f64| ((0.5 - nu) / (0.5 - nominal.poissons_ratios[r])).ln();
    let [low, high] = [0, 1].map(moduli);
    let low = [&low[..], &[ratio(0, set.body_nu[1]), ratio(1, set.spine_nu[1])]].concat();
    let high = [&high[..], &[ratio(0, set.body_nu[0]), ratio(1, set.spine_nu[0])]].concat();
    let bounds = Bounds { low, high };
    let start = bounds.clamp(&[0.0; 4]);
    Problem::new(&NAMES, start, bounds).map_err(Diagnostic::from)
}

fn elastic_constants(model: &Model, point: &[f64]) -> Elastic {
    let Elastic { youngs_moduli, poissons_ratios, stiffening } = &model.nominal;
    let modulus = |r: usize| youngs_moduli[r] * point[r].exp();
    let ratio = |r: usize| 0.5 - (0.5 - poissons_ratios[r]) * point[2 + r].exp();
    Elastic {
        youngs_moduli: vec![modulus(0), modulus(1)],
        poissons_ratios: vec![ratio(0), ratio(1)],
        stiffening: *stiffening,
    }
}

fn four_constants(elastic: &Elastic) -> Four {
    let (e, nu) = (&elastic.youngs_moduli, &elastic.poissons_ratios);
    Four { body_e_pa: e[0], spine_e_pa: e[1], body_nu: nu[0], spine_nu: nu[1] }
}

/// A point and its loss.
type Iterate = (Vec<f64>, f64);

/// The least squares problem of the four parameters.
#[derive(Clone, Copy)]
struct Fit<'a> {
    set: &'a Settings,
    model: &'a Model,
    /// The levels that identification used.
    levels: &'a Misfit,
}

impl Fit<'_> {
    /// Gauss-Newton to convergence; every point of the search with its loss is returned as well.
    fn minimise_from_rest(&self, search: &Problem, context: &dyn StageContext) -> Result<(Evaluation, Vec<Iterate>)> {
        let statics = StaticSettings { tolerance: self.set.static_tolerance, ..StaticSettings::default() };
        let (levels, parallel) = (self.levels.levels.clone(), self.set.parallel_solves);
        self.minimise(search, &mut LevelSolver::new(self.model.clone(), levels, statics, parallel), context)
    }

    fn minimise(
        &self,
        search: &Problem,
        solver: &mut LevelSolver,
        context: &dyn StageContext,
    ) -> Result<(Evaluation, Vec<Iterate>)> {
        let Self { set, model, levels } = *self;
        let mut losses = Vec::new();
        let newton = gauss_newton::Settings {
            step_tolerance: set.step_tolerance,
            fall_tolerance: gauss_newton::FALL,
            iterations: set.iterations,
            ..gauss_newton::Settings::default()
        };
        let mut settings = optimisers::Settings::default();
        settings.gauss_newton = newton;
        let Some(member) = optimisers::by_name(gauss_newton::NAME) else {
            return Err(Diagnostic::new("there is no gauss_newton", "`optimize` does not list it", "restore it"));
        };
        let mut optimiser = (member.build)(search, &settings)?;
        let mut evaluate = |point: &Vec<f64>| -> Result<Evaluation> {
            let constants = elastic_constants(model, point);
            let Ok(simulated) = solver.solve(&constants, Derivatives::AllSensitivities) else {
                return Ok(Evaluation::of_loss(point.clone(), f64::INFINITY));
            };
            let markers: Vec<_> = simulated.iter().map(|l| l.markers.clone()).collect();
            let loss = levels.loss(&markers);
            losses.push((point.clone(), loss));
            context.progress(losses.len() as f64 / set.iterations as f64, &format!("simulation {}", losses.len()));
            let compressibilities = constants.poissons_ratios.iter().map(|nu| nu - 0.5);
            let parameters: Vec<f64> = constants.youngs_moduli.iter().copied().chain(compressibilities).collect();
            let residuals = levels.residuals(&simulated, &parameters)?;
            Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(point.clone(), loss) })
        };
        let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            batch.iter().map(|point| evaluate(point).map_err(Interrupted)).collect()
        };
        let best = optimize::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?.best;
        Ok((best, losses))
    }
}

fn posterior_uncertainty(best: &Evaluation) -> Result<Uncertainty> {
    let residuals = residuals_of(best)?;
    let posterior = residuals.posterior(4)?;
    Ok(Uncertainty {
        sigma: (0..4).map(|k| posterior.sigma(k)).collect(),
        correlation: (0..16).map(|k| posterior.correlation(k / 4, k % 4)).collect(),
        chi_square: residuals.reduced_chi_square(4),
        words: posterior.summary(&NAMES),
        ..Uncertainty::default()
    })
}
