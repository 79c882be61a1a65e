//! The ladder: equilibria at several pressure levels, solved side by side, each from what the ones before foretell of it.
//!
//! Stands on: the model, known, fem. Never knows: an optimiser, a trial.

use std::time::Instant;

use fem::{Equilibrium, Parameter, SolveError, Solver, StaticSettings};
use si::{Pascal, Point2};

use super::known::{Known, Load};
use super::{BODY, Elastic, Model, SPINE};
use crate::fault::{Fault, Outcome};
use crate::records::Spread;

/// One pressure level and what was measured there.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// One pressure a chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Displacement of each marker in the plane, m.
    pub measured: Vec<Point2>,
    /// How well that is known, m².
    pub spread: Vec<Spread>,
}

impl Rung {
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
pub struct Simulated {
    /// Displacement of each marker in the plane, m.
    pub markers: Vec<Point2>,
    /// ∂(mean distance)/∂E of body and spine of this level's part of the loss, m/Pa; empty unless asked for.
    pub gradient: Vec<f64>,
    /// d(marker displacement)/dθ: for E of body and spine (m/Pa), then, when asked for, ν of both (m); each markers × 2.
    pub slopes: Vec<Vec<Point2>>,
    /// Displacement of every node, m, 3 a node.
    pub displacement: Vec<f64>,
    /// Time of the equilibrium, s.
    pub forward_seconds: f64,
    /// Time of gradient or slopes on top of it, s.
    pub derivative_seconds: f64,
}

/// Which derivatives are wanted beside the displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// None.
    Nothing,
    /// The adjoint gradient of the mean distance.
    Gradient,
    /// Forward sensitivities of every marker to both moduli.
    Slopes,
    /// To both moduli and both Poisson's ratios.
    AllSlopes,
}

/// How often a load step is halved where no shape is known to begin from; what is asked of later solves may be less.
const COLD_HALVINGS: usize = 6;

/// Solvers, and the shapes that they found.
pub struct Ladder {
    model: Model,
    rungs: Vec<Rung>,
    settings: StaticSettings,
    solvers: Vec<Solver>,
    known: Known,
}

impl Ladder {
    /// A ladder over the levels with so many solvers side by side.
    pub fn new(model: Model, rungs: Vec<Rung>, settings: StaticSettings, side_by_side: usize) -> Self {
        let solvers = (0..side_by_side.clamp(1, rungs.len().max(1))).map(|_| model.system.solver()).collect();
        Self { model, rungs, settings, solvers, known: Known::default() }
    }

    /// All levels with these constants of body and spine.
    ///
    /// # Errors
    /// A [`Fault`] that names the level for which no equilibrium was found.
    pub fn climb(&mut self, elastic: &Elastic, want: Want) -> Outcome<Vec<Simulated>> {
        let shares = shares(&self.rungs, self.solvers.len());
        let Self { model, rungs, settings, solvers, known } = self;
        let part = Part { model, rungs, settings, known, elastic: *elastic, want };
        let mut parts: Vec<Outcome<Vec<(usize, Simulated)>>> = Vec::new();
        std::thread::scope(|scope| {
            let part = &part;
            let climb = |(solver, share): (&'_ mut Solver, &'_ Vec<usize>)| part.climb(solver, share);
            let handles: Vec<_> = solvers.iter_mut().zip(&shares).map(|one| scope.spawn(move || climb(one))).collect();
            parts.extend(handles.into_iter().map(|h| h.join().unwrap_or_else(|_| Err(broke_down()))));
        });
        let mut all: Vec<(usize, Simulated)> = Vec::new();
        for part in parts {
            all.extend(part?);
        }
        all.sort_by_key(|(level, _)| *level);
        let loads: Vec<Load> = (0..all.len()).map(|level| part.load(level)).collect();
        for (load, (_, simulated)) in loads.into_iter().zip(&all) {
            self.known.learn(load, simulated.displacement.clone());
        }
        Ok(all.into_iter().map(|(_, simulated)| simulated).collect())
    }
}

/// The levels by filled chamber and rising pressure, in so many parts of like length: what follows begins near what was found.
fn shares(rungs: &[Rung], count: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..rungs.len()).collect();
    let key = |level: usize| (rungs[level].filled(), rungs[level].top());
    order.sort_by(|&a, &b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)));
    let end = |part: usize| part * order.len() / count;
    (0..count).map(|part| order[end(part)..end(part + 1)].to_vec()).collect()
}

/// One climb, as each of its solvers sees it.
struct Part<'a> {
    model: &'a Model,
    rungs: &'a [Rung],
    settings: &'a StaticSettings,
    /// From earlier climbs.
    known: &'a Known,
    elastic: Elastic,
    want: Want,
}

