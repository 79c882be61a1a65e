//! The loss of a model over the logarithms of its solids' moduli, which one stage minimises and another searches by every method.
//!
//! Levels beyond a buckle count like others, also where model and film lie on different sides of it. Left out, such a level would lower the
//! loss wherever the model is wrong about the buckle, and the loss would jump with every level that crosses over; counted, it is what a
//! pressure of buckling says about the moduli. The loss stays defined and continuous as long as the path of equilibria is, and its gradient
//! is that of the branch on which each level lies.

use fem::StaticSettings;
use optimize::optimisers;
use optimize::{Bounds, Evaluation, EvaluationLog, Needs, Problem};
use si::{Pascal, Point2};

use crate::body::Body;
use crate::levels::{Derivatives, LevelSolver, PressureLevel, SimulatedLevel};
use crate::misfit::Misfit;
use crate::model::{BODY, Elastic, Model};
use crate::search::{Interrupted, spanning_order};
use diagnostics::Result;

/// The pressure at which a slack wall buckles, Pa, from the levels and their simulated shapes; none where it does not.
pub type WallGauge<'a> = Box<dyn Fn(&[PressureLevel], &[SimulatedLevel]) -> Option<Pascal> + 'a>;

/// Model and data.
pub struct Loss<'a> {
    /// The solids with their plausible moduli.
    pub body: &'a Body,
    /// The model, at the card's values.
    pub model: Model,
    /// The levels.
    pub misfit: Misfit,
    /// What measures the walls of each simulated point.
    pub gauge: WallGauge<'a>,
}

/// What was simulated at one point of a search, for the landscape.
pub struct Evaluated {
    /// Logarithms of the moduli over the card's.
    pub at: Vec<f64>,
    /// The markers at each level, m.
    pub markers: Vec<Vec<Point2>>,
    /// The pressure at which the slack wall buckles, Pa; none where it does not.
    pub critical: Option<Pascal>,
}

/// The result of a search.
pub struct SearchResult {
    /// All evaluations.
    pub history: EvaluationLog,
    /// What was simulated at each point.
    pub evaluated: Vec<Evaluated>,
}

