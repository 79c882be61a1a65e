//! Solvers that share the levels of a body between them.

use fem::{Solver, StaticSettings};

use super::level::{Derivatives, PressureLevel, SimulatedLevel};
use super::part::{Part, Solved};
use crate::load_path::{Beginning, LoadPath, Steps};
use crate::model::{BODY, Elastic, Model};
use crate::surrogate::{KnownShape, Load, Surrogate};
use diagnostics::{Diagnostic, Result};

/// Tolerance of equilibria that serve as initial guesses alone.
const EXPLORED: f64 = 1e-4;

/// Solvers, and the surrogate of their equilibria.
pub struct LevelSolver {
    model: Model,
    levels: Vec<PressureLevel>,
    settings: StaticSettings,
    solvers: Vec<Solver>,
    known: Surrogate,
    /// See [`Load::new`].
    unit: f64,
}

impl LevelSolver {
    /// A solver over the levels with this many parallel solvers; of the settings, tolerance and iterations of Newton's method count.
    pub fn new(model: Model, levels: Vec<PressureLevel>, settings: StaticSettings, parallel: usize) -> Self {
        let solvers = (0..parallel.clamp(1, levels.len().max(1))).map(|_| model.system.solver()).collect();
        let highest = levels.iter().map(PressureLevel::top).fold(f64::MIN_POSITIVE, f64::max);
        let unit = highest / model.nominal.youngs_moduli[BODY];
        Self { model, levels, settings, solvers, known: Surrogate::default(), unit }
    }

    /// What it solves.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The same equilibria as initial guesses for other `levels` or `settings` of the same specimen.
    pub fn with(&self, levels: Vec<PressureLevel>, settings: StaticSettings) -> Self {
        let parallel = self.solvers.len();
        Self { known: self.known.clone(), unit: self.unit, ..Self::new(self.model.clone(), levels, settings, parallel) }
    }

    /// Follows the equilibria with these constants, from rest or the highest that is known, to `reach` times the highest pressure of each
    /// filled chamber, and returns the part of these pressures that all reached. They are the initial guesses of what is solved later.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a solver panics.
    pub(crate) fn follow_paths(&mut self, elastic: &Elastic, reach: f64) -> Result<f64> {
        let tops: Vec<PressureLevel> = tops(&self.levels).into_iter().map(|top| top.scaled(reach)).collect();
        let mut all = 1.0_f64;
        for path in parallel(&tops, self.solvers.len(), |level| Ok(self.path_to(level, elastic))) {
            let (shapes, reached) = path?;
            all = all.min(reached);
            shapes.into_iter().for_each(|shape| self.known.add(shape));
        }
        Ok(all * reach)
    }

    /// Loads and shapes on the path to `level`, and the part of its pressure that was reached.
    fn path_to(&self, level: &PressureLevel, elastic: &Elastic) -> (Vec<KnownShape>, f64) {
        let to = Load::new(level.filled(), level.top(), elastic, self.unit);
        let below = self.known.below(&to);
        let begin = below.last().map_or(0.0, |from| from.load.part_of(&to));
        let rest = KnownShape::at_rest(&to, self.model.system.mesh().nodes.len());
        let from = Beginning::on_the_way(&below, &to).unwrap_or(Beginning::at(&rest));
        let (pressures, unit, steps) = (level.pressures.as_slice(), self.unit, Steps::FROM_REST.over(1.0 - begin));
        let path = LoadPath { from, to: &to, pressures, elastic, unit, steps };
        let settings = StaticSettings { tolerance: EXPLORED, ..self.settings };
        let (points, end) = path.follow(&mut self.model.system.solver(), &settings);
        let part = if end.is_ok() { 1.0 } else { points.last().map_or(0.0, |last| last.part) };
        let reached = begin + (1.0 - begin) * part;
        let on_the_way = points.into_iter().map(|point| KnownShape::new(point.load, point.shape));
        (on_the_way.chain(end.ok().map(|end| KnownShape::new(to, end.displacement))).collect(), reached)
    }

    /// All levels with these constants.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the level for which no equilibrium was found.
    pub fn solve(&mut self, elastic: &Elastic, derivatives: Derivatives) -> Result<Vec<SimulatedLevel>> {
        if self.known.is_empty() {
            self.follow_paths(elastic, 1.0)?;
        }
        let shares = shares(&self.levels, self.solvers.len());
        let Self { model, levels, settings, solvers, known, unit } = self;
        let part = Part { model, levels, settings, known, unit: *unit, elastic: elastic.clone(), derivatives };
        let count = solvers.len();
        let each = solvers.iter_mut().zip(&shares);
        let parts = parallel(each, count, |(solver, share)| part.solve(solver, share));
        let Solved { levels: mut all, on_the_way } =
            parts.into_iter().try_fold(Solved::default(), |all, part| part.map(|part| all.and(part)))?;
        all.sort_by_key(|(level, _)| *level);
        let loads: Vec<Load> = (0..all.len()).map(|level| part.load(level)).collect();
        on_the_way.into_iter().for_each(|shape| self.known.add(shape));
        for (load, (_, simulated)) in loads.into_iter().zip(&mut all) {
            let (shape, slopes) = (simulated.displacement.clone(), std::mem::take(&mut simulated.slopes));
            self.known.add(KnownShape { load, shape, slopes });
        }
        Ok(all.into_iter().map(|(_, simulated)| simulated).collect())
    }
}

/// The levels by filled chamber and rising pressure, in parts of equal length, so that successive equilibria are close.
fn shares(levels: &[PressureLevel], count: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..levels.len()).collect();
    let key = |level: usize| (levels[level].filled(), levels[level].top());
    order.sort_by(|&a, &b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)));
    let end = |part: usize| part * order.len() / count;
    (0..count).map(|part| order[end(part)..end(part + 1)].to_vec()).collect()
}

/// The level of the highest pressure of each filled chamber.
fn tops(levels: &[PressureLevel]) -> Vec<&PressureLevel> {
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

/// `work` on all `of` in this order, `count` at a time.
fn parallel<T: Send, R: Send>(
    of: impl IntoIterator<Item = T>,
    count: usize,
    work: impl Fn(T) -> Result<R> + Sync,
) -> Vec<Result<R>> {
    let (mut left, mut done, work) = (of.into_iter().peekable(), Vec::new(), &work);
    while left.peek().is_some() {
        let some: Vec<T> = left.by_ref().take(count).collect();
        std::thread::scope(|scope| {
            let handles: Vec<_> = some.into_iter().map(|one| scope.spawn(move || work(one))).collect();
            done.extend(handles.into_iter().map(|h| h.join().unwrap_or_else(|_| Err(panicked()))));
        });
    }
    done
}

fn panicked() -> Diagnostic {
    Diagnostic::new("a solver panicked", "the lines above name the place", "report it with the card and the STL files")
}
