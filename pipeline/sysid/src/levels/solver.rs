//! Solvers that share the levels of a body between them.

use fem::StaticSettings;
use si::Second;

use super::level::{Derivatives, LevelCorrection, PressureLevel, SimulatedLevel};
use super::part::{Part, Solved};
use super::statics::{Statics, Unknowns};
use crate::load_path::{Beginning, LoadPath, Steps};
use crate::model::{BODY, Elastic, Model};
use crate::surrogate::{KnownShape, Load, Surrogate};
use diagnostics::{Diagnostic, Result};

/// Tolerance of equilibria that serve as initial guesses alone.
const EXPLORED: f64 = 1e-4;

/// Solvers, and the surrogate of their equilibria.
pub struct LevelSolver {
    model: Model,
    pub(super) levels: Vec<PressureLevel>,
    settings: StaticSettings,
    pub(super) unknowns: Unknowns,
    solvers: Vec<Box<dyn Statics>>,
    pub(super) known: Surrogate,
    /// See [`Load::new`].
    pub(super) unit: f64,
    /// See [`Part::corrections`].
    pub(super) corrections: Vec<LevelCorrection>,
    totals: SolveTotals,
}

/// What a solver has done, paths between levels left out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SolveTotals {
    /// Equilibria.
    pub equilibria: usize,
    /// Of those that were derived, s.
    forward: Second,
    /// Of their derivatives, s.
    derivatives: Second,
}

impl SolveTotals {
    /// Time of equilibria with their derivatives over that without.
    pub fn gradient_over_forward(&self) -> f64 {
        (self.forward + self.derivatives) / self.forward
    }

    fn count_level(&mut self, level: &SimulatedLevel, derivatives: Derivatives) {
        self.equilibria += 1;
        if derivatives != Derivatives::None {
            self.forward += level.forward_seconds;
            self.derivatives += level.derivative_seconds;
        }
    }
}

impl LevelSolver {
    /// A solver over the levels with this many parallel solvers; of the settings, tolerance and iterations of Newton's method count.
    pub fn new(model: Model, levels: Vec<PressureLevel>, settings: StaticSettings, parallel: usize) -> Self {
        let highest = levels.iter().map(PressureLevel::top).fold(f64::MIN_POSITIVE, f64::max);
        let (unit, known) = (highest / model.nominal.youngs_moduli[BODY], Surrogate::default());
        let unknowns = Unknowns::Nodes(model.clone());
        let solvers = (0..parallel.clamp(1, levels.len().max(1))).map(|_| unknowns.solver()).collect();
        let (corrections, totals) = (Vec::new(), SolveTotals::default());
        Self { model, levels, settings, unknowns, solvers, known, unit, corrections, totals }
    }

    /// What it solves.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The levels.
    pub(crate) fn levels(&self) -> &[PressureLevel] {
        &self.levels
    }

    /// The same equilibria as initial guesses for other `levels` or `settings` of the same specimen.
    pub fn with(&self, levels: Vec<PressureLevel>, settings: StaticSettings) -> Self {
        let corrections = if levels.len() == self.levels.len() { self.corrections.clone() } else { Vec::new() };
        let surrogate = self.known.clone();
        Self { levels, settings, corrections, ..self.seeking(self.unknowns.clone(), surrogate) }
    }

    /// The same levels in other unknowns, in which it knows these shapes.
    pub(super) fn seeking(&self, unknowns: Unknowns, known: Surrogate) -> Self {
        let solvers = self.solvers.iter().map(|_| unknowns.solver()).collect();
        let (model, levels, settings, unit) = (self.model.clone(), self.levels.clone(), self.settings, self.unit);
        let (corrections, totals) = (Vec::new(), SolveTotals::default());
        Self { model, levels, settings, unknowns, solvers, known, unit, corrections, totals }
    }

    /// What it has done.
    pub(crate) fn solve_totals(&self) -> SolveTotals {
        self.totals
    }

    /// Follows the equilibria with these constants, from rest or the highest that is known, to `reach` times the highest pressure of each
    /// filled chamber, and returns the part of these pressures that all reached. They are the initial guesses of what is solved later.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a solver panics.
    pub(crate) fn follow_paths(&mut self, elastic: &Elastic, reach: f64) -> Result<f64> {
        let tops: Vec<PressureLevel> = highest_levels(&self.levels).into_iter().map(|top| top.scaled(reach)).collect();
        let mut lowest_part = 1.0_f64;
        for path in run_parallel(&tops, self.solvers.len(), |level| Ok(self.path_to(level, elastic))) {
            let (shapes, reached) = path?;
            lowest_part = lowest_part.min(reached);
            shapes.into_iter().for_each(|shape| self.known.add(shape));
        }
        Ok(lowest_part * reach)
    }

