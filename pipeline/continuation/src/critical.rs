//! Critical points: located where an eigenvalue of the tangent changes its sign, classified, and described.
//!
//! With K φ = 0 and the path's tangent K u̇ = q λ̇ follows φᵀq λ̇ = 0. At a limit point λ̇ = 0 and φᵀq ≠ 0; at a bifurcation
//! φᵀq = 0, and λ passes on. On a computed path λ turns between two points or it does not, which needs no threshold;
//! where several eigenvalues vanish within one step that turns, the mode with the largest φᵀq belongs to the limit point.

use crate::corrector::Corrector;
use crate::error::StepFailure;
use crate::point::{CriticalKind, CriticalPoint, Sample};
use crate::segment::Segment;

/// Critical points whose load factors differ by less than this fraction of the step's are one of higher multiplicity.
const SAME: f64 = 1e-4;

/// The critical points between the ends of `segment`, in the order of the path.
///
/// # Errors
/// [`StepFailure`]
pub(crate) fn locate_critical_points(
    corrector: &mut Corrector,
    segment: Segment,
) -> Result<Vec<CriticalPoint>, StepFailure> {
    let mut points: Vec<CriticalPoint> = Vec::new();
    for number in crossing_numbers(segment.from.negative, segment.to.negative) {
        let sample = segment.find_root(corrector, &|sample| signed_eigenvalue(sample, number))?;
        let mut point = describe_bifurcation(corrector, &sample);
        let rises = segment.to.negative > segment.from.negative;
        point.negative_eigenvalues = if rises { [number, number + 1] } else { [number + 1, number] };
        match points.last_mut().filter(|last| is_same(last, &point, segment)) {
            Some(last) => {
                last.multiplicity += 1;
                last.negative_eigenvalues[1] = point.negative_eigenvalues[1];
            }
            None => points.push(point),
        }
    }
    if segment.turns_round() {
        mark_limit_point(&mut points);
    }
    Ok(points)
}

/// Numbers of the eigenvalues, in ascending order, that change their sign, in the order in which they do.
fn crossing_numbers(before: usize, after: usize) -> Vec<usize> {
    if after > before { (before..after).collect() } else { (after..before).rev().collect() }
}

/// The eigenvalue of that number; where it is not known, its sign, so that the bracket is halved.
fn signed_eigenvalue(sample: &Sample, number: usize) -> f64 {
    let sign = if number < sample.negative { f64::NEG_INFINITY } else { f64::INFINITY };
    sample.eigenvalue(number).unwrap_or(sign)
}

fn is_same(first: &CriticalPoint, second: &CriticalPoint, segment: Segment) -> bool {
    let span = (segment.to.load_factor - segment.from.load_factor).abs();
    let squared_distance: f64 = first.displacement.iter().zip(&second.displacement).map(|(a, b)| (a - b).powi(2)).sum();
    (first.load_factor - second.load_factor).abs() <= SAME * span && squared_distance.sqrt() <= SAME * segment.length()
}

/// The critical point at `sample`, as a bifurcation.
fn describe_bifurcation(corrector: &mut Corrector, sample: &Sample) -> CriticalPoint {
    let mode = orient_mode(&sample.pairs[0].mode);
    let load = corrector.problem.load(&sample.u, sample.load_factor);
    let load_along_mode = (sparse::dot(&mode, &load) / sparse::dot(&load, &load).sqrt()).abs();
    CriticalPoint {
        kind: CriticalKind::Bifurcation,
        load_factor: sample.load_factor,
        displacement: sample.u.clone(),
        mode,
        multiplicity: 1,
        load_along_mode,
        negative_eigenvalues: [0; 2],
    }
}

/// The same mode with its entry of largest amplitude positive, the first one of those that are as large.
fn orient_mode(mode: &[f64]) -> Vec<f64> {
    let largest = sparse::max_abs(mode);
    // Entries that symmetry makes equal differ by rounding.
    let first = mode.iter().find(|entry| entry.abs() >= (1.0 - 1e-3) * largest);
    let sign = first.map_or(1.0, |entry| entry.signum());
    mode.iter().map(|entry| sign * entry).collect()
}

fn mark_limit_point(found: &mut [CriticalPoint]) {
    if let Some(limit) = found.iter_mut().max_by(|a, b| a.load_along_mode.total_cmp(&b.load_along_mode)) {
        limit.kind = CriticalKind::LimitPoint;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_cross_in_the_order_of_the_path() {
        assert_eq!(crossing_numbers(0, 2), [0, 1]);
        assert_eq!(crossing_numbers(3, 1), [2, 1]);
        assert!(crossing_numbers(2, 2).is_empty());
    }

    #[test]
    fn a_mode_is_oriented_by_its_first_largest_entry() {
        assert_eq!(orient_mode(&[0.1, -0.7, 0.7000001]), [-0.1, 0.7, -0.7000001]);
        assert_eq!(orient_mode(&[0.5, -0.4]), [0.5, -0.4]);
    }
}
