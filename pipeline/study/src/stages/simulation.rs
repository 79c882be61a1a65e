//! What motions are simulated from: the identified constants, and the pressures that a film's log measured.

use signal::resample::Samples;

use crate::records::{Identified, Motion};
use diagnostics::{Diagnostic, Result};
use sysid::{Elastic, Model};

/// The identified constants of a model, at the time to which they belong.
pub(crate) fn identified(model: &Model, found: &Identified) -> Elastic {
    Elastic { youngs_moduli: found.best.clone(), ..model.nominal.clone() }
}

/// The measured pressures of a film.
///
/// # Errors
/// A [`Diagnostic`] when the log's times do not rise.
pub(crate) fn gauges(motion: &Motion) -> Result<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Diagnostic::from)
}
