//! What motions are simulated from: the pressures that a film's log measured.

use signal::resample::Samples;

use diagnostics::{Diagnostic, Result};
use records::Motion;

/// The measured pressures of a film.
///
/// # Errors
/// A [`Diagnostic`] when the log's times do not rise.
pub(crate) fn gauge_samples(motion: &Motion) -> Result<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Diagnostic::from)
}