    /// Loads and shapes on the path to `level`, and the part of its pressure that was reached.
    fn path_to(&self, level: &PressureLevel, elastic: &Elastic) -> (Vec<KnownShape>, f64) {
        let target = Load::new(level.filled(), level.top(), elastic, self.unit);
        let below = self.known.below(&target);
        let begin = below.last().map_or(0.0, |nearest| nearest.load.part_of(&target));
        let undeformed = KnownShape::at_rest(&target, self.unknowns.count());
        let beginning = Beginning::on_the_way(&below, &target).unwrap_or(Beginning::at(&undeformed));
        let (pressures, unit, steps) = (level.pressures.as_slice(), self.unit, Steps::FROM_REST.over(1.0 - begin));
        let path = LoadPath { from: beginning, to: &target, pressures, elastic, unit, steps };
        let settings = StaticSettings { tolerance: EXPLORED, ..self.settings };
        let (points, end) = path.follow(self.unknowns.solver().as_mut(), &settings);
        let part = if end.is_ok() { 1.0 } else { points.last().map_or(0.0, |last| last.part) };
        let reached = begin + (1.0 - begin) * part;
        let on_the_way = points.into_iter().map(|point| KnownShape::new(point.load, point.shape));
        (on_the_way.chain(end.ok().map(|end| KnownShape::new(target, end.unknowns))).collect(), reached)
    }

    /// All levels with these constants.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the level for which no equilibrium was found.
    pub fn solve(&mut self, elastic: &Elastic, derivatives: Derivatives) -> Result<Vec<SimulatedLevel>> {
        if self.known.is_empty() {
            self.follow_paths(elastic, 1.0)?;
        }
        let shares = level_shares(&self.levels, self.solvers.len());
        let Self { levels, settings, unknowns, solvers, known, unit, corrections, .. } = self;
        let (unit, elastic) = (*unit, elastic.clone());
        let part = Part { unknowns, corrections, levels, settings, known, unit, elastic, derivatives };
        let count = solvers.len();
        let tasks = solvers.iter_mut().zip(&shares);
        let parts = run_parallel(tasks, count, |(solver, share)| part.solve(solver.as_mut(), share));
        let Solved { levels: mut solved, on_the_way } =
            parts.into_iter().try_fold(Solved::default(), |merged, part| part.map(|part| merged.and(part)))?;
        solved.iter().for_each(|(_, level)| self.totals.count_level(level, derivatives));
        solved.sort_by_key(|(level, _)| *level);
        let loads: Vec<Load> = (0..solved.len()).map(|level| part.load(level)).collect();
        on_the_way.into_iter().for_each(|shape| self.known.add(shape));
        for (load, (_, simulated)) in loads.into_iter().zip(&mut solved) {
            let (shape, slopes) = (std::mem::take(&mut simulated.shape), std::mem::take(&mut simulated.slopes));
            self.known.add(KnownShape { load, shape, slopes });
        }
        Ok(solved.into_iter().map(|(_, simulated)| simulated).collect())
    }
}

/// The levels by filled chamber and rising pressure, in parts of equal length, so that successive equilibria are close.
fn level_shares(levels: &[PressureLevel], count: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..levels.len()).collect();
    let key = |level: usize| (levels[level].filled(), levels[level].top());
    order.sort_by(|&a, &b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)));
    let end = |part: usize| part * order.len() / count;
    (0..count).map(|part| order[end(part)..end(part + 1)].to_vec()).collect()
}

/// The level of the highest pressure of each filled chamber.
fn highest_levels(levels: &[PressureLevel]) -> Vec<&PressureLevel> {
    let mut tops: Vec<&PressureLevel> = Vec::new();
    for level in levels {
        match tops.iter_mut().find(|top| top.filled() == level.filled()) {
            Some(top) if top.top() < level.top() => *top = level,
            Some(_) => {}
            None => tops.push(level),
        }
    }
    tops
}

/// `work` on all `inputs` in this order, `count` at a time.
fn run_parallel<T: Send, R: Send>(
    inputs: impl IntoIterator<Item = T>,
    count: usize,
    work: impl Fn(T) -> Result<R> + Sync,
) -> Vec<Result<R>> {
    let (mut queue, mut results, work) = (inputs.into_iter().peekable(), Vec::new(), &work);
    while queue.peek().is_some() {
        let batch: Vec<T> = queue.by_ref().take(count).collect();
        std::thread::scope(|scope| {
            let handles: Vec<_> = batch.into_iter().map(|input| scope.spawn(move || work(input))).collect();
            results.extend(handles.into_iter().map(|h| h.join().unwrap_or_else(|_| Err(panic_diagnostic()))));
        });
    }
    results
}

fn panic_diagnostic() -> Diagnostic {
    Diagnostic::new("a solver panicked", "the lines above name the place", "report it with the card and the STL files")
}
