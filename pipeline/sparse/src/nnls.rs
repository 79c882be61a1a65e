//! Non-negative least squares (NNLS) with a sparse solution: a few of many columns, with positive weights, that reproduce
//! the sum of all; hyper-reduction selects cubature points by it.
//!
//! Active sets as in [lawson1974], several columns at a time by their angle to the residual; columns of negative weight leave
//! all at once [hernandez2017]. The first set within the tolerance is taken, not the optimal one. Columns are stored in single
//! precision and summed in double.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{MatMut, Par};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Each round adds one column, and one for this many active ones.
// One column per round is the textbook method and needs one solve per column. Scanning only every eighth column per
// round gave nearly as many points (553 against 550) for a saving that could not be shown.
const GROWTH: usize = 25;

/// Columns in single precision, one after the other.
pub struct NnlsColumns {
    rows: usize,
    values: Vec<f32>,
}

impl NnlsColumns {
    /// `count` columns of `rows` zeros.
    pub fn new(rows: usize, count: usize) -> Self {
        Self { rows, values: vec![0.0; rows * count] }
    }

    /// All columns, in parallel.
    pub fn each(&mut self) -> impl IndexedParallelIterator<Item = &mut [f32]> {
        self.values.par_chunks_exact_mut(self.rows)
    }

    fn column(&self, at: usize) -> &[f32] {
        &self.values[at * self.rows..(at + 1) * self.rows]
    }

    /// The `count` columns with the smallest angle to `residual`, among those not `taken`; fewer when fewer have an
    /// acute one.
    fn nearest(&self, residual: &[f32], lengths: &[f32], taken: &[bool], count: usize) -> Vec<usize> {
        let along = |(at, column): (usize, &[f32])| (inner(column, residual) / lengths[at], at);
        let all = self.values.par_chunks_exact(self.rows).enumerate().filter(|(at, _)| !taken[*at]).map(along);
        let mut found: Vec<(f32, usize)> = all.filter(|(along, _)| *along > 0.0).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().take(count).map(|(_, at)| at).collect()
    }
}

/// Inner product in sixteen partial sums, so that it vectorises; always in the same order.
fn inner(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 16];
    let (a, b) = (a.chunks_exact(16), b.chunks_exact(16));
    let remainder: f32 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        (0..16).for_each(|i| sums[i] += a[i] * b[i]);
    }
    sums.iter().sum::<f32>() + remainder
}

/// Columns (by number) and weights > 0 whose sum is within `tolerance` of the `target` (one entry a row), relative.
pub fn nnls(columns: &mut NnlsColumns, target: &[f64], tolerance: f64) -> Vec<(usize, f64)> {
    let target = DVector::from_column_slice(target);
    let lengths: Vec<f32> = columns.each().map(|c| inner(c, c).sqrt().max(f32::MIN_POSITIVE)).collect();
    let mut taken = vec![false; lengths.len()];
    let mut set = ActiveSet::new(&target);
    let enough = tolerance * target.norm();
    while set.residual.norm() > enough && set.numbers.len() < columns.rows.min(lengths.len()) {
        let residual: Vec<f32> = set.residual.iter().map(|x| *x as f32).collect();
        let found = columns.nearest(&residual, &lengths, &taken, 1 + set.numbers.len() / GROWTH);
        if found.is_empty() {
            break;
        }
        found.iter().for_each(|next| taken[*next] = true);
        set.extend(&found, columns);
        set.solve();
    }
    set.numbers.iter().copied().zip(set.weights.iter().copied()).collect()
}

/// The active columns and their weights, which are always positive.
struct ActiveSet<'a> {
    target: &'a DVector<f64>,
    numbers: Vec<usize>,
    columns: Vec<DVector<f64>>,
    /// Products of the columns.
    products: DMatrix<f64>,
    /// Products of each with the target.
    along: Vec<f64>,
    weights: Vec<f64>,
    residual: DVector<f64>,
}

