//! Method comparison: every method of `optimize` searches the loss of the identification over the same bounds. Paper: section V, table III
//! and figure 5.
//!
//! It is a stage of its own because nothing else waits for it, and it may take longer than the identification. The stiffening is that of the
//! identification, so that the search is over two moduli as in the paper; it begins at the card's values. The landscape is interpolated
//! between the points of the exhaustive search.
//!
//! Where the wall of a tail buckles below the highest level, points far from the estimate have equilibria at the end of long paths, or none.
//! On the mesh of the study (66,000 unknowns, 14 levels) Nemo's four methods took more than two hours. As all search the same loss, they are
//! compared on a coarser mesh, whose stiffer wall shifts the lowest loss, and on the levels up to the first beyond the buckle.

use optimize::optimisers::{self, adam, cma_es, grid};
use serde::{Deserialize, Serialize};

use super::gradients::gradient_difference;
use super::loss_surface::surface;
use super::mesh;
use super::walls::WallGauge;
use crate::records::{EvaluatedPoint, Identified, Mesh, MethodComparison, Search};
use crate::subject::Specimen;
use diagnostics::Result;
use si::{Metre, Second};
use sysid::{Body, Loss, Misfit, PressureLevel, SearchResult, feasible_lower_bound, statics};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Comparison;

/// `[method_comparison]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Specimens on which every method is run.
    specimens: Vec<String>,
    /// Target length of an edge of their meshes, m; a body that came as a mesh file keeps its own.
    edge: Metre,
    /// Fraction of the highest pressure up to which levels are used.
    pressure_fraction: f64,
    /// Points an axis of the exhaustive search.
    grid_points: usize,
    /// CMA-ES's generations at most, ten simulations each; the paper made four.
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
    /// Points an axis of the drawn landscape.
    landscape_points: usize,
}

impl Settings {
    fn methods(&self) -> optimisers::Settings {
        let mut methods = optimisers::Settings::default();
        methods.grid.points_per_axis = self.grid_points;
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
    mesh: mesh::Card,
    body: Body,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { name: of.card.name.clone(), mesh: Part::part_of(of), body: Body::of(&of.card) }
    }
}

impl Stage for Comparison {
    type Settings = Settings;
    type Card = Card;
    type Needs = Identified;
    type Makes = MethodComparison;
    const DESCRIPTION: &'static str = "every method searches the same loss";
    const VERSION: u32 = 1;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        mesh::Mesh::raw(of)
    }

    fn run(
        card: &Self::Card,
        set: &Settings,
        found: Identified,
        context: &dyn StageContext,
    ) -> Result<MethodComparison> {
        if !set.specimens.contains(&card.name) {
            return Ok(MethodComparison::default());
        }
        let mesh = mesh::with_edge(&card.mesh, set.edge, context)?;
        let found = found.up_to(set.pressure_fraction);
        let loss = loss(&card.body, &mesh, &found)?;
        let (mut bounds, mut explored) = (loss.bounds(), loss.solver(set.static_tolerance, set.parallel_solves));
        bounds.low[0] = feasible_lower_bound(&mut explored, &found.elastic(&loss.model), &bounds)?;
        let (problem, methods) = (loss.problem(bounds)?, set.methods());
        let (mut searches, mut evaluated) = (Vec::new(), Vec::new());
        for (i, member) in optimisers::ALL.iter().enumerate() {
            context.progress((i + 1) as f64 / (optimisers::ALL.len() + 1) as f64, member.name);
            let began = context.seconds();
            let mut solver = explored.with(loss.misfit.levels.clone(), statics(set.static_tolerance));
            let result = loss.minimise(&problem, (member, &methods), &mut solver)?;
            searches.push(search(&loss, member.name, &result, context.seconds() - began));
            if member.name == grid::NAME {
                evaluated = result.evaluated;
            }
        }
        let (surface, profiles) =
            surface(&loss, &evaluated, problem.bounds(), (set.grid_points, set.landscape_points))?;
        let gradient_difference = Some(gradient_difference(&loss, &problem, &explored)?);
        let highest = loss.misfit.levels.iter().map(PressureLevel::top).fold(0.0, f64::max);
        let (solids, edge) = (found.solids, card.mesh.has_surfaces().then_some(set.edge));
        Ok(MethodComparison { solids, edge, highest, searches, surface, profiles, gradient_difference })
    }
}

/// The loss that was identified with, at the identified stiffening; the markers lie where the first film has them at rest.
fn loss<'a>(body: &'a Body, mesh: &'a Mesh, found: &Identified) -> Result<Loss<'a>> {
    let rest = found.levels.first().map(|l| l.rest_m.clone()).unwrap_or_default();
    let mut model = mesh.model(body)?.with_markers_at(&mesh.solid, body, &rest);
    model.nominal.stiffening = found.elastic(&model).stiffening;
    let misfit = Misfit::kept(&found.levels, &found.noise, found.length)?;
    Ok(Loss { body, model, misfit, gauge: WallGauge::new(mesh).of_levels() })
}

/// The evaluations of a method, as recorded.
fn search(loss: &Loss, method: &str, result: &SearchResult, seconds: Second) -> Search {
    let tried = result
        .history
        .entries
        .iter()
        .map(|t| EvaluatedPoint { at: loss.elastic(&t.evaluation.at).youngs_moduli, loss: t.evaluation.loss });
    Search { method: method.into(), tried: tried.collect(), seconds }
}
