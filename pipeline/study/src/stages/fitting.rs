//! Fitting: the levels of all films of a specimen, the model that simulates them, and the plane of moduli to be searched.
//!
//! Stands on: the ladder, the landscape, fit. Never knows: which methods there are.

use fem::StaticSettings;
use fit::optimisers::{self, adam, cma_es, gauss_newton, grid};
use fit::{Bounds, Evaluation, History, Needs, Search};
use lab::card::Card;
use si::{Pascal, Point2, Second};

use super::identify::Settings;
use super::levels::Levels;
use super::plateaus::rungs;
use super::softest::softest;
use super::stop::Stop;
use super::walk::near_to_near;
use crate::fault::{Fault, Outcome};
use crate::model::{Elastic, Ladder, Model, Rung, Simulated, Want};
use crate::needs::Learning;
use crate::records::{self, Doubt, Markers, Mesh, Motion, Point, Tried};
use crate::subject::Specimen;

/// Everything that a search needs to simulate.
pub struct Fitting<'a> {
    pub(super) card: &'a Card,
    pub(super) set: &'a Settings,
    pub(super) model: Model,
    pub(super) levels: Levels,
    pub(super) doubt: Doubt,
    /// Trial and rest places of each level.
    pub(super) origins: Vec<(String, Vec<Point2>)>,
    pub(super) search: Search,
}

/// What one point of a search showed, kept for the landscape.
pub struct Told {
    pub(super) at: Vec<f64>,
    pub(super) markers: Vec<Vec<Point2>>,
}

/// What a search found, and the ladder that it climbed.
pub struct Searched {
    /// All that was tried.
    pub history: History,
    /// What each point showed.
    pub told: Vec<Told>,
    pub(super) ladder: Ladder,
}

/// The films of a specimen: motion, and what the markers' covariance is made of.
pub type Films = (Learning<Motion>, Learning<Markers>);

/// The parameters, as messages and figures name them.
pub const NAMES: [&str; 2] = ["body", "spine"];

