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
    pub fn columns_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [f32]> {
        self.values.par_chunks_exact_mut(self.rows)
    }

    fn column(&self, index: usize) -> &[f32] {
        &self.values[index * self.rows..(index + 1) * self.rows]
    }

    /// The `count` columns with the smallest angle to `residual`, among those not `taken`; fewer when fewer have an
    /// acute one.
    fn nearest_columns(&self, residual: &[f32], lengths: &[f32], taken: &[bool], count: usize) -> Vec<usize> {
        let projection = |(index, column): (usize, &[f32])| (inner_product(column, residual) / lengths[index], index);
        let scored =
            self.values.par_chunks_exact(self.rows).enumerate().filter(|(index, _)| !taken[*index]).map(projection);
        let mut acute: Vec<(f32, usize)> = scored.filter(|(projection, _)| *projection > 0.0).collect();
        acute.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        acute.into_iter().take(count).map(|(_, index)| index).collect()
    }
}

/// Inner product in sixteen partial sums, so that it vectorises; always in the same order.
fn inner_product(a: &[f32], b: &[f32]) -> f32 {
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
    let lengths: Vec<f32> = columns.columns_mut().map(|c| inner_product(c, c).sqrt().max(f32::MIN_POSITIVE)).collect();
    let mut taken = vec![false; lengths.len()];
    let mut set = ActiveSet::new(&target);
    let enough = tolerance * target.norm();
    while set.residual.norm() > enough && set.numbers.len() < columns.rows.min(lengths.len()) {
        let residual: Vec<f32> = set.residual.iter().map(|x| *x as f32).collect();
        let entering = columns.nearest_columns(&residual, &lengths, &taken, 1 + set.numbers.len() / GROWTH);
        if entering.is_empty() {
            break;
        }
        entering.iter().for_each(|next| taken[*next] = true);
        set.add_columns(&entering, columns);
        set.update_weights();
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
    target_products: Vec<f64>,
    weights: Vec<f64>,
    residual: DVector<f64>,
}

impl<'a> ActiveSet<'a> {
    fn new(target: &'a DVector<f64>) -> Self {
        let (numbers, columns, target_products, weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self {
            target,
            numbers,
            columns,
            products: DMatrix::zeros(0, 0),
            target_products,
            weights,
            residual: target.clone(),
        }
    }

    /// Adds columns with zero weights.
    fn add_columns(&mut self, numbers: &[usize], source: &NnlsColumns) {
        let start = self.columns.len();
        self.columns.extend(
            numbers
                .iter()
                .map(|&index| DVector::from_iterator(source.rows, source.column(index).iter().map(|x| f64::from(*x)))),
        );
        let count = self.columns.len();
        let columns = &self.columns;
        let products: Vec<Vec<f64>> = (start..count)
            .into_par_iter()
            .map(|new| columns[..=new].iter().map(|column| column.dot(&columns[new])).collect())
            .collect();
        self.products.resize_mut(count, count, 0.0);
        for (new, column_products) in (start..count).zip(&products) {
            for (row, product) in column_products.iter().enumerate() {
                (self.products[(row, new)], self.products[(new, row)]) = (*product, *product);
            }
        }
        self.target_products.extend(columns[start..].iter().map(|column| column.dot(self.target)));
        self.numbers.extend(numbers);
        self.weights.resize(count, 0.0);
    }

    /// Least squares over the active columns, without those whose weights would not be positive.
    // Removing only those that reach zero first, as in [lawson1974], asks for a factor of the products for each.
    fn update_weights(&mut self) {
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
        solve_cholesky(products, DVector::from_column_slice(&self.target_products))
    }

    /// Removes columns whose weights are not positive.
    fn keep_positive(&mut self) {
        let positive: Vec<bool> = self.weights.iter().map(|w| *w > 0.0).collect();
        let indices: Vec<usize> = (0..positive.len()).filter(|i| positive[*i]).collect();
        self.products = self.products.select_rows(&indices).select_columns(&indices);
        retain_masked(&mut self.target_products, &positive);
        retain_masked(&mut self.numbers, &positive);
        retain_masked(&mut self.weights, &positive);
        retain_masked(&mut self.columns, &positive);
    }
}

/// Keeps the entries whose `mask` is true.
fn retain_masked<T>(entries: &mut Vec<T>, mask: &[bool]) {
    let mut flags = mask.iter();
    entries.retain(|_| flags.next().is_some_and(|flag| *flag));
}

/// A⁻¹ b for a symmetric A by its Cholesky factor; none where A is not positive definite.
// On one thread, so that the result does not depend on the number of threads.
#[allow(non_snake_case)]
fn solve_cholesky(mut A: DMatrix<f64>, mut b: DVector<f64>) -> Option<DVector<f64>> {
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
        let selected = nnls(&mut columns, &target, 1e-6);
        assert!(selected.len() <= rows && selected.iter().all(|(_, weight)| *weight > 0.0), "{selected:?}");
        for (row, sum) in target.iter().enumerate() {
            let reproduced: f64 =
                selected.iter().map(|(index, weight)| weight * f64::from(columns.column(*index)[row])).sum();
            assert!((reproduced - sum).abs() < 2e-6, "row {row}: {reproduced} for {sum}");
        }
    }
}
