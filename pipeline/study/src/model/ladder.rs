//! The ladder: equilibria at several pressure levels, solved side by side and warm from the last solution of each level.
//!
//! Stands on: the model, fem. Never knows: an optimiser, a trial.

use std::time::Instant;

use fem::{Equilibrium, Parameter, SolveError, Solver, StaticSettings};
use si::{Pascal, Point2};

use super::{BODY, Model, SPINE};
use crate::fault::{Fault, Outcome};

/// One pressure level and what was measured there.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// One pressure a chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Displacement of each marker in the plane, m.
    pub measured: Vec<Point2>,
}

/// One level, simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Displacement of each marker in the plane, m.
    pub markers: Vec<Point2>,
    /// ∂(mean distance)/∂E of body and spine of this level's part of the loss, m/Pa; empty unless asked for.
    pub gradient: Vec<f64>,
    /// d(marker displacement)/dE: for body and spine, markers × 2, m/Pa; empty unless asked for.
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
    /// Forward sensitivities of every marker.
    Slopes,
}

/// Solvers that keep the last solution of each level.
pub struct Ladder {
    model: Model,
    rungs: Vec<Rung>,
    settings: StaticSettings,
    solvers: Vec<Solver>,
    last: Vec<Option<Known>>,
}

/// A solution and what it was solved for.
#[derive(Debug, Clone)]
struct Known {
    /// The highest pressure over the body's modulus: what bends a soft body, most of all.
    load: f64,
    displacement: Vec<f64>,
}

impl Ladder {
    /// A ladder over the levels with so many solvers side by side.
    pub fn new(model: Model, rungs: Vec<Rung>, settings: StaticSettings, side_by_side: usize) -> Self {
        let solvers = (0..side_by_side.clamp(1, rungs.len().max(1))).map(|_| model.system.solver()).collect();
        let last = vec![None; rungs.len()];
        Self { model, rungs, settings, solvers, last }
    }

    /// The levels.
    pub fn rungs(&self) -> &[Rung] {
        &self.rungs
    }

    /// All levels with these Young's moduli (Pa).
    ///
    /// # Errors
    /// A [`Fault`] that names the level for which no equilibrium was found.
    pub fn climb(&mut self, body_e: Pascal, spine_e: Pascal, want: Want) -> Outcome<Vec<Simulated>> {
        let count = self.solvers.len();
        let (model, rungs, settings, last) = (&self.model, &self.rungs, &self.settings, &self.last);
        let mut parts: Vec<Outcome<Vec<(usize, Simulated)>>> = Vec::new();
        std::thread::scope(|scope| {
            let climb_part = |(first, solver): (usize, &'_ mut Solver)| {
                model.set_moduli(solver, [body_e, spine_e])?;
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
        let away = |other: f64| (other / load(&rungs[level], body_e)).ln().abs();
        let start = known.min_by(|a, b| away(a.0).total_cmp(&away(b.0))).map(|(_, displacement)| displacement);
        let simulated = climb_one(model, &rungs[level], rungs.len(), settings, start, solver, want);
        done.push((level, simulated.map_err(|e| no_equilibrium(&rungs[level], &e))?));
    }
    Ok(done)
}

fn load(rung: &Rung, body_e: Pascal) -> f64 {
    rung.pressures.iter().copied().fold(f64::MIN_POSITIVE, f64::max) / body_e
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
        Want::Slopes => slopes(model, &equilibrium, solver)?,
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

fn slopes(model: &Model, equilibrium: &Equilibrium, solver: &mut Solver) -> Result<Vec<Vec<Point2>>, SolveError> {
    [BODY, SPINE]
        .into_iter()
        .map(|region| {
            let by_modulus = solver.sensitivity(equilibrium, Parameter::YoungsModulus(region))?;
            Ok(model.markers.iter().map(|spot| Model::in_plane(spot, &by_modulus)).collect())
        })
        .collect()
}

fn no_equilibrium(rung: &Rung, error: &SolveError) -> Fault {
    let pressures: Vec<String> = rung.pressures.iter().map(|p| format!("{:.1}", p / si::MILLIBAR)).collect();
    Fault::from_tool(format!("no equilibrium at {} mbar: {error}", pressures.join(" / ")))
}

fn broke_down() -> Fault {
    Fault::new("a solver broke down", "the lines above name the place", "report it with the card and the STL files")
}
