//! Method comparison: every method of `optimize` searches the loss of the identification over the same bounds. Paper: section V, table III
//! and figure 5.
//!
//! It is a stage of its own because nothing else waits for it, and it may take longer than the identification. The stiffening is that of the
//! identification, so that the search is over two moduli as in the paper; it begins at the card's values. The landscape is interpolated
//! between the points of the exhaustive search.
//!
//! All methods search in a reduced model of the body on the study's own mesh, which the whole body certifies at the end of each, and the
//! landscape is simulated in it: on whole bodies of 66,000 unknowns and 14 levels, four methods cut short took more than two hours.

use optimize::Problem;
use optimize::optimisers::{self, adam, cma_es, grid};
use serde::{Deserialize, Serialize};

use super::gradients::gradient_difference;
use super::loss_surface::loss_surface;
use super::walls::WallGauge;
use diagnostics::Result;
use records::subject::Specimen;
use records::{EvaluatedPoint, Identified, Mesh, MethodComparison, Profile, Search, Surface};
use si::Second;
use sysid::{Body, LevelSolver, Loss, Misfit, PressureLevel, SearchResult, TrainedBox, statics};
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Comparison;

/// `[method_comparison]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Specimens on which every method is run.
    specimens: Vec<String>,
    /// Points an axis of the exhaustive search.
    grid_points: usize,
    /// CMA-ES's generations at most, ten simulations each.
    cma_es_generations: usize,
    /// Seed of its random numbers.
    cma_es_seed: u64,
    /// Length of Adam's step, in logarithms of moduli.
    adam_step: f64,
    /// Decay of the step, 1/iterations.
    adam_step_decay: f64,
    /// β₁ of Adam.
    adam_mean_decay: f64,
    /// β₂ of Adam.
    adam_square_decay: f64,
    /// Adam's simulations at most.
    adam_iterations: usize,
    /// Gauss-Newton's simulations at most.
    gauss_newton_iterations: usize,
    /// Tolerance of a step: a search has converged when no logarithm of a modulus changes by more.
    step_tolerance: f64,
    /// As in `[identify]`.
    static_tolerance: f64,
    /// As in `[identify]`.
    parallel_solves: usize,
    /// Points an axis at which the landscape is simulated.
    surface_points: usize,
    /// Points an axis of the drawn landscape.
    landscape_points: usize,
}

impl Settings {
    fn method_settings(&self, grid_points: usize) -> optimisers::Settings {
        let mut methods = optimisers::Settings::default();
        methods.grid.points_per_axis = grid_points;
        methods.cma_es = cma_es::Settings {
            step_tolerance: self.step_tolerance,
            generations: self.cma_es_generations,
            seed: self.cma_es_seed,
            ..cma_es::Settings::default()
        };
        methods.adam = adam::Settings {
            step: self.adam_step,
            step_decay: self.adam_step_decay,
            mean_decay: self.adam_mean_decay,
            square_decay: self.adam_square_decay,
            step_tolerance: self.step_tolerance,
            iterations: self.adam_iterations,
        };
        methods.gauss_newton.step_tolerance = self.step_tolerance;
        methods.gauss_newton.iterations = self.gauss_newton_iterations;
        methods
    }
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    name: String,
    body: Body,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { name: of.card.name.clone(), body: Body::of(&of.card) }
    }
}