impl<'a> Fitting<'a> {
    /// The levels of all films, the model, and the plane to be searched.
    ///
    /// # Errors
    /// A [`Fault`] when there is no film, a film holds no pressure, or the simulator refuses the mesh.
    pub fn new(of: &'a Specimen, set: &'a Settings, mesh: &Mesh, films: &Films) -> Outcome<Self> {
        let (mut all, mut origins, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for ((trial, motion), (_, markers)) in films.0.0.iter().zip(&films.1.0) {
            let rungs = rungs(motion, markers, set.settled, set.shortest_hold).map_err(|f| f.of(&trial.trial.id))?;
            origins.extend(rungs.iter().map(|_| (trial.trial.id.clone(), motion.rest.clone())));
            counts.push(rungs.len());
            all.extend(rungs);
        }
        if all.is_empty() {
            return Err(no_film(of));
        }
        let solid = &of.card.solid;
        let bound = |k: usize| [&solid.body, &solid.spine].map(|s| (s.plausible[k] / s.youngs_modulus).ln()).to_vec();
        let mut bounds = Bounds { low: bound(0), high: bound(1) };
        let model = Model::new(mesh, &of.card)?.seen_at(mesh, &of.card, &mean_rest(&films.0));
        let doubt = Doubt { discrepancy_m: set.discrepancy, share: set.share };
        let levels = Levels::new(all, &counts, &doubt, of.card.length)?;
        let softest = softest(&model, &levels.rungs, &bounds);
        bounds.low[0] = softest;
        let start = vec![softest.max(0.0) + if softest > 0.0 { 0.25 * (bounds.high[0] - softest) } else { 0.0 }, 0.0];
        let search = Search::new(&NAMES, start, bounds).map_err(Fault::from_tool)?;
        Ok(Self { card: &of.card, set, model, levels, doubt, origins, search })
    }

    pub(super) fn elastic(&self, at: &[f64]) -> Elastic {
        let nominal = self.model.nominal;
        let [body, spine] = nominal.youngs_moduli;
        Elastic { youngs_moduli: [body * at[0].exp(), spine * at[1].exp()], ..nominal }
    }

    pub(super) fn point(&self, at: &[f64]) -> Point {
        let [body_e_pa, spine_e_pa] = self.elastic(at).youngs_moduli;
        Point { body_e_pa, spine_e_pa }
    }

    pub(super) fn static_tolerance(&self) -> f64 {
        self.set.static_tolerance
    }

    pub(super) fn ladder(&self, rungs: &[Rung], tolerance: f64) -> Ladder {
        let settings =
            StaticSettings { tolerance, halvings: HALVINGS, iterations: DIRECTIONS, ..StaticSettings::default() };
        Ladder::new(self.model.clone(), rungs.to_vec(), settings, self.set.side_by_side)
    }

    /// Runs one method over the plane; a batch is walked from near point to near point.
    ///
    /// # Errors
    /// A [`Fault`] when the method cannot go on, or Adam meets a point without equilibrium.
    pub fn search(&self, member: &optimisers::Member) -> Outcome<Searched> {
        let mut optimiser = (member.build)(&self.search, &self.methods()).map_err(Fault::from_tool)?;
        let mut ladder = self.ladder(&self.levels.rungs, self.set.static_tolerance);
        let mut told = Vec::new();
        let mut problem = |batch: &[Vec<f64>], needs: Needs| -> Result<Vec<Evaluation>, Stop> {
            let mut answers: Vec<Option<Evaluation>> = vec![None; batch.len()];
            for i in near_to_near(batch) {
                let evaluation = self.evaluate(&mut ladder, &batch[i], needs, &mut told).map_err(Stop)?;
                answers[i] = Some(evaluation);
            }
            Ok(answers.into_iter().flatten().collect())
        };
        let history = fit::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?;
        Ok(Searched { history, told, ladder })
    }

    fn methods(&self) -> optimisers::Settings {
        let set = self.set;
        optimisers::Settings {
            grid: grid::Settings { points_per_axis: set.grid_points },
            cma_es: cma_es::Settings {
                step_tolerance: set.step_tolerance,
                generations: set.cma_es_generations,
                seed: set.cma_es_seed,
                ..cma_es::Settings::default()
            },
            adam: adam::Settings {
                step: set.adam_step,
                step_decay: set.adam_step_decay,
                mean_memory: set.adam_mean_memory,
                square_memory: set.adam_square_memory,
                step_tolerance: set.step_tolerance,
                iterations: set.adam_iterations,
            },
            gauss_newton: gauss_newton::Settings {
                step_tolerance: set.step_tolerance,
                iterations: set.gauss_newton_iterations,
                ..gauss_newton::Settings::default()
            },
        }
    }

    pub(super) fn evaluate(
        &self,
        ladder: &mut Ladder,
        at: &[f64],
        needs: Needs,
        told: &mut Vec<Told>,
    ) -> Outcome<Evaluation> {
        let want = match needs {
            Needs::Loss => Want::Nothing,
            Needs::Gradient => Want::Gradient,
            Needs::Residuals => Want::Slopes,
        };
        let elastic = self.elastic(at);
        let levels = match ladder.climb(&elastic, want) {
            Err(_) if told_before(told, want) => return Ok(Evaluation::of_loss(at.to_vec(), f64::INFINITY)),
            levels => levels?,
        };
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let loss = self.levels.loss(&markers);
        told.push(Told { at: at.to_vec(), markers });
        let moduli = elastic.youngs_moduli;
        let residuals = (want == Want::Slopes).then(|| self.levels.residuals(&levels, &moduli)).transpose()?;
        let gradient = (want == Want::Gradient).then(|| self.gradient(&levels, moduli));
        Ok(Evaluation { at: at.to_vec(), loss, gradient, residuals })
    }

    /// ∂loss/∂ln E.
    fn gradient(&self, levels: &[Simulated], moduli: [Pascal; 2]) -> Vec<f64> {
        let sum = |k: usize| levels.iter().map(|l| l.gradient[k]).sum::<f64>();
        (0..2).map(|k| sum(k) * moduli[k] / self.card.length).collect()
    }

    /// How the method went, as it is kept.
    pub fn record(&self, method: &str, history: &History, seconds: Second) -> records::Search {
        let tried = history.tried.iter().map(|t| Tried { at: self.point(&t.evaluation.at), loss: t.evaluation.loss });
        records::Search { method: method.into(), tried: tried.collect(), seconds }
    }
}

/// Whether a point without equilibrium may be told as one of infinite loss: a gradient must have been found before.
fn told_before(told: &[Told], want: Want) -> bool {
    want != Want::Gradient || !told.is_empty()
}

/// A level whose load steps must be halved more often than this has given way: a search has better points to try.
const HALVINGS: usize = 1;

/// Newton directions in a load step after which it is given up: where there is a shape, eight do.
const DIRECTIONS: usize = 16;

/// Where the markers were seen at rest: the mean over films, m.
pub fn mean_rest(films: &Learning<Motion>) -> Vec<Point2> {
    let count = films.0.len().max(1) as f64;
    let first = films.0.first().map(|(_, m)| m.rest.len()).unwrap_or_default();
    let mean = |m: usize, k: usize| films.0.iter().map(|(_, motion)| motion.rest[m][k]).sum::<f64>() / count;
    (0..first).map(|m| [mean(m, 0), mean(m, 1)]).collect()
}

fn no_film(of: &Specimen) -> Fault {
    Fault::new(
        format!("`{}` has no trial to identify from", of.card.name),
        "no [[trial]] on its card has role = \"identify\"",
        "give a staircase that role",
    )
}
