//! Equilibria of successive levels, each started from the one before.

use fem::{Equilibrium, SolveError, Solver, StaticSettings};

use crate::case::Static;
use crate::frames::Frame;
use crate::probes::Solved;
use crate::{Simulation, Summary};
use diagnostics::{Diagnostic, Result};

/// Solves all levels.
///
/// # Errors
/// A [`Diagnostic`] that names the level; the levels before it, and the last converged state, are then written.
pub(super) fn solve(set: &Static, mut simulation: Simulation) -> Result<Summary> {
    let Simulation { case, body, console, .. } = simulation;
    let mut solver = body.solver(case)?;
    let settings = StaticSettings { load_steps: set.load_steps, tolerance: set.tolerance, ..StaticSettings::default() };
    let frame_every = case.output.vtu_every.unwrap_or(1);
    let mut start: Option<Converged> = None;
    let mut iterations = 0;
    for (number, &level) in set.levels.iter().enumerate() {
        let forces: Vec<f64> = body.forces.iter().map(|force| level * force).collect();
        solver.set_forces(&forces)?;
        let pressures = body.pressures(case, |chamber| chamber.pressure.at_level(level));
        let near = start.as_ref().map(|before| before.displacement.as_slice());
        let found = solver.equilibrium(&pressures, near, &settings);
        let found = found.map_err(|lost| simulation.keep_last(&solver, lost, level, start.take()))?;
        iterations += found.iterations;
        let solved = Solved { at: level, displacement: &found.displacement, pressures: &pressures, stability: None };
        simulation.written.table.row(body, &solver, &solved)?;
        if frame_every > 0 && (number + 1) % frame_every == 0 {
            let name = simulation.written.frames.next_name();
            simulation.written.frames.write(&name, level, body, &frame(&found.displacement, &solver))?;
        }
        console.line(&said(level, &found));
        start = Some(Converged { level, displacement: found.displacement });
    }
    Ok(Summary { dofs: 0, solved: set.levels.len(), iterations: Some(iterations), folder: Default::default() })
}

/// A converged state.
struct Converged {
    level: f64,
    /// 3 a node, m.
    displacement: Vec<f64>,
}

fn frame<'a>(displacement: &'a [f64], solver: &'a Solver) -> Frame<'a> {
    Frame { displacement, velocity: None, mode: None, properties: solver.properties() }
}

fn said(level: f64, found: &Equilibrium) -> String {
    let moved = found.displacement.chunks_exact(3).map(|u| u[0].hypot(u[1]).hypot(u[2])).fold(0.0, f64::max);
    let Equilibrium { iterations, residual, .. } = found;
    let snapped = match found.snap_through.last() {
        Some(part) => format!("; it snapped at {:.1} % of this level", 100.0 * part),
        None => String::new(),
    };
    format!(
        "level {level}: moved {:.4} mm at most, {iterations} iterations, residual {residual:.1e}{snapped}",
        1e3 * moved
    )
}

impl Simulation<'_> {
    /// Writes the last converged state, of this level or the one `before`, and says where it lies.
    fn keep_last(&mut self, solver: &Solver, lost: SolveError, level: f64, before: Option<Converged>) -> Diagnostic {
        let on_the_way = match (lost.last_converged(), &lost) {
            (Some(last), SolveError::NoEquilibrium { load_factor, .. }) => {
                Some(Converged { level: load_factor * level, displacement: last.displacement.clone() })
            }
            _ => None,
        };
        let diagnostic = Diagnostic::from(lost).while_doing(format!("level {level}"));
        let Some(Converged { level: at, displacement }) = on_the_way.or(before) else { return diagnostic };
        match self.written.frames.write("last_converged.vtu", at, self.body, &frame(&displacement, solver)) {
            Ok(path) => diagnostic.noting(format!("last converged state: {}, at level {at:.6}", path.display())),
            Err(unwritten) => diagnostic.noting(format!("its last converged state cannot be kept: {}", unwritten.what)),
        }
    }
}
