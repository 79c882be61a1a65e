//! The identification problem: pressure levels of all films of a specimen, the model, and the bounds of both moduli.

use fem::StaticSettings;
use optimize::optimisers::{self, adam, cma_es, gauss_newton};
use optimize::{Bounds, Evaluation, EvaluationLog, Needs, Problem, Residuals};
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Second};

use super::mesh;
use super::plateaus::{held_times, levels};
use super::walls::WallGauge;
use crate::records::{self, EvaluatedPoint, Markers, Mesh, Motion, NoiseModel};
use crate::selections::IdentificationTrials;
use crate::subject::Specimen;
use diagnostics::{Diagnostic, Result};
use sysid::Discrepancy;
use sysid::Interrupted;
use sysid::Misfit;
use sysid::feasible_lower_bound;
use sysid::spanning_order;
use sysid::{
    BODY, Body, Derivatives, Elastic, LevelSolver, Model, PressureLevel, SimulatedLevel, Stiffened, StiffeningProblem,
};
use workflow::subject::Part;

/// `[identify]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The fraction at the end of each hold that counts as settled, 0 to 1.
    pub(super) settled_fraction: f64,
    /// The shortest hold that counts, s.
    pub(super) shortest_hold: Second,
    /// Standard deviation of the model discrepancy by which a displacement is weighed in the search, m.
    pub(super) discrepancy: Metre,
    /// Standard deviation of the common scale error of all displacements of a film by which they are weighed, no unit.
    pub(super) scale_sigma: f64,
    /// The middle of the prior of the discrepancy that the residuals show: standard deviation of a chamber's scale, no unit.
    pub(super) prior_scale_sigma: f64,
    /// Of the deviation of the shape, over the displacement, no unit.
    pub(super) prior_shape_sigma: f64,
    /// Distance over which that deviation is correlated, over the specimen's length.
    pub(super) prior_correlation_length: f64,
    /// Logarithm of the ratio of pressures over which it is correlated.
    pub(super) prior_correlation_log_pressure: f64,
    /// Target length of an edge of the finer mesh on which the discretisation error is estimated, m.
    pub(super) fine_edge: Metre,
    /// Standard deviations of the prior of C₂₀/C₁₀ and C₃₀/C₁₀ about the card's, where the softest solid's law stiffens and the card has none
    /// of its own; no unit.
    pub(super) stiffening_sigma: [f64; 2],
    /// Specimens on which every method is run for comparison; on the others Gauss-Newton alone.
    pub(super) compared: Vec<String>,
    /// Points an axis of the exhaustive search.
    pub(super) grid_points: usize,
    /// CMA-ES's generations at most, ten simulations each; the paper made four.
    pub(super) cma_es_generations: usize,
    /// Seed of its random numbers.
    pub(super) cma_es_seed: u64,
    /// Length of Adam's step, in logarithms of moduli.
    pub(super) adam_step: f64,
    /// Decay of the step, 1/iterations.
    pub(super) adam_step_decay: f64,
    /// β₁ of Adam.
    pub(super) adam_mean_decay: f64,
    /// β₂ of Adam.
    pub(super) adam_square_decay: f64,
    /// Adam's simulations at most.
    pub(super) adam_iterations: usize,
    /// Gauss-Newton's simulations at most.
    pub(super) gauss_newton_iterations: usize,
    /// Tolerance of a step: a search has converged when no logarithm of a modulus changes by more.
    pub(super) step_tolerance: f64,
    /// Tolerance of an equilibrium: Newton has converged when no node moves by more than this fraction of the specimen's size.
    pub(super) static_tolerance: f64,
    /// Equilibria solved in parallel.
    pub(super) parallel_solves: usize,
    /// Points an axis of the drawn landscape.
    pub(super) landscape_points: usize,
}

impl Settings {
    /// The discrepancy before it is estimated, of a specimen of this length.
    fn prior(&self, length: Metre) -> Discrepancy {
        Discrepancy {
            scale_sigma: self.prior_scale_sigma,
            film_sigma: self.scale_sigma,
            shape_sigma: self.prior_shape_sigma,
            correlation_length_m: self.prior_correlation_length * length,
            correlation_log_pressure: self.prior_correlation_log_pressure,
        }
    }
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    pub(super) name: String,
    pub(super) mesh: mesh::Card,
    pub(super) body: Body,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { name: of.card.name.clone(), mesh: Part::part_of(of), body: Body::of(&of.card) }
    }
}

