//! The path of equilibria from rest to the last level, by the arc-length method of `continuation`.
//!
//! A row of the table for each point, and `<case>_critical.json` with the critical points; both are on the disk as soon
//! as they are found.

use std::path::PathBuf;
use std::sync::Arc;

use continuation::{
    BodyLoad, BodyProblem, CriticalKind, CriticalPoint, DofMap, Path, PathEnd, PathEvent, PathPoint, PathSettings,
    Problem, follow,
};
use fem::{Interrupt, Solver, StaticSettings, System};
use serde::Serialize;
use si::vec3::{norm, scale};
use si::{Metre, Pascal, Point3};

use crate::budget::Watch;
use crate::case::{ArcLength, Static};
use crate::frames::Frame;
use crate::loads::Loads;
use crate::probes::Solved;
use crate::{Simulation, Summary, cannot_write};
use diagnostics::{Diagnostic, Result};

/// Follows the path.
///
/// # Errors
/// A [`Diagnostic`] when the path cannot be begun, or does not reach the last level; the points up to there are then
/// written.
pub(super) fn solve_path(set: &Static, simulation: Simulation) -> Result<Summary> {
    let Simulation { case, body, .. } = simulation;
    let (loads, watch) = (body.loads(case), simulation.watch.clone());
    let mut report = PathReport {
        solver: body.solver(case)?,
        pressures: loads.pressures_at_level(1.0),
        critical: Vec::new(),
        points: 0,
        iterations: 0,
        failed: None,
        simulation,
    };
    report.write_critical()?;
    let path = FollowedPath { statics: set, loads: &loads, heavy: case.gravity != [0.0; 3], watch };
    let followed =
        path.follow(&body.system, &|| body.solver(case), &mut |event, dofs| report.observe_event(event, dofs));
    report.finish_path(followed)
}

/// A path of equilibria, followed by the command line and by the Python package.
pub struct FollowedPath<'a> {
    /// Levels, steps and branches; `arc_length` has its defaults where it is not set.
    pub statics: &'a Static,
    /// What grows with the level.
    pub loads: &'a Loads,
    /// Whether gravity acts: the path then begins in the equilibrium under it.
    pub heavy: bool,
    /// Its budget, of which the iterations are those of one point.
    pub watch: Arc<Watch>,
}

impl FollowedPath<'_> {
    /// Follows it on the body of `system`, of which `solver` makes solvers with all that does not grow.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the path cannot be begun, or does not reach the last level.
    pub fn follow(
        &self,
        system: &System,
        solver: &dyn Fn() -> Result<Solver>,
        observe: &mut dyn FnMut(PathEvent, &DofMap),
    ) -> Result<()> {
        let load = BodyLoad { pressures: self.loads.pressures_at_level(1.0), forces: self.loads.forces.clone() };
        let mut problem = BodyProblem::new(system, solver()?, load)?;
        if self.heavy {
            problem = problem.starting_at(&under_gravity(system, solver()?)?);
        }
        let dofs = problem.dof_map().clone();
        let mut ending = EndingProblem { problem, interrupt: self.watch.interrupt() };
        let settings = self.statics.path_settings(self.statics.arc_length.unwrap_or_default());
        let followed = follow(&mut ending, &settings, &mut |event| {
            self.watch.restart();
            observe(event, &dofs);
        });
        match self.watch.exceeded() {
            None => self.statics.check_end(&followed?),
            Some(limit) => Err(Diagnostic::new(
                "the path does not reach its last level",
                limit.to_string(),
                "raise the limit, or end the path at a lower level",
            )
            .caused_by(limit)),
        }
    }
}

/// The equilibrium under gravity alone, 3 a node, m.
fn under_gravity(system: &System, mut solver: Solver) -> Result<Vec<f64>> {
    solver.set_forces(&[])?;
    let without = vec![0.0; system.mesh().chambers.len()];
    Ok(solver.equilibrium(&without, None, &StaticSettings::default())?.displacement)
}

/// A problem whose tangents are refused once it shall end, so that the path ends there.
struct EndingProblem {
    problem: BodyProblem,
    interrupt: Interrupt,
}

impl Problem for EndingProblem {
    fn dofs(&self) -> usize {
        self.problem.dofs()
    }

    fn size(&self) -> Metre {
        self.problem.size()
    }

    fn start(&self) -> Vec<f64> {
        self.problem.start()
    }

    fn residual(&mut self, u: &[f64], load_factor: f64) -> Option<Vec<f64>> {
        self.problem.residual(u, load_factor)
    }

    fn load(&mut self, u: &[f64], load_factor: f64) -> Vec<f64> {
        self.problem.load(u, load_factor)
    }

    fn factorise(&mut self, u: &[f64], load_factor: f64, previous: Option<&[f64]>) -> Option<usize> {
        if (self.interrupt)() { None } else { self.problem.factorise(u, load_factor, previous) }
    }

    fn solve(&mut self, x: &mut [f64]) {
        self.problem.solve(x);
    }
}

impl Static {
    /// How its path is followed.
    fn path_settings(&self, arc_length: ArcLength) -> PathSettings {
        let last = self.levels[self.levels.len() - 1];
        PathSettings {
            load_factors: [0.0, last],
            levels: self.levels.clone(),
            first_step: 1.0 / self.load_steps as f64,
            max_step: arc_length.max_step,
            max_steps: arc_length.max_steps,
            tolerance: self.tolerance,
            branch: arc_length.branch.into(),
            ..PathSettings::default()
        }
    }

