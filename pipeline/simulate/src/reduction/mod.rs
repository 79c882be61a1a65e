//! Reduction of a case: a reduced model of its body over ranges of constants and pressures, checked against the whole body.

mod file;
mod ranges;
mod training;

use std::path::PathBuf;

use fem::StaticSettings;

use crate::body::Body;
use crate::case::{Case, Clamp, Static, read};
use crate::{load, stem_of};
use diagnostics::{Diagnostic, Result, output};
use file::TrainingNote;
pub use ranges::NamedRange;
pub use training::{Trained, TrainingBox, train_reduced};

/// What is reduced, and how well.
#[derive(Debug, Clone)]
pub struct ReduceOptions {
    /// The case.
    pub case: PathBuf,
    /// Ranges of constants, `E.body` (Pa) or `nu.body`.
    pub over: Vec<NamedRange>,
    /// Ranges of the chambers' pressures, Pa.
    pub pressures: Vec<NamedRange>,
    /// Largest difference of a node from the whole body, over the largest displacement in the ranges.
    pub tolerance: f64,
    /// Equilibria of the whole body that may teach it, at most.
    pub equilibria: usize,
    /// The file that is written.
    pub out: PathBuf,
    /// Whether the last line alone is printed.
    pub quiet: bool,
}

/// Trains a reduced model and writes it; returns what it is in a line.
///
/// # Errors
/// A [`Diagnostic`] when the case is wrong, something but pressures acts on its body, a range is of nothing in it, the body has no equilibrium in
/// the ranges, or the model does not serve within the tolerance. Nothing is then written.
pub fn reduce(options: &ReduceOptions) -> Result<String> {
    let path = &options.case;
    let named = |e: Diagnostic| e.in_file_unless_named(path);
    let case = read(path)?;
    check_reducible(&case).map_err(named)?;
    let loaded = load(&case, path.parent().unwrap_or(path)).map_err(named)?;
    let body = Body::new(&case, &loaded).map_err(named)?;
    let constants = options.over.iter().map(|range| Ok((range.as_parameter(&body)?, range.clone())));
    let space = TrainingBox {
        constants: constants.collect::<Result<_>>()?,
        pressures: ranges::by_chamber(&options.pressures, &case, &body)?,
        tolerance: options.tolerance,
        most: options.equilibria,
    };
    let stem = stem_of(path);
    let progress = |text: &str| {
        if !options.quiet {
            output::note(format_args!("{stem:<10} {text}"));
        }
    };
    let tolerance = case.statics.as_ref().map_or(StaticSettings::default().tolerance, |set: &Static| set.tolerance);
    let settings = StaticSettings { tolerance, ..StaticSettings::default() };
    let Trained { model, taught, checked } = train_reduced(&body.system, &space, settings, &progress)?;
    let note = TrainingNote {
        constants: options.over.clone(),
        pressures: space.pressures,
        equilibria: taught,
        checked: checked.0,
        largest_difference: checked.1,
    };
    file::write_model(&options.out, &model.data(), &note)?;
    Ok(format!(
        "{} coordinates, {} quadrature points from {taught} equilibria; {} others differ by at most {:.3} % of the largest displacement → {}",
        model.coordinates(),
        model.points().iter().sum::<usize>(),
        checked.0,
        100.0 * checked.1,
        options.out.display()
    ))
}

/// # Errors
/// A [`Diagnostic`] when something acts that a reduced model leaves out.
fn check_reducible(case: &Case) -> Result<()> {
    let acting = [
        (case.gravity != [0.0; 3], "gravity"),
        (!case.load.is_empty(), "a load"),
        (case.contact.is_some(), "contact"),
        (case.clamp.iter().any(Clamp::is_displaced), "a displaced clamp"),
        (case.chamber.iter().any(|chamber| chamber.sealed_in.is_some()), "a sealed chamber"),
    ];
    if let Some((_, cause)) = acting.iter().find(|(acts, _)| *acts) {
        let reason = "a reduced model is moved by the pressures of its chambers alone";
        return Err(Diagnostic::new(
            format!("the case has {cause}"),
            reason,
            "leave it out of a case of its own for the reduction",
        ));
    }
    Ok(())
}