/// Model and data of one identification.
pub(crate) struct Fitting<'a> {
    pub(super) body: &'a Body,
    pub(super) set: &'a Settings,
    /// Whether every method is run on the specimen.
    pub(super) compared: bool,
    pub(super) model: Model,
    pub(super) levels: Misfit,
    pub(super) noise: NoiseModel,
    /// Time after loading to which the moduli belong, s.
    pub(super) modulus_time: Second,
    /// Trial and rest places of each level.
    pub(super) origins: Vec<(String, Vec<Point2>)>,
    pub(super) search: Problem,
    gauge: WallGauge<'a>,
    /// The equilibria from which every search starts.
    explored: LevelSolver,
    /// Moduli and stiffening, identified together; none where the law of the softest solid does not stiffen.
    pub(super) stiffened: Option<Stiffened>,
}

/// What was simulated at one point of a search, for the landscape.
pub struct Evaluated {
    pub(super) at: Vec<f64>,
    /// The markers at each level, m.
    pub(super) markers: Vec<Vec<Point2>>,
    /// The pressure at which the slack wall buckles, Pa; none where it does not.
    pub(super) critical: Option<Pascal>,
}

/// The result of a search, with its solver.
pub struct SearchResult {
    /// All evaluations.
    pub history: EvaluationLog,
    /// What was simulated at each point.
    pub evaluated: Vec<Evaluated>,
    pub(super) solver: LevelSolver,
}

/// The films of a specimen: motion, and the markers with the contributions to their covariance.
pub type Films = (IdentificationTrials<Motion>, IdentificationTrials<Markers>);

impl<'a> Fitting<'a> {
    /// The levels of all films, the model, and the bounds of the search.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no film, a film holds no pressure, or the simulator refuses the mesh.
    pub fn new(card: &'a Card, set: &'a Settings, mesh: &'a Mesh, films: &Films) -> Result<Self> {
        let (mut all, mut origins, mut counts, mut held) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for ((trial, motion), (_, markers)) in films.0.0.iter().zip(&films.1.0) {
            let levels = levels(motion, markers, set.settled_fraction, set.shortest_hold)
                .map_err(|d| d.while_doing(&trial.0))?;
            origins.extend(levels.iter().map(|_| (trial.0.clone(), motion.rest.clone())));
            counts.push(levels.len());
            held.extend(held_times(motion, set.settled_fraction, set.shortest_hold));
            all.extend(levels);
        }
        if all.is_empty() {
            return Err(no_film(&card.name));
        }
        let solids = &card.body.materials;
        let bound = |k: usize| solids.iter().map(|s| (s.plausible[k] / s.youngs_modulus).ln()).collect();
        let mut bounds = Bounds { low: bound(0), high: bound(1) };
        let model = mesh.model(&card.body)?.with_markers_at(&mesh.solid, &card.body, &mean_rest(&films.0));
        let noise = NoiseModel { discrepancy_m: set.discrepancy, scale_sigma: set.scale_sigma };
        let levels = Misfit::new(all, &counts, &noise, card.body.length)?;
        let (settings, all) = (statics(set.static_tolerance), levels.levels.clone());
        let mut explored = LevelSolver::new(model.clone(), all, settings, set.parallel_solves);
        // where stiffening is identified, it decides how soft a body has an equilibrium
        if !model.system.regions()[BODY].material.is_stiffening() {
            bounds.low[0] = feasible_lower_bound(&mut explored, &model.nominal, &bounds)?;
        }
        let search = search(&card.body, bounds)?;
        let modulus_time = held.iter().sum::<Second>() / held.len().max(1) as f64;
        let (body, compared, gauge) = (&card.body, set.compared.contains(&card.name), WallGauge::new(mesh));
        let plain = Self {
            body,
            set,
            compared,
            model,
            levels,
            noise,
            modulus_time,
            origins,
            search,
            gauge,
            explored,
            stiffened: None,
        };
        plain.stiffened()
    }

