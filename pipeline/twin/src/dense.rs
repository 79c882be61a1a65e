//! The inverse of a small matrix, and Broyden's update of it [broyden1965].

use crate::chambers::add;

/// The inverse of a matrix of n × n (row after row); none where it is singular.
pub fn inverse(mut matrix: Vec<f64>) -> Option<Vec<f64>> {
    let mut inverse = vec![0.0; matrix.len()];
    invert(&mut matrix, &mut inverse).then_some(inverse)
}

/// Fills the `inverse` of a matrix of n × n (row after row), which is spent, by Gauss–Jordan elimination with row exchange; returns whether there
/// is one.
// An explicit inverse: a product with it is three times faster than two triangular solves of this size, and it takes
// rank-one updates. Its rounding, the condition times 1e-16, is below the tolerance of a step.
pub(crate) fn invert(matrix: &mut [f64], inverse: &mut [f64]) -> bool {
    let n = matrix.len().isqrt();
    (0..n * n).for_each(|entry| inverse[entry] = f64::from(u8::from(entry / n == entry % n)));
    for column in 0..n {
        let size = |row: &usize| matrix[row * n + column].abs();
        let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
        let largest = matrix[pivot * n + column];
        if !(largest.is_finite() && largest != 0.0) {
            return false;
        }
        for both in [&mut *matrix, &mut *inverse] {
            (0..n).for_each(|k| both.swap(pivot * n + k, column * n + k));
            both[column * n..(column + 1) * n].iter_mut().for_each(|x| *x /= largest);
        }
        for row in (0..n).filter(|row| *row != column) {
            let factor = matrix[row * n + column];
            subtract_row(matrix, (row, column), factor);
            subtract_row(inverse, (row, column), factor);
        }
    }
    true
}

/// Subtracts `factor` times the row `pivot` of a square matrix from another `row`.
fn subtract_row(matrix: &mut [f64], (row, pivot): (usize, usize), factor: f64) {
    let n = matrix.len().isqrt();
    let (upper, lower) = matrix.split_at_mut(row.max(pivot) * n);
    let (first, second) = (&mut upper[row.min(pivot) * n..][..n], &mut lower[..n]);
    if row > pivot { add(second, -factor, first) } else { add(first, -factor, second) }
}

/// `image` = A x.
pub fn multiply(matrix: &[f64], x: &[f64], image: &mut [f64]) {
    for (row, image) in matrix.chunks_exact(x.len()).zip(image) {
        *image = row.iter().zip(x).map(|(a, x)| a * x).sum();
    }
}

/// `image` = Aᵀ x.
pub(crate) fn multiply_transposed(matrix: &[f64], x: &[f64], image: &mut [f64]) {
    image.fill(0.0);
    matrix.chunks_exact(x.len()).zip(x).for_each(|(row, x)| add(image, *x, row));
}

/// Updates an inverse H after a step −`change` = −H r that left the residual whose image is `next` = H r⁺, by Broyden's first
/// method; `next` becomes the image under the updated inverse, and `row` is for n numbers on the way. Returns whether it was updated.
pub(crate) fn broyden_update(inverse: &mut [f64], change: &[f64], (next, row): (&mut [f64], &mut [f64])) -> bool {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (projection, length) = (dot(change, next), dot(change, change));
    let remainder = length - projection;
    // The update divides by 1 − θ with θ the part of the step that is left; it is kept away from zero.
    if remainder < 0.1 * length {
        return false;
    }
    let n = change.len();
    row.fill(0.0);
    for (part, change) in inverse.chunks_exact(n).zip(change) {
        add(row, *change, part);
    }
    for (part, next) in inverse.chunks_exact_mut(n).zip(&*next) {
        add(part, next / remainder, row);
    }
    next.iter_mut().for_each(|entry| *entry *= length / remainder);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix() -> Vec<f64> {
        vec![0.0, 2.0, 1.0, 4.0, 1.0, -1.0, 1.0, 0.5, 3.0]
    }

    #[test]
    fn a_matrix_times_its_inverse_is_the_unit_matrix() {
        let inverse = inverse(matrix()).unwrap();
        for k in 0..3 {
            let column: Vec<f64> = (0..3).map(|i| inverse[3 * i + k]).collect();
            let mut image = [0.0; 3];
            multiply(&matrix(), &column, &mut image);
            (0..3).for_each(|i| assert!((image[i] - f64::from(u8::from(i == k))).abs() < 1e-15));
        }
        assert!(super::inverse(vec![1.0, 2.0, 2.0, 4.0]).is_none());
    }

    #[test]
    fn the_product_with_the_transposed_matrix_sums_its_rows() {
        let mut image = [0.0; 3];
        multiply_transposed(&matrix(), &[1.0, -2.0, 0.5], &mut image);
        assert_eq!(image, [-7.5, 0.25, 4.5]);
    }

    #[test]
    fn the_updated_inverse_maps_the_change_of_the_residual_to_the_step() {
        let mut own = inverse(matrix()).unwrap();
        let (before, after) = ([1.0, -2.0, 0.5], [0.2, 0.1, -0.3]);
        let (mut change, mut next) = ([0.0; 3], [0.0; 3]);
        multiply(&own, &before, &mut change);
        multiply(&own, &after, &mut next);
        assert!(broyden_update(&mut own, &change, (&mut next, &mut [0.0; 3])));
        let mut image = [0.0; 3];
        multiply(&own, &[0, 1, 2].map(|k| after[k] - before[k]), &mut image);
        (0..3).for_each(|k| assert!((image[k] + change[k]).abs() < 1e-14));
        multiply(&own, &after, &mut image);
        (0..3).for_each(|k| assert!((image[k] - next[k]).abs() < 1e-14));
    }
}
