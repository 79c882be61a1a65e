//! Conjugate gradients, with the inverse of a matrix nearby to speed them up.
//!
//! Stands on: `potential` (dot). Never knows: what is solved for, where the inverse comes from.

use crate::algebra::vectors::dot;

/// Solves K x = b; `image_of` writes K x into its second argument, `improve` replaces a vector by what the inverse nearby
/// makes of it.
///
/// Returns x and the iterations, or nothing when ‖Kx − b‖ stays above `goal` for `limit` of them, or when a direction
/// shows that K is not positive definite.
pub(crate) fn conjugate_gradients(
    image_of: impl Fn(&[f64], &mut [f64]),
    mut improve: impl FnMut(&mut [f64]),
    b: &[f64],
    goal: f64,
    limit: usize,
) -> Option<(Vec<f64>, usize)> {
    let mut x = vec![0.0; b.len()];
    let mut left = b.to_vec();
    let mut along: Vec<f64> = Vec::new();
    let mut image = vec![0.0; b.len()];
    let mut before = 1.0;
    for iteration in 0..=limit {
        if dot(&left, &left).sqrt() <= goal {
            return Some((x, iteration));
        }
        let mut better = left.clone();
        improve(&mut better);
        let now = dot(&left, &better);
        if along.is_empty() {
            along = better;
        } else {
            along.iter_mut().zip(&better).for_each(|(d, z)| *d = z + now / before * *d);
        }
        image_of(&along, &mut image);
        let curvature = dot(&along, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            return None;
        }
        let step = now / curvature;
        x.iter_mut().zip(&along).for_each(|(x, d)| *x += step * d);
        left.iter_mut().zip(&image).for_each(|(r, q)| *r -= step * q);
        before = now;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::graph::Graph;
    use crate::algebra::sparse::Pattern;
    use crate::boxes;
    use crate::clamps::Clamps;

    #[test]
    fn a_matrix_with_a_rough_inverse_is_solved_and_an_indefinite_one_is_given_up() {
        let mesh = boxes::linear([0.1, 0.02, 0.02], [4, 1, 1]);
        let graph = Graph::new(mesh.nodes.len(), &mesh.elements);
        let pattern = Pattern::new(&mesh.nodes, &graph, &Clamps::below_x(&mesh, 1e-9));
        let n = pattern.freedoms();
        let mut values = vec![-0.1; pattern.entries()];
        (0..n).for_each(|column| values[pattern.columns[column] as usize] = 9.0 + (column % 5) as f64);
        let exact: Vec<f64> = (0..n).map(|at| (at as f64).sin()).collect();
        let mut b = vec![0.0; n];
        pattern.multiply(&values, &exact, &mut b);
        let rough = |x: &mut [f64]| x.iter_mut().for_each(|x| *x /= 10.0);
        let (x, iterations) =
            conjugate_gradients(|x, y| pattern.multiply(&values, x, y), rough, &b, 1e-12 * dot(&b, &b).sqrt(), 40)
                .unwrap();
        assert!(iterations > 2 && x.iter().zip(&exact).all(|(x, exact)| (x - exact).abs() < 1e-11));
        values[0] = -9.0;
        assert!(
            conjugate_gradients(|x, y| pattern.multiply(&values, x, y), rough, &b, 1e-12 * dot(&b, &b).sqrt(), 40)
                .is_none()
        );
    }
}
