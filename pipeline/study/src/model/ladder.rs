//! The ladder: equilibria at several pressure levels, solved side by side and warm from the last solution of each level.
//!
//! Stands on: the model, fem. Never knows: an optimiser, a trial.

use std::time::Instant;

use fem::{Equilibrium, Parameter, SolveError, Solver, StaticSettings};
use si::{Pascal, Point2};

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

/// Solvers that keep the last solution of each level.
pub struct Ladder {
    model: Model,
    rungs: Vec<Rung>,
    settings: StaticSettings,
    solvers: Vec<Solver>,
    last: Vec<Option<Known>>,
}

/// A filled chamber, and its pressure over the body's modulus.
type Load = (usize, f64);

/// A solution and what it was solved for.
#[derive(Debug, Clone)]
struct Known {
    /// The chamber that is filled most, and its pressure over the body's modulus: what bends a soft body, most of all.
    load: Load,
    displacement: Vec<f64>,
}

impl Ladder {
    /// A ladder over the levels with so many solvers side by side.
    pub fn new(model: Model, rungs: Vec<Rung>, settings: StaticSettings, side_by_side: usize) -> Self {
        let solvers = (0..side_by_side.clamp(1, rungs.len().max(1))).map(|_| model.system.solver()).collect();
        let last = vec![None; rungs.len()];
        Self { model, rungs, settings, solvers, last }
    }

    /// All levels with these constants of body and spine.
    ///
    /// # Errors
    /// A [`Fault`] that names the level for which no equilibrium was found.
    pub fn climb(&mut self, elastic: &Elastic, want: Want) -> Outcome<Vec<Simulated>> {
        let body_e = elastic.youngs_moduli[0];
        let count = self.solvers.len();
        let (model, rungs, settings, last) = (&self.model, &self.rungs, &self.settings, &self.last);
        let mut parts: Vec<Outcome<Vec<(usize, Simulated)>>> = Vec::new();
        std::thread::scope(|scope| {
            let climb_part = |(first, solver): (usize, &'_ mut Solver)| {
                elastic.give(solver)?;
                climb_every(model, rungs, settings, last, solver, want, body_e, first, count)
            };
            let handles: Vec<_> =
                self.solvers.iter_mut().enumerate().map(|part| scope.spawn(move || climb_part(part))).collect();
            parts.extend(handles.into_iter().map(|h| h.join().unwrap_or_else(|_| Err(broke_down()))));
        });
        let mut all: Vec<(usize, Simulated)> = Vec::new();
        for part in parts {
            all.extend(part?);
        }
        all.sort_by_key(|(level, _)| *level);
        for (level, simulated) in &all {
            let load = load(&self.rungs[*level], body_e);
            self.last[*level] = Some(Known { load, displacement: simulated.displacement.clone() });
        }
        Ok(all.into_iter().map(|(_, simulated)| simulated).collect())
    }
}

/// Every `stride`th level from `first` on, each from the known solution whose load is nearest.
#[allow(clippy::too_many_arguments)]
fn climb_every(
    model: &Model,
    rungs: &[Rung],
    settings: &StaticSettings,
    last: &[Option<Known>],
    solver: &mut Solver,
    want: Want,
    body_e: Pascal,
    first: usize,
    stride: usize,
) -> Outcome<Vec<(usize, Simulated)>> {
    let mut done: Vec<(usize, Simulated)> = Vec::new();
    for level in (first..rungs.len()).step_by(stride) {
        let known = last.iter().flatten().map(|known| (known.load, known.displacement.as_slice()));
        let known = known.chain(done.iter().map(|(i, s)| (load(&rungs[*i], body_e), s.displacement.as_slice())));
        let (chamber, here) = load(&rungs[level], body_e);
        let away = |other: f64| (other / here).ln().abs();
        let known = known.filter(|((filled, _), _)| *filled == chamber);
        let start = known.min_by(|a, b| away(a.0.1).total_cmp(&away(b.0.1))).map(|(_, displacement)| displacement);
        let simulated = climb_one(model, &rungs[level], rungs.len(), settings, start, solver, want);
        done.push((level, simulated.map_err(|e| no_equilibrium(&rungs[level], &e))?));
    }
    Ok(done)
}

/// How often a load step is halved where no shape is known to begin from; what is asked of later solves may be less.
const COLD_HALVINGS: usize = 6;

fn load(rung: &Rung, body_e: Pascal) -> Load {
    (rung.filled(), rung.top() / body_e)
}

fn climb_one(
    model: &Model,
    rung: &Rung,
    rungs: usize,
    settings: &StaticSettings,
    start: Option<&[f64]>,
    solver: &mut Solver,
    want: Want,
) -> Result<Simulated, SolveError> {
    let patient = StaticSettings { tolerance: settings.tolerance, ..StaticSettings::default() };
    let settings = if start.is_some() { settings } else { &StaticSettings { halvings: COLD_HALVINGS, ..patient } };
    let began = Instant::now();
    let equilibrium = solver.equilibrium(&rung.pressures, start, settings)?;
    let forward_seconds = began.elapsed().as_secs_f64();
    let markers: Vec<Point2> =
        model.markers.iter().map(|spot| Model::in_plane(spot, &equilibrium.displacement)).collect();
    let began = Instant::now();
    let gradient = match want {
        Want::Gradient => gradient(model, rung, rungs, &markers, &equilibrium, solver)?,
        _ => Vec::new(),
    };
    let slopes = match want {
        Want::Slopes => slopes(model, &equilibrium, solver, &MODULI)?,
        Want::AllSlopes => slopes(model, &equilibrium, solver, &CONSTANTS)?,
        _ => Vec::new(),
    };
    let derivative_seconds = began.elapsed().as_secs_f64();
    let displacement = equilibrium.displacement;
    Ok(Simulated { markers, gradient, slopes, displacement, forward_seconds, derivative_seconds })
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
