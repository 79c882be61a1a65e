//! Gradient check: every gradient of a case against differences, and the Taylor test along each parameter.
//!
//! A loss without symmetry (`loss`) is evaluated at the case's last level, or over the first steps of its motion. Each parameter of
//! the case (`parameters`) is perturbed to both sides: the difference of losses must agree with the adjoint gradient and with the
//! forward sensitivity, and the first-order remainder must decrease with the square of the perturbation (Taylor test).

mod evaluation;
mod loss;
mod parameters;
mod report;

use std::path::{Path, PathBuf};

use crate::case::read;
use crate::{Body, load};
use diagnostics::{Diagnostic, Result};
use evaluation::Evaluation;
use parameters::case_parameters;
pub use report::{GradientReport, Line};

/// Checks the gradients of the case in the file `path`; of a motion, over its first `steps` steps.
///
/// # Errors
/// A [`Diagnostic`] when the case is refused or cannot be solved.
pub fn run(path: &Path, steps: usize) -> Result<GradientReport> {
    let case = read(path)?;
    let loaded = load(&case, path.parent().unwrap_or(Path::new(".")))?;
    let body = Body::new(&case, &loaded)?;
    let mut evaluation = Evaluation::new(&case, &body, steps)?;
    let parameters = case_parameters(&case, &body);
    let derivatives = evaluation.derivatives(&parameters)?;
    let mut lines = Vec::new();
    for (parameter, (backward, forward)) in parameters.iter().zip(derivatives) {
        lines.push(report::evaluate_line(parameter, backward, forward, |part| evaluation.loss_at(parameter, part))?);
    }
    Ok(GradientReport { case: path.display().to_string(), dofs: body.system.dofs(), lines })
}

/// A path through a critical point, at which no gradient exists.
const PATH_EXAMPLE: &str = "column.toml";

/// Folder of the cases that come with the project.
const EXAMPLES: &str = "pipeline/simulate/examples";

/// The cases that come with the project whose folder is `root`, by name; without the one that passes a critical point.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be listed.
pub fn examples(root: &Path) -> Result<Vec<PathBuf>> {
    let folder = root.join(EXAMPLES);
    let listed = std::fs::read_dir(&folder).map_err(|error| {
        Diagnostic::new(
            format!("{} cannot be listed", folder.display()),
            error.to_string().to_lowercase(),
            "name a case, or the project's folder with --root",
        )
    })?;
    let files = listed.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let is_case = |path: &PathBuf| path.extension().is_some_and(|word| word == "toml") && !path.ends_with(PATH_EXAMPLE);
    let mut cases: Vec<PathBuf> = files.filter(is_case).collect();
    cases.sort();
    Ok(cases)
}
