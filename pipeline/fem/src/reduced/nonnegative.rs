//! A few columns that add up to all of them, with weights that are not negative.
//!
//! Active sets as in [lawson1974], a few columns at a time by their angle to what is left, until the rest is small: the first
//! set that is good enough is taken, not the best one. Columns are kept in single precision; sums are taken in double.
//!
//! Stands on: `nalgebra`, `faer`'s dense factor, `rayon`. Never knows: what a column holds.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{MatMut, Par};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// The set grows by its own number over this at a time, and by one.
const AT_ONCE: usize = 25;

/// Columns in single precision, one after the other.
pub(super) struct Columns {
    rows: usize,
    values: Vec<f32>,
}

impl Columns {
    /// All nothing.
    pub fn new(rows: usize, count: usize) -> Self {
        Self { rows, values: vec![0.0; rows * count] }
    }

    /// Each, side by side.
    pub fn each(&mut self) -> impl IndexedParallelIterator<Item = &mut [f32]> {
        self.values.par_chunks_exact_mut(self.rows)
    }

    /// Multiplies each row by its weight.
    pub fn weigh(&mut self, weights: &[f32]) {
        self.each().for_each(|column| column.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight));
    }

    /// Sums of the rows.
    pub fn sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.rows];
        for column in self.values.chunks_exact(self.rows) {
            sums.iter_mut().zip(column).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        sums
    }

    fn column(&self, at: usize) -> &[f32] {
        &self.values[at * self.rows..(at + 1) * self.rows]
    }

    /// The `count` columns that point most along `rest`, among those not `taken`; fewer where fewer do.
    fn nearest(&self, rest: &[f32], lengths: &[f32], taken: &[bool], count: usize) -> Vec<usize> {
        let along = |(at, column): (usize, &[f32])| (inner(column, rest) / lengths[at], at);
        let all = self.values.par_chunks_exact(self.rows).enumerate().filter(|(at, _)| !taken[*at]).map(along);
        let mut found: Vec<(f32, usize)> = all.filter(|(along, _)| *along > 0.0).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().take(count).map(|(_, at)| at).collect()
    }
}

/// In eight sums side by side, for speed; always in the same order.
fn inner(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 16];
    let (a, b) = (a.chunks_exact(16), b.chunks_exact(16));
    let rest: f32 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        (0..16).for_each(|i| sums[i] += a[i] * b[i]);
    }
    sums.iter().sum::<f32>() + rest
}

/// Columns (by number) and weights > 0 whose sum is within `tolerance` of the sum of all columns, relative.
pub(super) fn fit(columns: &mut Columns, tolerance: f64) -> Vec<(usize, f64)> {
    let whole = DVector::from_vec(columns.sums());
    let lengths: Vec<f32> = columns.each().map(|c| inner(c, c).sqrt().max(f32::MIN_POSITIVE)).collect();
    let mut taken = vec![false; lengths.len()];
    let mut set = Set::new(&whole);
    let enough = tolerance * whole.norm();
    while set.rest.norm() > enough && set.chosen.len() < columns.rows.min(lengths.len()) {
        let rest: Vec<f32> = set.rest.iter().map(|x| *x as f32).collect();
        let found = columns.nearest(&rest, &lengths, &taken, 1 + set.chosen.len() / AT_ONCE);
        if found.is_empty() {
            break;
        }
        for next in found {
            taken[next] = true;
            set.take(next, columns.column(next));
        }
        set.settle();
    }
    set.chosen.iter().copied().zip(set.weights.iter().copied()).collect()
}

/// The chosen columns and their weights, always all positive.
struct Set<'a> {
    whole: &'a DVector<f64>,
    chosen: Vec<usize>,
    columns: Vec<DVector<f64>>,
    /// Products between the chosen.
    products: DMatrix<f64>,
    weights: Vec<f64>,
    rest: DVector<f64>,
}

impl<'a> Set<'a> {
    fn new(whole: &'a DVector<f64>) -> Self {
        let (chosen, columns, weights) = (Vec::new(), Vec::new(), Vec::new());
        Self { whole, chosen, columns, products: DMatrix::zeros(0, 0), weights, rest: whole.clone() }
    }

