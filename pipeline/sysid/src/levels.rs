//! Equilibria at several pressure levels, solved in parallel; initial guesses are kriged from earlier equilibria.

use std::time::Instant;

use fem::{Equilibrium, Parameter, SolveError, Solver, StaticSettings};
use si::{Pascal, Point2, Second};

use crate::load_path::{LoadPath, Steps};
use crate::model::{BODY, Elastic, Model};
use crate::noise::Covariance2;
use crate::surrogate::{Extra, KnownShape, Load, Slope, Surrogate};
use diagnostics::{Diagnostic, Result};

/// One pressure level and the measured displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureLevel {
    /// One pressure a chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Displacement of each marker in the plane, m.
    pub measured: Vec<Point2>,
    /// Their covariance, m².
    pub covariance: Vec<Covariance2>,
    /// The part of it that all levels of a film share: pose of the camera, position at rest; m².
    pub shared: Vec<Covariance2>,
    /// Positions of the markers at rest, m.
    pub rest: Vec<Point2>,
}

impl PressureLevel {
    /// The highest of its pressures, Pa.
    pub fn top(&self) -> Pascal {
        self.pressures.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The same measurement under `factor` times the pressures.
    fn scaled(&self, factor: f64) -> Self {
        let pressures = self.pressures.iter().map(|pressure| factor * pressure).collect();
        Self { pressures, ..self.clone() }
    }

    /// The chamber with that pressure.
    pub(crate) fn filled(&self) -> usize {
        let order = |a: &usize, b: &usize| self.pressures[*a].total_cmp(&self.pressures[*b]);
        (0..self.pressures.len()).max_by(order).unwrap_or(0)
    }
}

/// One level, simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedLevel {
    /// Displacement of each marker in the plane, m.
    pub markers: Vec<Point2>,
    /// ∂(mean distance)/∂E of each solid of this level's part of the loss, m/Pa; empty unless requested.
    pub gradient: Vec<f64>,
    /// d(marker displacement)/dθ: for E of each solid (m/Pa), then, when requested, ν of each or both ratios of stiffening (m); each
    /// markers × 2.
    pub sensitivities: Vec<Vec<Point2>>,
    /// Displacement of every node, m, 3 a node.
    pub displacement: Vec<f64>,
    /// Derivatives of the displacement by the coordinates of its load; empty unless sensitivities were requested.
    pub(crate) slopes: Vec<Slope>,
    /// Time of the equilibrium, s.
    pub forward_seconds: f64,
    /// Time of gradient or sensitivities on top of it, s.
    pub derivative_seconds: f64,
}

/// Derivatives to compute beside the displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derivatives {
    /// None.
    None,
    /// The adjoint gradient of the mean distance.
    Gradient,
    /// Forward sensitivities of every marker to the moduli.
    Sensitivities,
    /// To the moduli and the Poisson's ratios.
    AllSensitivities,
    /// To the moduli and both ratios of stiffening of the softest solid.
    StiffeningSensitivities,
}

/// Steps along a path from rest, to the highest pressure or beyond it.
const FROM_REST: Steps = Steps { first: 0.1, longest: 0.12, shortest: 1.0 / 64.0 };
/// Steps from the nearest equilibrium that is known.
const FROM_NEARBY: Steps = Steps { first: 0.5, longest: 0.5, shortest: 1.0 / 16.0 };
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
        let system = &self.model.system;
        let to = Load::new(level.filled(), level.top(), elastic, self.unit);
        let (rest, none) = (to.clone().without(), vec![0.0; 3 * system.mesh().nodes.len()]);
        let below = self.known.highest_below(&to);
        let from = below.map_or((&rest, none.as_slice()), |known| (&known.load, known.shape.as_slice()));
        let (begin, steps) = (from.0.part_of(&to), FROM_REST.over(1.0 - from.0.part_of(&to)));
        let (pressures, unit) = (level.pressures.as_slice(), self.unit);
        let path = LoadPath { from, to: &to, pressures, elastic, unit, steps };
        let settings = StaticSettings { tolerance: EXPLORED, ..self.settings };
        let (points, end) = path.follow(&mut system.solver(), &settings);
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

