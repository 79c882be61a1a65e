//! Preconditioned conjugate gradients (PCG).
//!
//! The preconditioner is the factor of a nearby tangent: a lagged factor, rotated with the body. After a small change
//! of the tangent it needs a few iterations, where a new factorisation costs as much as about twenty of them.

use crate::dot;

/// When conjugate gradients stop.
#[derive(Debug, Clone, Copy)]
pub struct PcgOptions {
    /// ‖Kx − b‖ / ‖b‖
    pub tolerance: f64,
    /// Iterations at most.
    pub max_iterations: usize,
}

/// Solves K x = b; `multiply` writes K x into its second argument, `precondition` applies the inverse of a nearby
/// matrix.
///
/// Returns x and the number of iterations, or nothing when the tolerance is not met within the limit, or when a
/// direction shows that K is not positive definite.
pub fn conjugate_gradients(
    multiply: impl Fn(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&mut [f64]),
    b: &[f64],
    options: PcgOptions,
) -> Option<(Vec<f64>, usize)> {
    let goal = options.tolerance * dot(b, b).sqrt();
    let mut x = vec![0.0; b.len()];
    let mut residual = b.to_vec();
    let mut direction: Vec<f64> = Vec::new();
    let mut image = vec![0.0; b.len()];
    let mut previous_product = 1.0;
    for iteration in 0..=options.max_iterations {
        if dot(&residual, &residual).sqrt() <= goal {
            return Some((x, iteration));
        }
        let mut preconditioned = residual.clone();
        precondition(&mut preconditioned);
        let product = dot(&residual, &preconditioned);
        if direction.is_empty() {
            direction = preconditioned;
        } else {
            direction.iter_mut().zip(&preconditioned).for_each(|(d, z)| *d = z + product / previous_product * *d);
        }
        multiply(&direction, &mut image);
        let curvature = dot(&direction, &image);
        // A direction of negative curvature: the caller factorises the tangent, which then fails or succeeds for
        // certain.
        if curvature.is_nan() || curvature <= 0.0 {
            return None;
        }
        let step = product / curvature;
        x.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
        residual.iter_mut().zip(&image).for_each(|(r, q)| *r -= step * q);
        previous_product = product;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparsity::Pattern;
    use crate::testing::Grid;

    #[test]
    fn a_rough_preconditioner_solves_a_definite_matrix_and_an_indefinite_one_is_rejected() {
        let grid = Grid::new([4, 1, 1]);
        let pattern = Pattern::new(&grid.nodes, &grid.graph(), &grid.first_layer_constrained());
        let n = pattern.dofs();
        let mut values = vec![-0.1; pattern.entries()];
        (0..n).for_each(|column| values[pattern.columns[column] as usize] = 9.0 + (column % 5) as f64);
        let exact: Vec<f64> = (0..n).map(|entry| (entry as f64).sin()).collect();
        let mut b = vec![0.0; n];
        pattern.multiply(&values, &exact, &mut b);
        let rough = |x: &mut [f64]| x.iter_mut().for_each(|x| *x /= 10.0);
        let options = PcgOptions { tolerance: 1e-12, max_iterations: 40 };
        let (x, iterations) = conjugate_gradients(|x, y| pattern.multiply(&values, x, y), rough, &b, options).unwrap();
        assert!(iterations > 2 && x.iter().zip(&exact).all(|(x, exact)| (x - exact).abs() < 1e-11));
        values[0] = -9.0;
        assert!(conjugate_gradients(|x, y| pattern.multiply(&values, x, y), rough, &b, options).is_none());
    }
}