    /// Holds that a path reached the last level.
    ///
    /// # Errors
    /// A [`Diagnostic`] where it took its last step before.
    fn check_end(&self, path: &Path) -> Result<()> {
        if path.end != PathEnd::StepLimit {
            return Ok(());
        }
        let last = self.levels[self.levels.len() - 1];
        Err(Diagnostic::new(
            format!("the path does not reach level {last}"),
            format!("it took {} steps; the limit is [static] arc_length.max_steps", path.steps),
            "raise max_steps or max_step; a branch that falls back to a lower level may never reach it",
        ))
    }
}

/// A critical point as it is written.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Critical {
    kind: &'static str,
    level: f64,
    /// By chamber of the case, Pa above ambient.
    pressures_pa: Vec<Pascal>,
    /// The node that moves most in the mode, at rest.
    place_m: Point3,
    /// Its displacement at the critical point.
    displacement_m: Point3,
    /// Its direction in the mode, of length 1.
    direction: Point3,
    multiplicity: usize,
    load_along_mode: f64,
    negative_eigenvalues: [usize; 2],
    frame: String,
}

/// The path's output.
struct PathReport<'a> {
    simulation: Simulation<'a>,
    /// For volumes and properties.
    solver: Solver,
    /// At level 1, Pa.
    pressures: Vec<Pascal>,
    critical: Vec<Critical>,
    points: usize,
    iterations: usize,
    /// The first failure to write.
    failed: Option<Diagnostic>,
}

impl PathReport<'_> {
    fn observe_event(&mut self, event: PathEvent, dofs: &DofMap) {
        if self.failed.is_none() {
            self.failed = match event {
                PathEvent::Point(point) => self.write_point(point, dofs).err(),
                PathEvent::Critical(point) => self.write_critical_point(point, dofs).err(),
            };
        }
    }

    fn write_point(&mut self, point: &PathPoint, dofs: &DofMap) -> Result<()> {
        let displacement = dofs.full(&point.displacement);
        let pressures = self.pressures_at(point.load_factor);
        let stability = Some((point.negative_eigenvalues, point.eigenvalue));
        let solved = Solved { at: point.load_factor, displacement: &displacement, pressures: &pressures, stability };
        let Simulation { case, body, written, console, .. } = &mut self.simulation;
        written.table.write_row(body, &self.solver, &solved)?;
        let every = case.output.vtu_every.unwrap_or(1);
        self.points += 1;
        self.iterations += point.iterations;
        if every > 0 && self.points.is_multiple_of(every) {
            let frame =
                Frame { displacement: &displacement, velocity: None, mode: None, properties: self.solver.properties() };
            written.frames.write_frame(&written.frames.next_name(), point.load_factor, body, &frame)?;
        }
        console.print_line(&point_line(point));
        Ok(())
    }

    fn write_critical_point(&mut self, point: &CriticalPoint, dofs: &DofMap) -> Result<()> {
        let (displacement, mode) = (dofs.full(&point.displacement), dofs.full(&point.mode));
        let name = format!("critical_{:04}.vtu", self.critical.len());
        let properties = self.solver.properties();
        let frame = Frame { displacement: &displacement, velocity: None, mode: Some(&mode), properties };
        let Simulation { body, written, .. } = &mut self.simulation;
        written.frames.write_frame(&name, point.load_factor, body, &frame)?;
        let node = dofs.largest_node(&point.mode);
        let vector_at_node = |list: &[f64]| [0, 1, 2].map(|axis| list[3 * node + axis]);
        let pressures = self.pressures_at(point.load_factor);
        let body = self.simulation.body;
        let critical_point = Critical {
            kind: if point.kind == CriticalKind::LimitPoint { "limit_point" } else { "bifurcation" },
            level: point.load_factor,
            pressures_pa: body.numbers.iter().map(|&number| pressures[number]).collect(),
            place_m: body.solid.nodes()[node],
            displacement_m: vector_at_node(&displacement),
            direction: scale(vector_at_node(&mode), 1.0 / norm(vector_at_node(&mode))),
            multiplicity: point.multiplicity,
            load_along_mode: point.load_along_mode,
            negative_eigenvalues: point.negative_eigenvalues,
            frame: name,
        };
        self.simulation.console.print_line(&critical_point.to_string());
        self.critical.push(critical_point);
        self.write_critical()
    }

    fn pressures_at(&self, level: f64) -> Vec<Pascal> {
        self.pressures.iter().map(|pressure| level * pressure).collect()
    }

    fn critical_file(&self) -> PathBuf {
        self.simulation.written.frames.beside(&format!("{}_critical.json", self.simulation.console.stem()))
    }

    fn write_critical(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.critical)? + "\n";
        std::fs::write(self.critical_file(), text).map_err(|e| cannot_write(&self.critical_file(), &e))
    }

    fn finish_path(self, followed: Result<()>) -> Result<Summary> {
        if let Some(failed) = self.failed {
            return Err(failed);
        }
        followed?;
        let (solved, iterations) = (self.points, Some(self.iterations));
        Ok(Summary { dofs: 0, solved, iterations, folder: Default::default() })
    }
}

fn point_line(point: &PathPoint) -> String {
    let PathPoint { load_factor, negative_eigenvalues, eigenvalue, iterations, .. } = point;
    let stability = match negative_eigenvalues {
        0 => "stable".to_owned(),
        count => format!("unstable ({count} negative eigenvalues)"),
    };
    format!(
        "level {load_factor:.6}: {stability}, eigenvalue nearest to zero {eigenvalue:.3e} N/m, {iterations} iterations"
    )
}

impl std::fmt::Display for Critical {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.place_m.map(|at| 1e3 * at);
        let kind = self.kind.replace('_', " ");
        write!(out, "level {:.6}: {kind}; the mode is largest at ({x:.3}, {y:.3}, {z:.3}) mm", self.level)
    }
}
