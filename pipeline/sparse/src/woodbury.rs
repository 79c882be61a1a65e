//! Woodbury's formula for a sparse matrix with a few dense rank-one terms, K + Σ c v vᵀ: one term per sealed chamber.
//!
//! (K + V C Vᵀ)⁻¹ x = y − Z (C⁻¹ + VᵀZ)⁻¹ Vᵀ y with y = K⁻¹ x, Z = K⁻¹ V.     [woodbury1950]
//!
//! A sealed chamber couples all nodes of its wall. Assembled, that block would change the sparsity of the matrix and
//! fill the factor; kept apart as one vector, it leaves the symbolic factorisation of the open chamber valid.

use crate::dot;
use nalgebra::{DMatrix, DVector};

/// The rank-one terms, in elimination order, and their solves with K.
#[derive(Debug, Default)]
pub struct RankOneUpdates {
    /// c and v of each.
    terms: Vec<(f64, Vec<f64>)>,
    /// K⁻¹ v of each.
    solved: Vec<Vec<f64>>,
    /// (C⁻¹ + VᵀZ)⁻¹
    inner: DMatrix<f64>,
}

impl RankOneUpdates {
    /// Terms without a factor of K: they can be multiplied by, not solved with.
    pub fn new(terms: Vec<(f64, Vec<f64>)>) -> Self {
        Self { terms, ..Self::default() }
    }

    /// Prepares solves with the inverse of K that `solve` applies; false when the sum is singular.
    pub fn prepare_solves(&mut self, mut solve: impl FnMut(&mut [f64])) -> bool {
        self.solved = self.terms.iter().map(|(_, v)| v.clone()).collect();
        self.solved.iter_mut().for_each(|v| solve(v));
        let count = self.terms.len();
        let inner = DMatrix::from_fn(count, count, |i, k| {
            dot(&self.terms[i].1, &self.solved[k]) + if i == k { 1.0 / self.terms[i].0 } else { 0.0 }
        });
        match inner.try_inverse() {
            Some(inverse) => self.inner = inverse,
            None => return false,
        }
        true
    }

    /// From y = K⁻¹ x to (K + Σ c v vᵀ)⁻¹ x.
    pub fn correct_solution(&self, y: &mut [f64]) {
        if self.solved.is_empty() {
            return;
        }
        let products = DVector::from_iterator(self.terms.len(), self.terms.iter().map(|(_, v)| dot(v, y)));
        let parts = &self.inner * products;
        for (z, part) in self.solved.iter().zip(parts.iter()) {
            y.iter_mut().zip(z).for_each(|(y, z)| *y -= part * z);
        }
    }

    /// Adds Σ c v (v · x) to `image`.
    pub fn multiply(&self, x: &[f64], image: &mut [f64]) {
        for (c, v) in &self.terms {
            let part = c * dot(v, x);
            image.iter_mut().zip(v).for_each(|(image, v)| *image += part * v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagonal_matrix_with_two_rank_one_terms_is_solved_exactly() {
        let diagonal = [2.0, 3.0, 5.0, 7.0];
        let terms = vec![(1.5, vec![1.0, -1.0, 0.5, 2.0]), (0.2, vec![0.0, 4.0, 1.0, -3.0])];
        let solve = |x: &mut [f64]| x.iter_mut().zip(diagonal).for_each(|(x, d)| *x /= d);
        let mut updates = RankOneUpdates::new(terms);
        assert!(updates.prepare_solves(solve));
        let exact = [0.3, -1.0, 2.0, 0.7];
        let mut b: Vec<f64> = exact.iter().zip(diagonal).map(|(x, d)| d * x).collect();
        updates.multiply(&exact, &mut b);
        solve(&mut b);
        updates.correct_solution(&mut b);
        assert!(b.iter().zip(exact).all(|(x, exact)| (x - exact).abs() < 1e-13), "{b:?}");
    }
}