/// The data of one solve, shared by its solvers.
struct Part<'a> {
    model: &'a Model,
    levels: &'a [PressureLevel],
    settings: &'a StaticSettings,
    /// Equilibria of earlier solves.
    known: &'a Surrogate,
    unit: f64,
    elastic: Elastic,
    derivatives: Derivatives,
}

/// Levels with their numbers, and the shapes on the paths that had to be followed to them.
#[derive(Default)]
struct Solved {
    levels: Vec<(usize, SimulatedLevel)>,
    on_the_way: Vec<KnownShape>,
}

impl Solved {
    fn and(mut self, other: Self) -> Self {
        self.levels.extend(other.levels);
        self.on_the_way.extend(other.on_the_way);
        self
    }
}

impl Part<'_> {
    /// Solves some levels, each from the initial guess predicted by earlier solves and by the levels before it.
    fn solve(&self, solver: &mut Solver, numbers: &[usize]) -> Result<Solved> {
        self.elastic.apply(solver)?;
        let (mut solved, mut found) = (Solved::default(), Surrogate::default());
        for &number in numbers {
            let (level, load) = (&self.levels[number], self.load(number));
            let began = Instant::now();
            let (equilibrium, passed) = self.equilibrium(level, &load, &found, solver)?;
            let forward_seconds = began.elapsed().as_secs_f64();
            passed.iter().for_each(|shape| found.add(shape.clone()));
            solved.on_the_way.extend(passed);
            let simulated = self
                .simulated(level, &load, (equilibrium, forward_seconds), solver)
                .map_err(|e| no_equilibrium(level, e.into()))?;
            let (shape, slopes) = (simulated.displacement.clone(), simulated.slopes.clone());
            found.add(KnownShape { load, shape, slopes });
            solved.levels.push((number, simulated));
        }
        Ok(solved)
    }

    fn load(&self, level: usize) -> Load {
        Load::new(self.levels[level].filled(), self.levels[level].top(), &self.elastic, self.unit)
    }

    /// The equilibrium of a level, and the shapes on the path that was followed where no guess led there.
    fn equilibrium(
        &self,
        level: &PressureLevel,
        to: &Load,
        found: &Surrogate,
        solver: &mut Solver,
    ) -> Result<(Equilibrium, Vec<KnownShape>)> {
        let (rest, none) = (to.clone().without(), vec![0.0; 3 * self.model.system.mesh().nodes.len()]);
        // Kriged initial guesses: the Gauss-Newton search of Dory took 23 s instead of 40 s.
        let (from, steps) = match Surrogate::predict(&[found, self.known], to) {
            Some((near, predicted)) => {
                let direct = solver.equilibrium_near(&level.pressures, &near.shape, &predicted, self.settings);
                if let Ok(equilibrium) = direct {
                    return Ok((equilibrium, Vec::new()));
                }
                // A body of other constants may have its wall on the other side of a buckle, and the way from there crosses it backwards:
                // such a level took minutes. Below this one the same body has buckled or not on the way of rising pressure.
                let start = found.highest_below(to).unwrap_or(near);
                ((&start.load, start.shape.as_slice()), FROM_NEARBY)
            }
            None => ((&rest, none.as_slice()), FROM_REST),
        };
        let Self { elastic, unit, .. } = self;
        // Neither the shapes of other constants nor those before a buckle predict the way: it is extrapolated from its own points.
        let path = LoadPath { from, to, pressures: &level.pressures, elastic, unit: *unit, steps };
        let (points, end) = path.follow(solver, self.settings);
        let end = end.map_err(|e| no_equilibrium(level, e))?;
        Ok((end, points.into_iter().map(|point| KnownShape::new(point.load, point.shape)).collect()))
    }

    /// Markers and derivatives at an equilibrium.
    fn simulated(
        &self,
        level: &PressureLevel,
        load: &Load,
        (equilibrium, forward_seconds): (Equilibrium, Second),
        solver: &mut Solver,
    ) -> Result<SimulatedLevel, SolveError> {
        let model = self.model;
        let markers: Vec<Point2> =
            model.markers.iter().map(|spot| Model::in_plane(spot, &equilibrium.displacement)).collect();
        let began = Instant::now();
        let gradient = match self.derivatives {
            Derivatives::Gradient => self.gradient(level, &markers, &equilibrium, solver)?,
            _ => Vec::new(),
        };
        let fields = match self.derivatives {
            Derivatives::None | Derivatives::Gradient => Vec::new(),
            wanted => fields(&equilibrium, solver, &parameters(wanted, model.nominal.youngs_moduli.len()))?,
        };
        let derivative_seconds = began.elapsed().as_secs_f64();
        let of_markers = |field: &Vec<f64>| model.markers.iter().map(|spot| Model::in_plane(spot, field)).collect();
        let sensitivities = fields.iter().map(of_markers).collect();
        let slopes = load.slopes(&self.elastic.youngs_moduli, fields, extra(self.derivatives));
        let displacement = equilibrium.displacement;
        Ok(SimulatedLevel {
            markers,
            gradient,
            sensitivities,
            displacement,
            slopes,
            forward_seconds,
            derivative_seconds,
        })
    }

    /// Gradient by the moduli of this level's part of the mean distance, 1/(levels · markers) Σ |simulated − measured|.
    fn gradient(
        &self,
        level: &PressureLevel,
        markers: &[Point2],
        equilibrium: &Equilibrium,
        solver: &mut Solver,
    ) -> Result<Vec<f64>, SolveError> {
        let share = 1.0 / (self.levels.len() * markers.len()) as f64;
        let mut by_displacement = vec![0.0; equilibrium.displacement.len()];
        for ((spot, simulated), measured) in self.model.markers.iter().zip(markers).zip(&level.measured) {
            let off = [simulated[0] - measured[0], simulated[1] - measured[1]];
            let distance = off[0].hypot(off[1]).max(f64::MIN_POSITIVE);
            for &(node, weight) in &spot.weights {
                for k in 0..2 {
                    by_displacement[3 * node as usize + k] += share * weight * off[k] / distance;
                }
            }
        }
        let regions = solver.adjoint(equilibrium, &by_displacement)?;
        Ok(regions.iter().map(|region| region.youngs_modulus).collect())
    }
}