    /// With the stiffening that the films give, where the law of the softest solid has one, and the lower bound that goes with it.
    // The stiffening is identified before the moduli are searched by all methods, which keep it: the least misfit of both together is
    // also the least one over the moduli at that stiffening, and landscape and searches stay over two parameters as in the paper.
    fn stiffened(mut self) -> Result<Self> {
        if !self.model.system.regions()[BODY].material.is_stiffening() {
            return Ok(self);
        }
        let mut solver = self.solver(&self.levels.levels, self.set.static_tolerance);
        let problem = StiffeningProblem {
            model: &self.model,
            misfit: &self.levels,
            moduli: &self.search,
            prior_sigma: self.body.materials[BODY].stiffening_sigma.unwrap_or(self.set.stiffening_sigma),
            method: self.methods().gauss_newton,
        };
        let found = problem.identify(&mut solver, &|_| ())?;
        self.explored = solver;
        self.model.nominal.stiffening = found.ratios;
        let elastic = self.elastic(&found.at);
        // Methods are compared from the card's values, as in the paper; one method alone continues from here.
        if self.compared {
            let mut bounds = self.search.bounds().clone();
            bounds.low[0] = feasible_lower_bound(&mut self.explored, &elastic, &bounds)?;
            self.search = search(self.body, bounds)?;
        } else {
            let (names, bounds) = (self.search.names(), self.search.bounds());
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            self.search = Problem::new(&names, bounds.clamp(&found.at[..names.len()]), bounds.clone())?;
        }
        Ok(Self { stiffened: Some(found), ..self })
    }

    /// The discrepancy that the residuals of a search show.
    pub(super) fn estimated(&self, (residuals, parameters): (&Residuals, usize)) -> Result<Discrepancy> {
        Discrepancy::estimated(&self.levels, residuals, parameters, &self.set.prior(self.body.length))
    }

    pub(super) fn elastic(&self, at: &[f64]) -> Elastic {
        let mut elastic = self.model.nominal.clone();
        elastic.youngs_moduli.iter_mut().zip(at).for_each(|(modulus, by)| *modulus *= by.exp());
        elastic
    }

    pub(super) fn solver(&self, levels: &[PressureLevel], tolerance: f64) -> LevelSolver {
        self.explored.with(levels.to_vec(), statics(tolerance))
    }

    /// Runs one method; the points of a batch are evaluated in the order of a spanning tree from those known.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the method cannot continue, or Adam reaches a point without equilibrium.
    pub fn search(&self, member: &optimisers::Member) -> Result<SearchResult> {
        let mut optimiser = (member.build)(&self.search, &self.methods())?;
        let looser = if member.name == gauss_newton::NAME { 1.0 } else { COMPARED };
        let mut solver = self.solver(&self.levels.levels, looser * self.set.static_tolerance);
        let mut evaluated = Vec::new();
        let mut problem = |batch: &[Vec<f64>], needs: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            let mut answers: Vec<Option<Evaluation>> = vec![None; batch.len()];
            let known: Vec<Vec<f64>> = evaluated.iter().map(|e: &Evaluated| e.at.clone()).collect();
            let known = if known.is_empty() { vec![self.search.start().to_vec()] } else { known };
            for i in spanning_order(batch, &known) {
                let evaluation = self.evaluate(&mut solver, &batch[i], needs, &mut evaluated).map_err(Interrupted)?;
                answers[i] = Some(evaluation);
            }
            Ok(answers.into_iter().flatten().collect())
        };
        let history = optimize::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?;
        Ok(SearchResult { history, evaluated, solver })
    }

    fn methods(&self) -> optimisers::Settings {
        let set = self.set;
        let mut methods = optimisers::Settings::default();
        methods.grid.points_per_axis = set.grid_points;
        methods.cma_es = cma_es::Settings {
            step_tolerance: set.step_tolerance,
            generations: set.cma_es_generations,
            seed: set.cma_es_seed,
            ..cma_es::Settings::default()
        };
        methods.adam = adam::Settings {
            step: set.adam_step,
            step_decay: set.adam_step_decay,
            mean_decay: set.adam_mean_decay,
            square_decay: set.adam_square_decay,
            step_tolerance: set.step_tolerance,
            iterations: set.adam_iterations,
        };
        methods.gauss_newton.step_tolerance = set.step_tolerance;
        methods.gauss_newton.iterations = set.gauss_newton_iterations;
        methods
    }

    pub(super) fn evaluate(
        &self,
        solver: &mut LevelSolver,
        at: &[f64],
        needs: Needs,
        evaluated: &mut Vec<Evaluated>,
    ) -> Result<Evaluation> {
        let want = match needs {
            Needs::Loss => Derivatives::None,
            Needs::Gradient => Derivatives::Gradient,
            Needs::Residuals => Derivatives::Sensitivities,
        };
        let elastic = self.elastic(at);
        let levels = match solver.solve(&elastic, want) {
            // Without an equilibrium the loss is infinite: population and line searches then reject the point by themselves.
            Err(_) if had_evaluation(evaluated, want) => return Ok(Evaluation::of_loss(at.to_vec(), f64::INFINITY)),
            levels => levels?,
        };
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let loss = self.levels.loss(&markers);
        let critical = self.gauge.critical_pressure(&self.levels.levels, &levels);
        evaluated.push(Evaluated { at: at.to_vec(), markers, critical });
        let moduli = &elastic.youngs_moduli;
        let residuals =
            (want == Derivatives::Sensitivities).then(|| self.levels.residuals(&levels, moduli)).transpose()?;
        let gradient = (want == Derivatives::Gradient).then(|| self.gradient(&levels, moduli));
        Ok(Evaluation { at: at.to_vec(), loss, gradient, residuals })
    }

    /// ∂loss/∂ln E.
    fn gradient(&self, levels: &[SimulatedLevel], moduli: &[Pascal]) -> Vec<f64> {
        let sum = |k: usize| levels.iter().map(|l| l.gradient[k]).sum::<f64>();
        moduli.iter().enumerate().map(|(k, modulus)| sum(k) * modulus / self.body.length).collect()
    }

    /// The evaluations of a method, as recorded.
    pub fn record(&self, method: &str, history: &EvaluationLog, seconds: Second) -> records::Search {
        let tried = history
            .entries
            .iter()
            .map(|t| EvaluatedPoint { at: self.elastic(&t.evaluation.at).youngs_moduli, loss: t.evaluation.loss });
        records::Search { method: method.into(), tried: tried.collect(), seconds }
    }
}

