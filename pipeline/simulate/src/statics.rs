//! Equilibria of successive levels, each started from the one before.

use std::sync::Arc;

use fem::{Equilibrium, SolveError, Solver, StaticSettings};
use si::Pascal;

use crate::budget::{Exceeded, Watch};
use crate::case::Static;
use crate::frames::Frame;
use crate::probes::Solved;
use crate::{Simulation, Summary};
use diagnostics::{Diagnostic, Result};

/// The levels of a case, solved one after the other: what the command line and the Python package share.
pub struct Levels {
    settings: StaticSettings,
    watch: Arc<Watch>,
    guess: Option<Vec<f64>>,
    before: Option<Converged>,
}

/// A converged state.
#[derive(Debug, Clone, PartialEq)]
pub struct Converged {
    /// Its level.
    pub level: f64,
    /// 3 a node, m.
    pub displacement: Vec<f64>,
    /// One a chamber of the mesh, Pa.
    pub pressures: Vec<Pascal>,
}

/// A level without an equilibrium.
#[derive(Debug)]
pub struct LostLevel {
    /// Which level.
    pub level: f64,
    /// Why.
    pub cause: SolveError,
    /// The limit of its budget that was reached, where that ended it.
    pub exceeded: Option<Exceeded>,
    /// The last converged state, on the way to this level or at the one before.
    pub last: Option<Converged>,
}

impl Levels {
    /// Levels from rest; the solver is to ask the interrupt of `watch`.
    pub fn new(settings: StaticSettings, watch: Arc<Watch>) -> Self {
        Self { settings, watch, guess: None, before: None }
    }

    /// The same from a shape near the first of them, 3 a node, m.
    #[must_use]
    pub fn near(self, guess: Option<Vec<f64>>) -> Self {
        Self { guess, ..self }
    }

    /// The equilibrium of a level, whose forces the solver has.
    ///
    /// # Errors
    /// [`LostLevel`]
    pub fn solve(
        &mut self,
        solver: &mut Solver,
        level: f64,
        pressures: &[Pascal],
    ) -> std::result::Result<Equilibrium, Box<LostLevel>> {
        self.watch.restart();
        let start_shape =
            self.before.as_ref().map(|before| &before.displacement).or(self.guess.as_ref()).map(Vec::as_slice);
        match solver.equilibrium(pressures, start_shape, &self.settings) {
            Ok(found) => {
                let (displacement, pressures) = (found.displacement.clone(), pressures.to_vec());
                self.before = Some(Converged { level, displacement, pressures });
                Ok(found)
            }
            Err(cause) => Err(Box::new(LostLevel::of(cause, level, self.watch.exceeded(), self.before.take()))),
        }
    }
}

impl LostLevel {
    /// A level that was lost for a `cause`, after the state `before`.
    pub fn of(cause: SolveError, level: f64, exceeded: Option<Exceeded>, before: Option<Converged>) -> Self {
        let on_the_way = match (cause.last_converged(), &cause) {
            (Some(last), SolveError::NoEquilibrium { load_factor, .. }) => {
                let Equilibrium { displacement, pressures, .. } = last.clone();
                Some(Converged { level: load_factor * level, displacement, pressures })
            }
            _ => None,
        };
        Self { level, cause, exceeded, last: on_the_way.or(before) }
    }

    /// As it is reported.
    pub fn diagnostic(self) -> Diagnostic {
        let Self { level, cause, exceeded, last } = self;
        let Some(limit) = exceeded else { return Diagnostic::from(cause).while_doing(format!("level {level}")) };
        let reached = last.map_or(0.0, |last| last.level);
        let act = "give a smaller load or a stiffer material, or raise the limit where the body snaps through";
        Diagnostic::new(format!("no equilibrium is found beyond level {reached:.6}"), limit.to_string(), act)
            .caused_by(limit)
            .while_doing(format!("level {level}"))
    }
}

impl Static {
    /// How each level is solved.
    pub fn settings(&self) -> StaticSettings {
        let settings =
            StaticSettings { load_steps: self.load_steps, tolerance: self.tolerance, ..StaticSettings::default() };
        self.budget().limiting(settings)
    }
}

/// Solves all levels.
///
/// # Errors
/// A [`Diagnostic`] that names the level; the levels before it, and the last converged state, are then written.
pub(super) fn solve_levels(set: &Static, mut simulation: Simulation) -> Result<Summary> {
    let Simulation { case, body, console, budget, ref watch, .. } = simulation;
    let watch = watch.clone();
    let mut solver = body.solver(case)?;
    let loads = body.loads(case);
    let mut levels = Levels::new(budget.limiting(set.settings()), watch);
    let frame_every = case.output.vtu_every.unwrap_or(1);
    let mut iterations = 0;
    for (number, &level) in set.levels.iter().enumerate() {
        solver.set_forces(&loads.forces_at_level(level))?;
        loads.move_clamps(&mut solver, level)?;
        let pressures = loads.pressures_at_level(level);
        let equilibrium = levels.solve(&mut solver, level, &pressures);
        let equilibrium = equilibrium.map_err(|lost| simulation.keep_last(&solver, *lost))?;
        iterations += equilibrium.iterations;
        let solved =
            Solved { at: level, displacement: &equilibrium.displacement, pressures: &pressures, stability: None };
        simulation.written.table.write_row(body, &solver, &solved)?;
        if frame_every > 0 && (number + 1) % frame_every == 0 {
            let name = simulation.written.frames.next_name();
            simulation.written.frames.write_frame(
                &name,
                level,
                body,
                &level_frame(&equilibrium.displacement, &solver),
            )?;
        }
        console.print_line(&level_line(level, &equilibrium));
    }
    Ok(Summary { dofs: 0, solved: set.levels.len(), iterations: Some(iterations), folder: Default::default() })
}

fn level_frame<'a>(displacement: &'a [f64], solver: &'a Solver) -> Frame<'a> {
    Frame { displacement, velocity: None, mode: None, properties: solver.properties() }
}

fn level_line(level: f64, equilibrium: &Equilibrium) -> String {
    let largest_displacement =
        equilibrium.displacement.chunks_exact(3).map(|u| u[0].hypot(u[1]).hypot(u[2])).fold(0.0, f64::max);
    let Equilibrium { iterations, residual, .. } = equilibrium;
    // An iterate without stability is none of the body's equilibria: whether those lost theirs only a path along them can say.
    let unstable = match equilibrium.snap_through.last() {
        Some(part) => {
            let reached = 100.0 * part;
            format!(
                "; the search met unstable shapes at {reached:.1} % of this level, [static] arc_length says whether equilibria are"
            )
        }
        None => String::new(),
    };
    format!(
        "level {level}: moved {:.4} mm at most, {iterations} iterations, residual {residual:.1e}{unstable}",
        1e3 * largest_displacement
    )
}

impl Simulation<'_> {
    /// Writes the last converged state, of this level or the one before, and says where it lies.
    fn keep_last(&mut self, solver: &Solver, lost: LostLevel) -> Diagnostic {
        let last = lost.last.clone();
        let diagnostic = lost.diagnostic();
        let Some(Converged { level: at, displacement, .. }) = last else { return diagnostic };
        match self.written.frames.write_frame("last_converged.vtu", at, self.body, &level_frame(&displacement, solver))
        {
            Ok(path) => diagnostic.noting(format!("last converged state: {}, at level {at:.6}", path.display())),
            Err(unwritten) => diagnostic.noting(format!("its last converged state cannot be kept: {}", unwritten.what)),
        }
    }
}