impl<'a> ActiveSet<'a> {
    fn new(target: &'a DVector<f64>) -> Self {
        let (numbers, columns, along, weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { target, numbers, columns, products: DMatrix::zeros(0, 0), along, weights, residual: target.clone() }
    }

    /// Adds columns with zero weights.
    fn extend(&mut self, numbers: &[usize], all: &NnlsColumns) {
        let before = self.columns.len();
        self.columns.extend(
            numbers.iter().map(|&at| DVector::from_iterator(all.rows, all.column(at).iter().map(|x| f64::from(*x)))),
        );
        let count = self.columns.len();
        let columns = &self.columns;
        let products: Vec<Vec<f64>> = (before..count)
            .into_par_iter()
            .map(|new| columns[..=new].iter().map(|other| other.dot(&columns[new])).collect())
            .collect();
        self.products.resize_mut(count, count, 0.0);
        for (new, with_others) in (before..count).zip(&products) {
            for (other, product) in with_others.iter().enumerate() {
                (self.products[(other, new)], self.products[(new, other)]) = (*product, *product);
            }
        }
        self.along.extend(columns[before..].iter().map(|column| column.dot(self.target)));
        self.numbers.extend(numbers);
        self.weights.resize(count, 0.0);
    }

    /// Least squares over the active columns, without those whose weights would not be positive.
    // Removing only those that reach zero first, as in [lawson1974], asks for a factor of the products for each.
    fn solve(&mut self) {
        while let Some(goal) = self.least_squares() {
            self.weights = goal.as_slice().to_vec();
            if goal.iter().all(|w| *w > 0.0) {
                break;
            }
            self.keep_positive();
        }
        self.residual = self.target.clone();
        for (weight, column) in self.weights.iter().zip(&self.columns) {
            self.residual.axpy(-weight, column, 1.0);
        }
    }

    /// The unconstrained weights of least squares; none when the columns are linearly dependent.
    fn least_squares(&mut self) -> Option<DVector<f64>> {
        let mut products = self.products.clone();
        let ridge = 1e-13 * products.diagonal().max();
        products.diagonal().iter().enumerate().for_each(|(i, d)| products[(i, i)] = d + ridge);
        solved(products, DVector::from_column_slice(&self.along))
    }

    /// Removes columns whose weights are not positive.
    fn keep_positive(&mut self) {
        let positive: Vec<bool> = self.weights.iter().map(|w| *w > 0.0).collect();
        let kept: Vec<usize> = (0..positive.len()).filter(|i| positive[*i]).collect();
        self.products = self.products.select_rows(&kept).select_columns(&kept);
        retain(&mut self.along, &positive);
        retain(&mut self.numbers, &positive);
        retain(&mut self.weights, &positive);
        retain(&mut self.columns, &positive);
    }
}

/// Keeps the entries that are `kept`.
fn retain<T>(entries: &mut Vec<T>, kept: &[bool]) {
    let mut each = kept.iter();
    entries.retain(|_| each.next().is_some_and(|kept| *kept));
}

/// A⁻¹ b for a symmetric A by its Cholesky factor; none where A is not positive definite.
// On one thread, so that the result does not depend on the number of threads.
#[allow(non_snake_case)]
fn solved(mut A: DMatrix<f64>, mut b: DVector<f64>) -> Option<DVector<f64>> {
    let n = b.len();
    let mut workspace = MemBuffer::new(factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
    let workspace = MemStack::new(&mut workspace);
    let mut matrix = MatMut::from_column_major_slice_mut(A.as_mut_slice(), n, n);
    factor::cholesky_in_place(matrix.as_mut(), Default::default(), Par::Seq, workspace, Default::default()).ok()?;
    let x = MatMut::from_column_major_slice_mut(b.as_mut_slice(), n, 1);
    solve::solve_in_place(matrix.as_ref(), x, Par::Seq, MemStack::new(&mut []));
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_of_many_columns_is_reproduced_by_at_most_as_many_as_rows() {
        let (rows, count) = (6, 400);
        let mut columns = NnlsColumns::new(rows, count);
        for (i, column) in columns.values.chunks_exact_mut(rows).enumerate() {
            let x = i as f32 / count as f32;
            column.iter_mut().enumerate().for_each(|(k, value)| *value = x.powi(k as i32) / count as f32);
        }
        let mut target = vec![0.0; rows];
        for column in columns.values.chunks_exact(rows) {
            target.iter_mut().zip(column).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        let found = nnls(&mut columns, &target, 1e-6);
        assert!(found.len() <= rows && found.iter().all(|(_, weight)| *weight > 0.0), "{found:?}");
        for (row, sum) in target.iter().enumerate() {
            let met: f64 = found.iter().map(|(at, weight)| weight * f64::from(columns.column(*at)[row])).sum();
            assert!((met - sum).abs() < 2e-6, "row {row}: {met} for {sum}");
        }
    }
}