/// The search over the logarithms of the moduli over the card's, from the card's values or, where they have no equilibrium, from stiffer ones.
fn search(body: &Body, bounds: Bounds) -> Result<Problem> {
    let names: Vec<&str> = body.materials.iter().map(|s| s.name.as_str()).collect();
    let (lower, upper) = (bounds.low[0], bounds.high[0]);
    let mut start = vec![0.0; names.len()];
    start[0] = lower.max(0.0) + if lower > 0.0 { 0.25 * (upper - lower) } else { 0.0 };
    Ok(Problem::new(&names, start, bounds)?)
}

/// Whether a point without equilibrium may have infinite loss: where a gradient is needed, one point must have been evaluated before.
fn had_evaluation(evaluated: &[Evaluated], want: Derivatives) -> bool {
    want != Derivatives::Gradient || !evaluated.is_empty()
}

/// How the equilibria of a search are solved for: from those known.
fn statics(tolerance: f64) -> StaticSettings {
    StaticSettings { tolerance, max_iterations: DIRECTIONS, ..StaticSettings::default() }
}

/// Tolerance of the equilibria of searches that are only compared, over Gauss-Newton's: a last step leaves a tenth of itself.
const COMPARED: f64 = 10.0;
/// Newton iterations after which an initial guess is given up: where an equilibrium exists, eight suffice.
const DIRECTIONS: usize = 16;

/// Measured positions of the markers at rest: the mean over films, m.
pub(crate) fn mean_rest(films: &IdentificationTrials<Motion>) -> Vec<Point2> {
    let count = films.0.len().max(1) as f64;
    let first = films.0.first().map(|(_, m)| m.rest.len()).unwrap_or_default();
    let mean = |m: usize, k: usize| films.0.iter().map(|(_, motion)| motion.rest[m][k]).sum::<f64>() / count;
    (0..first).map(|m| [mean(m, 0), mean(m, 1)]).collect()
}

fn no_film(name: &str) -> Diagnostic {
    Diagnostic::new(
        format!("`{}` has no trial to identify from", name),
        "no [[trial]] on its card has role = \"identify\"",
        "give a staircase that role",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gradient_is_asked_for_at_a_point_without_equilibrium_only_after_one_with() {
        assert!(!had_evaluation(&[], Derivatives::Gradient));
        assert!([Derivatives::None, Derivatives::Sensitivities].iter().all(|want| had_evaluation(&[], *want)));
    }
}