/// The moduli of all solids, then what else is wanted.
fn parameters(wanted: Derivatives, solids: usize) -> Vec<Parameter> {
    let moduli = (0..solids).map(Parameter::YoungsModulus);
    match wanted {
        Derivatives::AllSensitivities => moduli.chain((0..solids).map(Parameter::PoissonsRatio)).collect(),
        Derivatives::StiffeningSensitivities => moduli.chain(TERMS.map(stiffening)).collect(),
        _ => moduli.collect(),
    }
}

/// The terms of [`Parameter::Stiffening`].
const TERMS: [usize; 2] = [0, 1];

fn stiffening(term: usize) -> Parameter {
    Parameter::Stiffening { region: BODY, term }
}

/// Derivatives of all displacements by each parameter, 3 entries per node, m per its unit.
fn fields(
    equilibrium: &Equilibrium,
    solver: &mut Solver,
    parameters: &[Parameter],
) -> Result<Vec<Vec<f64>>, SolveError> {
    parameters.iter().map(|&parameter| solver.sensitivity(equilibrium, parameter)).collect()
}

/// What sensitivities are by, beside the moduli.
fn extra(wanted: Derivatives) -> Extra {
    if wanted == Derivatives::AllSensitivities { Extra::PoissonsRatios } else { Extra::Stiffening }
}

fn no_equilibrium(level: &PressureLevel, error: Diagnostic) -> Diagnostic {
    let pressures: Vec<String> = level.pressures.iter().map(|p| format!("{:.1}", p / si::MILLIBAR)).collect();
    error.while_doing(format!("no equilibrium at {} mbar", pressures.join(" / ")))
}

fn panicked() -> Diagnostic {
    Diagnostic::new("a solver panicked", "the lines above name the place", "report it with the card and the STL files")
}
