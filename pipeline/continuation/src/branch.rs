//! Branch switching: the first point of a secondary path, at a given distance along the mode from a bifurcation.
//!
//! The plane normal to the mode at that distance cuts the secondary path and not the primary one, and the bordered
//! tangent is regular there although K is nearly singular [wagner1988].

use crate::constraint::Constraint;
use crate::corrector::{Corrector, Guess};
use crate::error::StepFailure;
use crate::point::{CriticalPoint, Sample};
use crate::settings::Branch;
use crate::subspace::Accuracy;

/// Attempts, each at twice the distance of the one before: close to the bifurcation rounding hides the branch.
const ATTEMPTS: usize = 4;

/// The first point of the secondary path on the side that `branch` says, `amplitude` (m) of the mode's largest entry
/// away from `bifurcation`.
///
/// # Errors
/// [`StepFailure`] of the last attempt.
pub(crate) fn secondary_branch(
    corrector: &mut Corrector,
    bifurcation: &CriticalPoint,
    branch: Branch,
    amplitude: f64,
) -> Result<Sample, StepFailure> {
    let sign = if branch == Branch::AgainstMode { -1.0 } else { 1.0 };
    let normal: Vec<f64> = bifurcation.mode.iter().map(|entry| sign * entry).collect();
    let mut distance = amplitude / sparse::max_abs(&normal);
    let mut sample = Err(StepFailure::Singular);
    for _ in 0..ATTEMPTS {
        let mut u = bifurcation.displacement.clone();
        sparse::add(&mut u, distance, &normal);
        let previous = Some(bifurcation.displacement.as_slice());
        let guess = Guess { u, load_factor: bifurcation.load_factor, previous };
        let plane = Constraint::Plane { centre: &bifurcation.displacement, normal: &normal, distance };
        sample = corrector.solve(guess, plane, Accuracy::Watch);
        if sample.is_ok() {
            break;
        }
        distance *= 2.0;
    }
    sample
}
