//! Conjugate gradients, preconditioned by a factor of a matrix nearby.
//!
//! Stands on: `sparse`, `factor`. Never knows: what is solved for.

use crate::factor::{Factor, Symbolic};
use crate::potential::dot;
use crate::sparse::Pattern;

/// Solves K x = b for the lower triangle `values`; `x` begins as the factor's own answer.
///
/// Returns x and the iterations, or nothing when ‖Kx − b‖ stays above `tolerance` ‖b‖ for `limit` of them, or when a
/// direction shows that K is not positive definite.
pub(crate) fn conjugate_gradients(
    (pattern, symbolic, values): (&Pattern, &Symbolic, &[f64]),
    factor: &mut Factor,
    b: &[f64],
    tolerance: f64,
    limit: usize,
) -> Option<(Vec<f64>, usize)> {
    let goal = tolerance * dot(b, b).sqrt();
    let mut x = vec![0.0; b.len()];
    let mut left = b.to_vec();
    let mut along = Vec::new();
    let mut image = vec![0.0; b.len()];
    let mut before = 1.0;
    for iteration in 0..=limit {
        if dot(&left, &left).sqrt() <= goal {
            return Some((x, iteration));
        }
        let mut better = left.clone();
        factor.solve(symbolic, &mut better);
        let now = dot(&left, &better);
        if along.is_empty() {
            along = better;
        } else {
            along.iter_mut().zip(&better).for_each(|(d, z)| *d = z + now / before * *d);
        }
        pattern.multiply(values, &along, &mut image);
        let curvature = dot(&along, &image);
        if !(curvature > 0.0) {
            return None;
        }
        let step = now / curvature;
        x.iter_mut().zip(&along).for_each(|(x, d)| *x += step * d);
        left.iter_mut().zip(&image).for_each(|(r, q)| *r -= step * q);
        before = now;
    }
    None
}