impl Part<'_> {
    /// Some levels, each from the shape that earlier climbs and the levels before it foretell.
    fn climb(&self, solver: &mut Solver, levels: &[usize]) -> Outcome<Vec<(usize, Simulated)>> {
        self.elastic.give(solver)?;
        let (mut done, mut found) = (Vec::new(), Known::default());
        for &level in levels {
            let (rung, load) = (&self.rungs[level], self.load(level));
            let start = found.foretell(self.known, load);
            let simulated = self.climb_one(rung, start, solver).map_err(|e| no_equilibrium(rung, &e))?;
            found.learn(load, simulated.displacement.clone());
            done.push((level, simulated));
        }
        Ok(done)
    }

    fn load(&self, level: usize) -> Load {
        let highest = self.rungs.iter().map(Rung::top).fold(f64::MIN_POSITIVE, f64::max);
        let unit = highest / self.model.nominal.youngs_moduli[BODY];
        Load::new(self.rungs[level].filled(), self.rungs[level].top(), &self.elastic, unit)
    }

    fn climb_one(
        &self,
        rung: &Rung,
        start: Option<(&[f64], Vec<f64>)>,
        solver: &mut Solver,
    ) -> Result<Simulated, SolveError> {
        let Self { model, settings, .. } = self;
        let cold =
            StaticSettings { tolerance: settings.tolerance, halvings: COLD_HALVINGS, ..StaticSettings::default() };
        let began = Instant::now();
        let equilibrium = match start {
            Some((found, foretold)) => solver.equilibrium_ahead(&rung.pressures, found, &foretold, settings)?,
            None => solver.equilibrium(&rung.pressures, None, &cold)?,
        };
        let forward_seconds = began.elapsed().as_secs_f64();
        let markers: Vec<Point2> =
            model.markers.iter().map(|spot| Model::in_plane(spot, &equilibrium.displacement)).collect();
        let began = Instant::now();
        let gradient = match self.want {
            Want::Gradient => gradient(model, rung, self.rungs.len(), &markers, &equilibrium, solver)?,
            _ => Vec::new(),
        };
        let slopes = match self.want {
            Want::Slopes => slopes(model, &equilibrium, solver, &MODULI)?,
            Want::AllSlopes => slopes(model, &equilibrium, solver, &CONSTANTS)?,
            _ => Vec::new(),
        };
        let derivative_seconds = began.elapsed().as_secs_f64();
        let displacement = equilibrium.displacement;
        Ok(Simulated { markers, gradient, slopes, displacement, forward_seconds, derivative_seconds })
    }
}

/// Gradient by the moduli of this level's part of the mean distance, 1/(rungs · markers) Σ |simulated − measured|.
fn gradient(
    model: &Model,
    rung: &Rung,
    rungs: usize,
    markers: &[Point2],
    equilibrium: &Equilibrium,
    solver: &mut Solver,
) -> Result<Vec<f64>, SolveError> {
    let share = 1.0 / (rungs * markers.len()) as f64;
    let mut by_displacement = vec![0.0; equilibrium.displacement.len()];
    for ((spot, simulated), measured) in model.markers.iter().zip(markers).zip(&rung.measured) {
        let off = [simulated[0] - measured[0], simulated[1] - measured[1]];
        let distance = off[0].hypot(off[1]).max(f64::MIN_POSITIVE);
        for &(node, weight) in &spot.weights {
            for k in 0..2 {
                by_displacement[3 * node as usize + k] += share * weight * off[k] / distance;
            }
        }
    }
    let regions = solver.adjoint(equilibrium, &by_displacement)?;
    Ok([BODY, SPINE].map(|region| regions[region].youngs_modulus).to_vec())
}

const MODULI: [Parameter; 2] = [Parameter::YoungsModulus(BODY), Parameter::YoungsModulus(SPINE)];

const CONSTANTS: [Parameter; 4] =
    [MODULI[0], MODULI[1], Parameter::PoissonsRatio(BODY), Parameter::PoissonsRatio(SPINE)];

fn slopes(
    model: &Model,
    equilibrium: &Equilibrium,
    solver: &mut Solver,
    parameters: &[Parameter],
) -> Result<Vec<Vec<Point2>>, SolveError> {
    let slope = |&parameter: &Parameter| {
        let by_constant = solver.sensitivity(equilibrium, parameter)?;
        Ok(model.markers.iter().map(|spot| Model::in_plane(spot, &by_constant)).collect())
    };
    parameters.iter().map(slope).collect()
}

fn no_equilibrium(rung: &Rung, error: &SolveError) -> Fault {
    let pressures: Vec<String> = rung.pressures.iter().map(|p| format!("{:.1}", p / si::MILLIBAR)).collect();
    Fault::from_tool(format!("no equilibrium at {} mbar: {error}", pressures.join(" / ")))
}

fn broke_down() -> Fault {
    Fault::new("a solver broke down", "the lines above name the place", "report it with the card and the STL files")
}
