//! One body under loads, from a case file to tables and frames, and the check of its gradients.
//!
//! A case ([`case`]) names a mesh, materials, clamps, chambers and loads. [`run`] solves it and writes `<case>.out/` with `<case>.csv`,
//! `frame_0000.vtu`, … and `<case>.pvd`, which ParaView opens; a path (`[static] arc_length`) has its critical points in
//! `<case>_critical.json`. [`gradient_check`] compares every gradient of a case with differences.
//! No project is needed.
//!
//! ```
//! # fn main() -> Result<(), diagnostics::Diagnostic> {
//! let case = simulate::case::read(std::path::Path::new("examples/cantilever.toml"))?;
//! assert!(case.statics.is_some() && case.dynamic.is_none());
//! # Ok(())
//! # }
//! ```
//!
//! Depends on `diagnostics`, `fem`, `continuation` (paths), `lab` (tables and ranges), `mesh`, `si`.

mod body;
mod budget;
pub mod case;
mod certificate;
mod clamps;
mod console;
mod dynamics;
mod force_table;
mod forces;
mod frames;
pub mod gradient_check;
mod loads;
mod materials;
mod path;
mod probes;
mod reach;
mod reduction;
mod solid;
mod statics;
mod stress;
mod surfaces;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::case::{Case, read};
pub use body::{Body, fem_mesh};
pub use budget::{Budget, Exceeded, MAX_ITERATIONS, Watch};
pub use certificate::{Difference, certify, run_with_estimate};
pub use clamps::HeldNodes;
use console::Console;
pub use continuation::{CriticalKind, DofMap, PathEvent};
use diagnostics::{Diagnostic, Result};
pub use dynamics::{lost_step, start_equilibrium};
use fem::Interrupt;
use frames::Frames;
pub use loads::Loads;
pub use path::FollowedPath;
use probes::Table;
pub use probes::{Probe, probes};
pub use reduction::{NamedRange, ReduceOptions, Trained, TrainingBox, reduce, train_reduced};
pub use solid::{Loaded, load, raw_mesh, read_surface, tables};
pub use statics::{Converged, Levels, LostLevel};

/// The summary of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Degrees of freedom.
    pub dofs: usize,
    /// Levels or steps.
    pub solved: usize,
    /// Newton iterations over all levels; none for motions, which do not count them.
    pub iterations: Option<usize>,
    /// Where the results lie.
    pub folder: PathBuf,
}

/// How a case is run, beside what it says.
#[derive(Clone, Default)]
pub struct RunOptions {
    /// The folder of its results; beside the case where none is given.
    pub out: Option<PathBuf>,
    /// Whether the last line alone is printed.
    pub quiet: bool,
    /// Ends it as in [`fem::Solver::set_interrupt`].
    pub interrupt: Option<Interrupt>,
    /// Limits that take the place of those of the case.
    pub budget: Budget,
}

/// Simulates the case in the file `path` and writes into `out`, or beside the case. `interrupt` ends it as in [`fem::Solver::set_interrupt`].
///
/// # Errors
/// A [`Diagnostic`]: the case or its mesh is refused, or a level or step cannot be found; results up to then are written.
pub fn run(path: &Path, out: Option<&Path>, quiet: bool, interrupt: Option<Interrupt>) -> Result<Summary> {
    run_with(path, RunOptions { out: out.map(Path::to_owned), quiet, interrupt, ..RunOptions::default() })
}

/// As [`run`], with more options.
///
/// # Errors
/// As [`run`].
pub fn run_with(path: &Path, options: RunOptions) -> Result<Summary> {
    // What does not concern one file alone is a matter of the case.
    read(path).and_then(|case| simulate_case(&case, path, options)).map_err(|e| e.in_file_unless_named(path))
}

/// The name of a case, from its file.
fn stem_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Where the results of a case go.
fn results_folder(path: &Path, out: Option<&Path>) -> PathBuf {
    let folder_of_case = || path.parent().unwrap_or(Path::new(".")).join(format!("{}.out", stem_of(path)));
    out.map_or_else(folder_of_case, Path::to_owned)
}

/// Simulates a case whose files lie beside `path`.
fn simulate_case(case: &Case, path: &Path, options: RunOptions) -> Result<Summary> {
    simulate_loaded(case, &load_beside(case, path)?, path, options)
}

/// The mesh of a case whose files lie beside `path`.
fn load_beside(case: &Case, path: &Path) -> Result<Loaded> {
    solid::load(case, path.parent().unwrap_or(Path::new(".")))
}

fn simulate_loaded(case: &Case, loaded: &Loaded, path: &Path, options: RunOptions) -> Result<Summary> {
    let RunOptions { out, quiet, interrupt, budget } = options;
    let (stem, folder) = (stem_of(path), results_folder(path, out.as_deref()));
    let console = Arc::new(Console::new(&stem, quiet));
    loaded.notes.iter().for_each(|note| console.print_line(note));
    let budget = budget.or(case.budget());
    let watch = budget.watch(Some(console.reporting(interrupt)));
    // Where case and mesh do not match, either may be wrong.
    let body = Body::new(case, loaded).map_err(|e| e.noting(format_args!("mesh: {}", case.mesh.name())))?;
    let body = body.interruptible(Some(watch.interrupt()));
    body.notes.iter().for_each(|note| console.print_line(note));
    std::fs::create_dir_all(&folder).map_err(|e| cannot_write(&folder, &e))?;
    let written =
        Outputs { frames: Frames::begin_folder(&folder, &stem)?, table: Table::create(case, &body, &folder, &stem)? };
    let solved = solve_simulation(Simulation { case, body: &body, written, console: &console, budget, watch })?;
    let summary = Summary { dofs: body.system.dofs(), folder, ..solved };
    console.print_summary(&summary);
    Ok(summary)
}

fn solve_simulation(simulation: Simulation) -> Result<Summary> {
    match (&simulation.case.statics, &simulation.case.dynamic) {
        (Some(set), _) if set.arc_length.is_some() => path::solve_path(set, simulation),
        (Some(set), _) => statics::solve_levels(set, simulation),
        (None, Some(set)) => dynamics::solve_motion(set, simulation),
        (None, None) => {
            Err(Diagnostic::new("nothing is asked for", "a case has [static] or [dynamic]", "add one of them"))
        }
    }
}

/// A case with its body, and where its results go.
struct Simulation<'a> {
    case: &'a Case,
    body: &'a Body<'a>,
    written: Outputs,
    console: &'a Console,
    budget: Budget,
    watch: Arc<Watch>,
}

/// The output during a simulation.
struct Outputs {
    table: Table,
    frames: Frames,
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Diagnostic {
    let message = format!("{} cannot be written", path.display());
    Diagnostic::new(message, error.to_string().to_lowercase(), "name another folder with --out")
}