impl Loss<'_> {
    /// The elastic constants at a point.
    pub fn elastic(&self, point: &[f64]) -> Elastic {
        let mut elastic = self.model.nominal.clone();
        elastic.youngs_moduli.iter_mut().zip(point).for_each(|(modulus, log_ratio)| *modulus *= log_ratio.exp());
        elastic
    }

    /// Whether the law of the softest solid stiffens.
    pub fn is_stiffening(&self) -> bool {
        self.model.system.regions()[BODY].material.is_stiffening()
    }

    /// A solver that knows no equilibrium yet.
    pub fn solver(&self, tolerance: f64, parallel_solves: usize) -> LevelSolver {
        LevelSolver::new(self.model.clone(), self.misfit.levels.clone(), statics(tolerance), parallel_solves)
    }

    /// The plausible moduli.
    pub fn bounds(&self) -> Bounds {
        let bound = |k: usize| self.body.materials.iter().map(|s| (s.plausible[k] / s.youngs_modulus).ln()).collect();
        Bounds { low: bound(0), high: bound(1) }
    }

    /// A search from the card's values or, where they have no equilibrium, from stiffer ones.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the bounds are empty.
    pub fn problem(&self, bounds: Bounds) -> Result<Problem> {
        let (lower, upper) = (bounds.low[0], bounds.high[0]);
        let mut start = vec![0.0; self.body.materials.len()];
        // A quarter of the range above a bound that excludes the card's value: at the bound itself walls are about to
        // lose stability.
        start[0] = lower.max(0.0) + if lower > 0.0 { 0.25 * (upper - lower) } else { 0.0 };
        self.problem_from(start, bounds)
    }

    /// A search from a point of its own.
    ///
    /// # Errors
    /// As [`Loss::problem`].
    pub(crate) fn problem_from(&self, start: Vec<f64>, bounds: Bounds) -> Result<Problem> {
        let names: Vec<&str> = self.body.materials.iter().map(|s| s.name.as_str()).collect();
        Ok(Problem::new(&names, start, bounds)?)
    }

    /// Runs one method with a solver, which then knows the equilibria on the way; the points of a batch are evaluated in the order of a spanning tree from those known.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the method cannot continue, or Adam reaches a point without equilibrium.
    pub fn minimise(
        &self,
        search: &Problem,
        (member, settings): (&optimisers::Member, &optimisers::Settings),
        solver: &mut LevelSolver,
    ) -> Result<SearchResult> {
        let mut optimiser = (member.build)(search, settings)?;
        let mut evaluated = Vec::new();
        let mut problem = |batch: &[Vec<f64>], needs: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            let mut answers: Vec<Option<Evaluation>> = vec![None; batch.len()];
            let earlier: Vec<Vec<f64>> = evaluated.iter().map(|e: &Evaluated| e.at.clone()).collect();
            let earlier = if earlier.is_empty() { vec![search.start().to_vec()] } else { earlier };
            for i in spanning_order(batch, &earlier) {
                let evaluation = self.evaluate(solver, &batch[i], needs, &mut evaluated).map_err(Interrupted)?;
                answers[i] = Some(evaluation);
            }
            Ok(answers.into_iter().flatten().collect())
        };
        let history = optimize::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?;
        Ok(SearchResult { history, evaluated })
    }

    /// Loss, and derivatives as far as needed, at a point; what was simulated there is added to `evaluated`.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when there is no equilibrium where a first gradient is needed.
    pub fn evaluate(
        &self,
        solver: &mut LevelSolver,
        point: &[f64],
        needs: Needs,
        evaluated: &mut Vec<Evaluated>,
    ) -> Result<Evaluation> {
        let want = match needs {
            Needs::Loss => Derivatives::None,
            Needs::Gradient => Derivatives::Gradient,
            Needs::Residuals => Derivatives::Sensitivities,
        };
        let elastic = self.elastic(point);
        let levels = match solver.solve(&elastic, want) {
            // Without an equilibrium the loss is infinite: population and line searches then reject the point by themselves.
            Err(_) if had_evaluation(evaluated, want) => return Ok(Evaluation::of_loss(point.to_vec(), f64::INFINITY)),
            levels => levels?,
        };
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let loss = self.misfit.loss(&markers);
        let critical = (self.gauge)(&self.misfit.levels, &levels);
        evaluated.push(Evaluated { at: point.to_vec(), markers, critical });
        let moduli = &elastic.youngs_moduli;
        let residuals =
            (want == Derivatives::Sensitivities).then(|| self.misfit.residuals(&levels, moduli)).transpose()?;
        let gradient = (want == Derivatives::Gradient).then(|| self.loss_gradient(&levels, moduli));
        Ok(Evaluation { at: point.to_vec(), loss, gradient, residuals })
    }

    /// ∂loss/∂ln E.
    fn loss_gradient(&self, levels: &[SimulatedLevel], moduli: &[Pascal]) -> Vec<f64> {
        let sum = |k: usize| levels.iter().map(|l| l.gradient[k]).sum::<f64>();
        moduli.iter().enumerate().map(|(k, modulus)| sum(k) * modulus / self.body.length).collect()
    }
}

/// Whether a point without equilibrium may have infinite loss: where a gradient is needed, one point must have been evaluated before.
fn had_evaluation(evaluated: &[Evaluated], want: Derivatives) -> bool {
    want != Derivatives::Gradient || !evaluated.is_empty()
}

/// How the equilibria of a search are solved for: from those known.
pub fn statics(tolerance: f64) -> StaticSettings {
    StaticSettings { tolerance, max_iterations: DIRECTIONS, ..StaticSettings::default() }
}

/// Newton iterations after which an initial guess is given up: where a wall dents up to 20 are needed.
const DIRECTIONS: usize = 24;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gradient_is_asked_for_at_a_point_without_equilibrium_only_after_one_with() {
        assert!(!had_evaluation(&[], Derivatives::Gradient));
        assert!([Derivatives::None, Derivatives::Sensitivities].iter().all(|want| had_evaluation(&[], *want)));
    }
}