impl Stage for Comparison {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Mesh, Identified);
    type Makes = MethodComparison;
    const DESCRIPTION: &'static str = "every method searches the same loss";
    const VERSION: u32 = 3;

    fn run(
        card: &Self::Card,
        set: &Settings,
        (mesh, identified): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<MethodComparison> {
        if !set.specimens.contains(&card.name) {
            return Ok(MethodComparison::default());
        }
        let loss = identification_loss(&card.body, &mesh, &identified)?;
        context.progress(0.1, "the whole body trains a reduced model");
        let (whole_body, mut bounds) = (loss.solver(set.static_tolerance, set.parallel_solves), loss.bounds());
        let mut trained = TrainedBox::new(&loss, whole_body, identified.elastic(&loss.model), &mut bounds)?;
        let comparing = Comparing { set, loss: &loss, problem: loss.problem(bounds)?, context };
        let (results, certificate) = trained.certified(&mut |reduced| comparing.searches_by_all(reduced))?;
        let searches =
            optimisers::ALL.iter().zip(&results).map(|(member, result)| recorded_search(&loss, member.name, result));
        let searches: Vec<Search> = searches.collect();
        context.progress(0.9, "the landscape");
        let (surface, profiles) = comparing.interpolated_landscape(trained.reduced())?;
        let gradient_difference = Some(gradient_difference(&loss, &comparing.problem, trained.reduced())?);
        let highest = loss.misfit.levels.iter().map(PressureLevel::top).fold(0.0, f64::max);
        Ok(MethodComparison {
            solids: identified.solids,
            highest,
            searches,
            certificate,
            whole_seconds: trained.whole_seconds(),
            surface,
            profiles,
            gradient_difference,
        })
    }
}

/// The searches of one loss from one start.
struct Comparing<'a> {
    set: &'a Settings,
    loss: &'a Loss<'a>,
    problem: Problem,
    context: &'a dyn StageContext,
}

impl Comparing<'_> {
    /// By every method, each from what the reduced model knew before.
    fn searches_by_all(&self, reduced: &LevelSolver) -> Result<Vec<(SearchResult, Second)>> {
        let members = optimisers::ALL.iter().enumerate();
        members
            .map(|(number, member)| {
                self.context.progress((number + 1) as f64 / (optimisers::ALL.len() + 2) as f64, member.name);
                let began = self.context.seconds();
                Ok((self.search_by(member, self.set.grid_points, reduced)?, self.context.seconds() - began))
            })
            .collect()
    }

    fn search_by(
        &self,
        member: &optimisers::Member,
        grid_points: usize,
        reduced: &LevelSolver,
    ) -> Result<SearchResult> {
        let mut solver = reduced.with(self.loss.misfit.levels.clone(), statics(self.set.static_tolerance));
        self.loss.minimise(&self.problem, (member, &self.set.method_settings(grid_points)), &mut solver)
    }

    /// The landscape over the bounds of the search, and the profiles of both moduli.
    fn interpolated_landscape(&self, reduced: &LevelSolver) -> Result<(Surface, Vec<Profile>)> {
        let Some(member) = optimisers::by_name(grid::NAME) else { return Ok((Surface::default(), Vec::new())) };
        let points = self.set.surface_points;
        let simulated = self.search_by(member, points, reduced)?.evaluated;
        loss_surface(self.loss, &simulated, self.problem.bounds(), (points, self.set.landscape_points))
    }
}

/// The loss that was identified with, at the identified stiffening; the markers lie where the first film has them at rest.
fn identification_loss<'a>(body: &'a Body, mesh: &'a Mesh, identified: &Identified) -> Result<Loss<'a>> {
    let rest_positions = identified.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
    let mut model = mesh.model(body)?.with_markers_at(&mesh.solid, body, &rest_positions);
    model.nominal.stiffening = identified.elastic(&model).stiffening;
    let misfit = Misfit::of_record(&identified.levels, &identified.noise, identified.length)?;
    Ok(Loss { body, model, misfit, gauge: WallGauge::new(mesh).of_levels() })
}

/// The evaluations of a method, as recorded.
fn recorded_search(loss: &Loss, method: &str, (result, seconds): &(SearchResult, Second)) -> Search {
    let evaluated_points = result
        .history
        .entries
        .iter()
        .map(|t| EvaluatedPoint { at: loss.elastic(&t.evaluation.at).youngs_moduli, loss: t.evaluation.loss });
    Search { method: method.into(), tried: evaluated_points.collect(), seconds: *seconds }
}
