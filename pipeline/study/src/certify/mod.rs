//! Certify: every gradient of a case against differences, and the Taylor test along each parameter.
//!
//! A loss that no symmetry favours (`loss`) is taken of the case's last level, or of the first steps of its motion. Each
//! parameter that the case has (`knobs`) is turned a little both ways: the difference of losses must agree with the
//! gradient that one pass backwards gave, the forward sensitivity too, and what the gradient leaves of the change must
//! fall with the square of the turn.
//!
//! Stands on: `case`, `simulate` (its body), fem. Never knows: how a gradient is made.

mod knobs;
mod loss;
mod trial;
mod verdict;

use std::path::{Path, PathBuf};

use crate::case::read;
use crate::fault::{Fault, Outcome};
use crate::simulate::{Body, load};
use knobs::knobs;
use trial::Trial;
pub use verdict::{Certificate, Line};

/// Checks the gradients of the case in the file `path`; of a motion, over its first `steps` steps.
///
/// # Errors
/// A [`Fault`] when the case is refused or cannot be solved.
pub fn run(path: &Path, steps: usize) -> Outcome<Certificate> {
    let case = read(path).map_err(Fault::from_tool)?;
    let loaded = load(&case, path.parent().unwrap_or(Path::new(".")))?;
    let body = Body::new(&case, &loaded)?;
    let mut trial = Trial::new(&case, &body, steps)?;
    let knobs = knobs(&case, &body);
    let derivatives = trial.derivatives(&knobs)?;
    let mut lines = Vec::new();
    for (knob, (backward, forward)) in knobs.iter().zip(derivatives) {
        lines.push(verdict::line(knob, backward, forward, |part| trial.loss_at(knob, part))?);
    }
    Ok(Certificate { case: path.display().to_string(), freedoms: body.system.freedoms(), lines })
}

/// Where the cases lie that come with the project.
const EXAMPLES: &str = "pipeline/study/examples";

/// The cases that come with the project whose folder is `root`, by name.
///
/// # Errors
/// A [`Fault`] when the folder cannot be listed.
pub fn examples(root: &Path) -> Outcome<Vec<PathBuf>> {
    let folder = root.join(EXAMPLES);
    let listed = std::fs::read_dir(&folder).map_err(|error| {
        Fault::new(
            format!("{} cannot be listed", folder.display()),
            error.to_string().to_lowercase(),
            "name a case, or the project's folder with --root",
        )
    })?;
    let files = listed.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let mut cases: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|word| word == "toml")).collect();
    cases.sort();
    Ok(cases)
}
