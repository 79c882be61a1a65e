//! Linear least squares on the normal equations: plain, ridge and non-negative.
//!
//! A model is a weighted sum of columns, one number a sample each. The problems here have at most some dozens of columns that are
//! sampled thousands of times, so the normal equations are formed once and solved by Cholesky's method.

use nalgebra::{DMatrix, DVector};

/// Weights of `columns` (each as long as `target`) with the least squared difference from `target`.
///
/// `None` when the normal matrix is not positive definite.
pub fn least_squares(columns: &[Vec<f64>], target: &[f64]) -> Option<Vec<f64>> {
    let (gram, right) = normal_equations(columns, target);
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

/// Ridge regression \[tikhonov1977\]: as [`least_squares`], with `penalty[i]` added to the square of column i.
///
/// Columns beyond the penalties are not penalised.
pub fn ridge(columns: &[Vec<f64>], target: &[f64], penalty: &[f64]) -> Option<Vec<f64>> {
    let (mut gram, right) = normal_equations(columns, target);
    penalty.iter().enumerate().for_each(|(i, s)| gram[(i, i)] += s);
    Some(gram.cholesky()?.solve(&right).as_slice().to_vec())
}

/// Non-negative least squares: as [`least_squares`], with the first `constrained` weights at least zero.
///
/// An active-set method: the most negative constrained weight is fixed at zero and the rest is solved again, until none is negative.
pub fn nnls(columns: &[Vec<f64>], target: &[f64], constrained: usize) -> Option<Vec<f64>> {
    let (gram, right) = normal_equations(columns, target);
    let mut free = vec![true; columns.len()];
    loop {
        let passive: Vec<usize> = (0..free.len()).filter(|&i| free[i]).collect();
        let passive_gram = DMatrix::from_fn(passive.len(), passive.len(), |i, j| gram[(passive[i], passive[j])]);
        let solution = passive_gram.cholesky()?.solve(&DVector::from_fn(passive.len(), |i, _| right[passive[i]]));
        let negative = (0..passive.len()).filter(|&i| passive[i] < constrained && solution[i] < 0.0);
        match negative.min_by(|&a, &b| solution[a].total_cmp(&solution[b])) {
            // A fixed weight is not released again, as Lawson and Hanson's method would: there is at most one solve a column, and the
            // weights are optimal among those with the same weights fixed.
            Some(i) => free[passive[i]] = false,
            None => {
                let mut weights = vec![0.0; free.len()];
                passive.iter().zip(solution.iter()).for_each(|(&i, &w)| weights[i] = w);
                return Some(weights);
            }
        }
    }
}

/// Σ weight × column.
pub fn weighted_sum(columns: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let mut total = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, weight) in columns.iter().zip(weights) {
        total.iter_mut().zip(column).for_each(|(t, c)| *t += weight * c);
    }
    total
}

fn normal_equations(columns: &[Vec<f64>], target: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let n = columns.len();
    let mut gram = DMatrix::from_fn(n, n, |i, j| if j <= i { dot(&columns[i], &columns[j]) } else { 0.0 });
    gram.fill_upper_triangle_with_lower_triangle();
    for i in 0..n {
        // A relative ridge of 1e-12 keeps equal columns from making the matrix singular; it changes a weight by far less than noise.
        gram[(i, i)] = gram[(i, i)] * (1.0 + 1e-12) + 1e-300;
    }
    (gram, DVector::from_fn(n, |i, _| dot(&columns[i], target)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constant, line and sine over 50 samples.
    fn columns() -> Vec<Vec<f64>> {
        let column = |value: fn(f64) -> f64| (0..50).map(|i| value(f64::from(i) / 25.0 - 1.0)).collect();
        vec![column(|_| 1.0), column(|t| t), column(|t| (10.0 * t).sin())]
    }

    #[test]
    fn the_weights_of_a_sum_are_recovered() {
        let found = least_squares(&columns(), &weighted_sum(&columns(), &[1.0, -2.0, 3.0])).unwrap();
        assert!(found.iter().zip([1.0, -2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_penalty_shrinks_its_own_weight_alone_when_columns_are_orthogonal() {
        let columns = vec![vec![1.0, 1.0, 1.0, 1.0], vec![1.0, -1.0, 1.0, -1.0]];
        let found = ridge(&columns, &weighted_sum(&columns, &[2.0, 3.0]), &[4.0]).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-9 && (found[1] - 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_weight_that_would_be_negative_is_zero_and_the_others_are_optimal_without_it() {
        let columns = &columns()[..2];
        let target = weighted_sum(columns, &[-1.0, 2.0]);
        let found = nnls(columns, &target, 1).unwrap();
        assert_eq!(found[0], 0.0);
        assert!((found[1] - least_squares(&columns[1..], &target).unwrap()[0]).abs() < 1e-12);
    }

    #[test]
    fn a_column_of_zeros_has_no_weight_and_leaves_the_others_theirs() {
        let columns = vec![vec![1.0, 1.0, 2.0], vec![0.0; 3]];
        let found = least_squares(&columns, &[3.0, 3.0, 6.0]).unwrap();
        assert!((found[0] - 3.0).abs() < 1e-9 && found[1] == 0.0, "{found:?}");
    }

    #[test]
    fn two_equal_columns_share_their_weight() {
        let column = vec![1.0, 2.0, -1.0];
        let found = least_squares(&[column.clone(), column.clone()], &weighted_sum(&[column], &[3.0])).unwrap();
        // the relative ridge of 1e-12 leaves four digits of their difference
        assert!(found.iter().all(|weight| (weight - 1.5).abs() < 1e-3), "{found:?}");
    }
}
