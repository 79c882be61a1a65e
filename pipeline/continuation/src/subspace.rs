//! The eigenvalues of the tangent nearest to zero with their modes, K φ = μ φ: orthogonal iteration with the inverse
//! that the last factor applies, with Rayleigh–Ritz values [bathe1973].
//!
//! A few vectors are kept from point to point: a mode changes little along a path, so that two or three iterations, each
//! a few solves, follow it. No matrix is factorised for it.

use nalgebra::{DMatrix, SymmetricEigen};

/// Vectors of the subspace: modes often come in pairs, and neighbours near in value slow the iteration down.
const VECTORS: usize = 5;
/// Iterations at least: a mode that no kept vector contains grows out of the fresh one in two or three.
const MIN_ITERATIONS: usize = 3;

/// An eigenvalue of K (N/m) with its mode, φᵀφ = 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Eigenpair {
    pub value: f64,
    pub mode: Vec<f64>,
}

/// When the iteration stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Accuracy {
    /// To watch a path: the nearest eigenvalue to a thousandth.
    Watch,
    /// To locate a critical point: the mode to four digits.
    Critical,
}

impl Accuracy {
    /// Relative change of the first eigenvalue, and iterations at most.
    // The error of an eigenvalue is the square of that of its mode.
    fn limits(self) -> (f64, usize) {
        match self {
            Self::Watch => (1e-3, 12),
            Self::Critical => (1e-8, 40),
        }
    }
}

/// Orthonormal vectors near the lowest modes.
#[derive(Debug, Clone)]
pub(crate) struct Subspace {
    vectors: Vec<Vec<f64>>,
}

impl Subspace {
    /// Vectors that are orthogonal to no mode, the same in every run.
    pub fn new(dofs: usize) -> Self {
        Self { vectors: orthonormal_basis((0..VECTORS.min(dofs)).map(|seed| generic_vector(dofs, seed)).collect()) }
    }

    /// The eigenpairs nearest to zero first, by solves with the last factor.
    pub(crate) fn refine_eigenpairs(
        &mut self,
        solve: &mut dyn FnMut(&mut [f64]),
        accuracy: Accuracy,
    ) -> Vec<Eigenpair> {
        let (tolerance, max_iterations) = accuracy.limits();
        let mut values = vec![f64::INFINITY];
        self.refresh_last();
        for done in 1..=max_iterations {
            let previous_value = values[0];
            values = self.iterate_once(solve);
            if done >= MIN_ITERATIONS && (values[0] / previous_value - 1.0).abs() <= tolerance {
                break;
            }
        }
        values.into_iter().zip(&self.vectors).map(|(value, mode)| Eigenpair { value, mode: mode.clone() }).collect()
    }

    /// Puts a generic vector in the place of the last one: vectors that have converged at earlier points contain no mode
    /// that falls among the lowest since.
    fn refresh_last(&mut self) {
        if let Some(last) = self.vectors.pop() {
            self.vectors.push(generic_vector(last.len(), VECTORS));
            self.vectors = orthonormal_basis(std::mem::take(&mut self.vectors));
        }
    }

    /// One iteration; returns the Ritz values, nearest to zero first.
    fn iterate_once(&mut self, solve: &mut dyn FnMut(&mut [f64])) -> Vec<f64> {
        let mut images = self.vectors.clone();
        images.iter_mut().for_each(|x| solve(x));
        let count = images.len();
        let product = |i: usize, k: usize| sparse::dot(&self.vectors[i], &images[k]);
        let inverse = DMatrix::from_fn(count, count, |i, k| 0.5 * (product(i, k) + product(k, i)));
        let eigen = SymmetricEigen::new(inverse);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].abs().total_cmp(&eigen.eigenvalues[a].abs()));
        let combined = |&which: &usize| {
            let mut sum = vec![0.0; images[0].len()];
            images.iter().zip(eigen.eigenvectors.column(which).iter()).for_each(|(y, w)| sparse::add(&mut sum, *w, y));
            sum
        };
        self.vectors = orthonormal_basis(order.iter().map(combined).collect());
        order.iter().map(|&which| 1.0 / eigen.eigenvalues[which]).collect()
    }
}

/// A vector that is orthogonal to no mode, the same in every run.
fn generic_vector(dofs: usize, seed: usize) -> Vec<f64> {
    (0..dofs).map(|dof| (1.3 * ((dof + 1) * (seed + 1)) as f64 + seed as f64).sin()).collect()
}

/// Gram–Schmidt, twice: near a critical point the first vector outweighs the others by many digits.
fn orthonormal_basis(mut vectors: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for index in 0..vectors.len() {
        let (done, rest) = vectors.split_at_mut(index);
        let vector = &mut rest[0];
        scale_to_one(vector);
        for _ in 0..2 {
            for other in done.iter() {
                let part = sparse::dot(other, vector);
                sparse::add(vector, -part, other);
            }
            scale_to_one(vector);
        }
    }
    vectors
}

fn scale_to_one(x: &mut [f64]) {
    let norm = sparse::dot(x, x).sqrt();
    x.iter_mut().for_each(|entry| *entry /= norm);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eigenvalues_nearest_to_zero_and_their_modes_are_found_beside_negative_ones() {
        let diagonal: Vec<f64> = (0..40).map(|at| if at == 7 { -0.3 } else { 0.5 + at as f64 }).collect();
        let mut solve = |x: &mut [f64]| x.iter_mut().zip(&diagonal).for_each(|(x, d)| *x /= d);
        let pairs = Subspace::new(40).refine_eigenpairs(&mut solve, Accuracy::Critical);
        assert!((pairs[0].value + 0.3).abs() < 1e-9 && (pairs[1].value - 0.5).abs() < 1e-6, "{:?}", pairs[0].value);
        assert!(pairs[0].mode[7].abs() > 1.0 - 1e-9 && pairs[0].mode.iter().filter(|x| x.abs() > 1e-4).count() == 1);
    }

    #[test]
    fn a_problem_of_one_dof_has_its_only_eigenvalue() {
        let pairs = Subspace::new(1).refine_eigenpairs(&mut |x| x[0] /= -2.5, Accuracy::Watch);
        assert_eq!(pairs.len(), 1);
        assert!((pairs[0].value + 2.5).abs() < 1e-14);
    }
}