    /// One column more, with no weight yet.
    fn take(&mut self, at: usize, column: &[f32]) {
        let column = DVector::from_iterator(column.len(), column.iter().map(|x| f64::from(*x)));
        let n = self.columns.len();
        let mut products = std::mem::replace(&mut self.products, DMatrix::zeros(0, 0)).resize(n + 1, n + 1, 0.0);
        for (i, other) in self.columns.iter().enumerate() {
            let product = other.dot(&column);
            (products[(i, n)], products[(n, i)]) = (product, product);
        }
        products[(n, n)] = column.norm_squared();
        self.products = products;
        self.columns.push(column);
        self.chosen.push(at);
        self.weights.push(0.0);
    }

    /// Least squares over the chosen; those whose weights would fall to nothing on the way are let go.
    fn settle(&mut self) {
        while let Some(goal) = self.goal() {
            if goal.iter().all(|w| *w > 0.0) {
                self.weights = goal.as_slice().to_vec();
                break;
            }
            let crossing = |(now, then): (&f64, &f64)| if *then <= 0.0 { now / (now - then) } else { 1.0 };
            let part = self.weights.iter().zip(&goal).map(crossing).fold(1.0, f64::min);
            for (now, then) in self.weights.iter_mut().zip(&goal) {
                *now += part * (then - *now);
            }
            self.let_go(&goal);
        }
        self.rest = self.whole.clone();
        for (weight, column) in self.weights.iter().zip(&self.columns) {
            self.rest.axpy(-weight, column, 1.0);
        }
    }

    /// The weights of least squares; none once the chosen say the same twice.
    fn goal(&mut self) -> Option<DVector<f64>> {
        let along = DVector::from_iterator(self.columns.len(), self.columns.iter().map(|c| c.dot(self.whole)));
        let mut products = self.products.clone();
        let ridge = 1e-13 * products.diagonal().max();
        products.diagonal().iter().enumerate().for_each(|(i, d)| products[(i, i)] = d + ridge);
        solved(products, along)
    }

    /// Lets columns go that are at no weight and would go below.
    fn let_go(&mut self, goal: &DVector<f64>) {
        let least = 1e-12 * self.weights.iter().fold(0.0, |most: f64, w| most.max(*w));
        let kept: Vec<usize> = (0..self.weights.len()).filter(|i| self.weights[*i] > least || goal[*i] > 0.0).collect();
        self.products = self.products.select_rows(&kept).select_columns(&kept);
        self.columns = kept.iter().map(|i| self.columns[*i].clone()).collect();
        self.chosen = kept.iter().map(|i| self.chosen[*i]).collect();
        self.weights = kept.iter().map(|i| self.weights[*i]).collect();
    }
}

/// A⁻¹ b for a symmetric A by its factor, in one thread, so that it is the same on any number of them; none where A is not
/// positive definite.
#[allow(non_snake_case)]
fn solved(mut A: DMatrix<f64>, mut b: DVector<f64>) -> Option<DVector<f64>> {
    let n = b.len();
    let mut memory = MemBuffer::new(factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
    let memory = MemStack::new(&mut memory);
    let mut whole = MatMut::from_column_major_slice_mut(A.as_mut_slice(), n, n);
    factor::cholesky_in_place(whole.as_mut(), Default::default(), Par::Seq, memory, Default::default()).ok()?;
    let x = MatMut::from_column_major_slice_mut(b.as_mut_slice(), n, 1);
    solve::solve_in_place(whole.as_ref(), x, Par::Seq, MemStack::new(&mut []));
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_many_columns_is_met_by_as_many_as_it_has_rows() {
        let (rows, count) = (6, 400);
        let mut columns = Columns::new(rows, count);
        for (i, column) in columns.values.chunks_exact_mut(rows).enumerate() {
            let x = i as f32 / count as f32;
            column.iter_mut().enumerate().for_each(|(k, value)| *value = x.powi(k as i32) / count as f32);
        }
        let whole = columns.sums();
        let found = fit(&mut columns, 1e-6);
        assert!(found.len() <= rows && found.iter().all(|(_, weight)| *weight > 0.0), "{found:?}");
        for (row, sum) in whole.iter().enumerate() {
            let met: f64 = found.iter().map(|(at, weight)| weight * f64::from(columns.column(*at)[row])).sum();
            assert!((met - sum).abs() < 2e-6, "row {row}: {met} for {sum}");
        }
    }
}
