//! Equilibria at several pressure levels, solved in parallel; initial guesses are kriged from earlier equilibria.

use std::time::Instant;

use fem::{Equilibrium, Parameter, SolveError, Solver, StaticSettings};
use si::{Pascal, Point2};

use crate::model::{BODY, Elastic, Model};
use crate::noise::Covariance2;
use crate::surrogate::{Load, Surrogate};
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
}

impl PressureLevel {
    /// The highest of its pressures, Pa.
    pub fn top(&self) -> Pascal {
        self.pressures.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The chamber with that pressure.
    fn filled(&self) -> usize {
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

/// Halvings of a load step without an initial guess; later solves may be limited to fewer.
const COLD_HALVINGS: usize = 6;

/// Solvers, and the surrogate of their equilibria.
pub struct LevelSolver {
    model: Model,
    levels: Vec<PressureLevel>,
    settings: StaticSettings,
    solvers: Vec<Solver>,
    known: Surrogate,
}

impl LevelSolver {
    /// A solver over the levels with this many parallel solvers.
    pub fn new(model: Model, levels: Vec<PressureLevel>, settings: StaticSettings, parallel: usize) -> Self {
        let solvers = (0..parallel.clamp(1, levels.len().max(1))).map(|_| model.system.solver()).collect();
        Self { model, levels, settings, solvers, known: Surrogate::default() }
    }

    /// All levels with these constants.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names the level for which no equilibrium was found.
    pub fn solve(&mut self, elastic: &Elastic, derivatives: Derivatives) -> Result<Vec<SimulatedLevel>> {
        let shares = shares(&self.levels, self.solvers.len());
        let Self { model, levels, settings, solvers, known } = self;
        let part = Part { model, levels, settings, known, elastic: elastic.clone(), derivatives };
        let mut parts: Vec<Result<Vec<(usize, SimulatedLevel)>>> = Vec::new();
        std::thread::scope(|scope| {
            let part = &part;
            let solve = |(solver, share): (&'_ mut Solver, &'_ Vec<usize>)| part.solve(solver, share);
            let handles: Vec<_> = solvers.iter_mut().zip(&shares).map(|one| scope.spawn(move || solve(one))).collect();
            parts.extend(handles.into_iter().map(|h| h.join().unwrap_or_else(|_| Err(panicked()))));
        });
        let mut all: Vec<(usize, SimulatedLevel)> = Vec::new();
        for part in parts {
            all.extend(part?);
        }
        all.sort_by_key(|(level, _)| *level);
        let loads: Vec<Load> = (0..all.len()).map(|level| part.load(level)).collect();
        for (load, (_, simulated)) in loads.into_iter().zip(&all) {
            self.known.add(load, simulated.displacement.clone());
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

/// The data of one solve, shared by its solvers.
struct Part<'a> {
    model: &'a Model,
    levels: &'a [PressureLevel],
    settings: &'a StaticSettings,
    /// Equilibria of earlier solves.
    known: &'a Surrogate,
    elastic: Elastic,
    derivatives: Derivatives,
}

impl Part<'_> {
    /// Solves some levels, each from the initial guess predicted by earlier solves and by the levels before it.
    fn solve(&self, solver: &mut Solver, numbers: &[usize]) -> Result<Vec<(usize, SimulatedLevel)>> {
        self.elastic.apply(solver)?;
        let (mut done, mut found) = (Vec::new(), Surrogate::default());
        for &number in numbers {
            let (level, load) = (&self.levels[number], self.load(number));
            // Kriged initial guesses: the Gauss-Newton search of Dory took 23 s instead of 40 s.
            let start = found.predict(self.known, &load);
            let simulated = self.solve_one(level, start, solver).map_err(|e| no_equilibrium(level, e))?;
            found.add(load, simulated.displacement.clone());
            done.push((number, simulated));
        }
        Ok(done)
    }

    fn load(&self, level: usize) -> Load {
        let highest = self.levels.iter().map(PressureLevel::top).fold(f64::MIN_POSITIVE, f64::max);
        let unit = highest / self.model.nominal.youngs_moduli[BODY];
        Load::new(self.levels[level].filled(), self.levels[level].top(), &self.elastic, unit)
    }

    fn solve_one(
        &self,
        level: &PressureLevel,
        start: Option<(&[f64], Vec<f64>)>,
        solver: &mut Solver,
    ) -> Result<SimulatedLevel, SolveError> {
        let Self { model, settings, .. } = self;
        let cold =
            StaticSettings { tolerance: settings.tolerance, max_halvings: COLD_HALVINGS, ..StaticSettings::default() };
        let began = Instant::now();
        let equilibrium = match start {
            Some((found, predicted)) => {
                solver.equilibrium_from_prediction(&level.pressures, found, &predicted, settings)?
            }
            None => solver.equilibrium(&level.pressures, None, &cold)?,
        };
        let forward_seconds = began.elapsed().as_secs_f64();
        let markers: Vec<Point2> =
            model.markers.iter().map(|spot| Model::in_plane(spot, &equilibrium.displacement)).collect();
        let began = Instant::now();
        let gradient = match self.derivatives {
            Derivatives::Gradient => self.gradient(level, &markers, &equilibrium, solver)?,
            _ => Vec::new(),
        };
        let sensitivities = match self.derivatives {
            Derivatives::None | Derivatives::Gradient => Vec::new(),
            wanted => {
                sensitivities(model, &equilibrium, solver, &parameters(wanted, model.nominal.youngs_moduli.len()))?
            }
        };
        let derivative_seconds = began.elapsed().as_secs_f64();
        let displacement = equilibrium.displacement;
        Ok(SimulatedLevel { markers, gradient, sensitivities, displacement, forward_seconds, derivative_seconds })
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

fn sensitivities(
    model: &Model,
    equilibrium: &Equilibrium,
    solver: &mut Solver,
    parameters: &[Parameter],
) -> Result<Vec<Vec<Point2>>, SolveError> {
    let sensitivity = |&parameter: &Parameter| {
        let by_constant = solver.sensitivity(equilibrium, parameter)?;
        Ok(model.markers.iter().map(|spot| Model::in_plane(spot, &by_constant)).collect())
    };
    parameters.iter().map(sensitivity).collect()
}

fn no_equilibrium(level: &PressureLevel, error: SolveError) -> Diagnostic {
    let pressures: Vec<String> = level.pressures.iter().map(|p| format!("{:.1}", p / si::MILLIBAR)).collect();
    Diagnostic::from(error).while_doing(format!("no equilibrium at {} mbar", pressures.join(" / ")))
}

fn panicked() -> Diagnostic {
    Diagnostic::new("a solver panicked", "the lines above name the place", "report it with the card and the STL files")
}
