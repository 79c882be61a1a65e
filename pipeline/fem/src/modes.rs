//! Natural modes of vibration about an equilibrium: K φ = ω² M φ, by subspace iteration [bathe1973].
//!
//! Each iteration solves with one factor of the tangent K and finds the best modes in the subspace (Rayleigh and Ritz).
//! It converges with the ratio of the eigenvalues wanted to the first one left out, hence a few vectors more.

use crate::solve_error::SolveError;
use crate::solver::Solver;
use crate::statics::equilibrium::Equilibrium;
use nalgebra::{DMatrix, SymmetricEigen};
use si::Hertz;
use sparse::dot;

/// A natural mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// ω/2π.
    pub frequency: Hertz,
    /// φ with φᵀ M φ = 1 kg m², 3 entries per node.
    pub shape: Vec<f64>,
}

/// Iterations at most.
const MAX_ITERATIONS: usize = 60;
/// Relative change of ω² below which a mode has converged; its shape is then known to the root of that.
const TOLERANCE: f64 = 1e-11;

impl Solver {
    /// The `count` modes of lowest frequency about the equilibrium `at`, without damping; chambers keep their pressures.
    ///
    /// # Errors
    /// [`SolveError`] when `at` is not of this system or not stable, there are fewer degrees of freedom than modes, or the interrupt ends it.
    pub fn modes(&mut self, at: &Equilibrium, count: usize) -> Result<Vec<Mode>, SolveError> {
        let dofs = self.state.data.pattern.dofs();
        if count == 0 || count > dofs {
            let range = "at least 1 and at most the number of degrees of freedom";
            return Err(SolveError::Setting { what: "the number of modes", value: count as f64, range });
        }
        self.assemble(at)?;
        self.factorise(at)?;
        // Bathe's choice: with fewer vectors the last modes wanted converge with a ratio near one, and each more costs
        // a solve an iteration.
        let size = (2 * count).min(count + 8).min(dofs);
        let mut vectors: Vec<Vec<f64>> = (0..size).map(|seed| self.start_vector(seed)).collect();
        let mut previous_values = vec![f64::INFINITY; size];
        for iterations in 0..MAX_ITERATIONS {
            if self.state.newton.interrupt.as_ref().is_some_and(|asked| asked()) {
                return Err(SolveError::Interrupted { iterations });
            }
            let (values, next) = self.subspace_step(&vectors)?;
            vectors = next;
            let converged =
                values[..count].iter().zip(&previous_values).all(|(now, then)| (now / then - 1.0).abs() < TOLERANCE);
            previous_values = values;
            if converged {
                break;
            }
        }
        let frequency = |value: f64| value.max(0.0).sqrt() / std::f64::consts::TAU;
        let modes = previous_values.into_iter().zip(vectors).take(count);
        Ok(modes.map(|(value, shape)| Mode { frequency: frequency(value), shape }).collect())
    }

    /// A vector that is orthogonal to no mode, the same in every run.
    fn start_vector(&self, seed: usize) -> Vec<f64> {
        let entry = |at: usize| (1.3 * (at * (seed + 1)) as f64 + seed as f64).sin();
        self.state.with_constraints(&(0..self.state.data.full_length()).map(entry).collect::<Vec<_>>())
    }

    /// ω² and modes in the subspace K⁻¹ M x of the `vectors` x, in rising order.
    fn subspace_step(&mut self, vectors: &[Vec<f64>]) -> Result<(Vec<f64>, Vec<Vec<f64>>), SolveError> {
        let images: Vec<Vec<f64>> = vectors.iter().map(|x| self.state.mass_times(x)).collect();
        let solved: Vec<Vec<f64>> = images.iter().map(|image| self.solve(image)).collect::<Result<_, _>>()?;
        let weighted: Vec<Vec<f64>> = solved.iter().map(|y| self.state.mass_times(y)).collect();
        let products = |right: &[Vec<f64>]| {
            let count = solved.len();
            let full = DMatrix::from_fn(count, count, |i, k| dot(&solved[i], &right[k]));
            // Solves leave the products unsymmetric by rounding, and Cholesky's factor and the eigenvalues read one
            // triangle alone.
            (&full + full.transpose()) * 0.5
        };
        // K y = M x, so that yᵀ K y needs no product with K.
        let (stiffness, mass) = (products(&images), products(&weighted));
        let inverse = mass.cholesky().and_then(|factor| factor.l().try_inverse()).ok_or(SolveError::NotStable)?;
        let eigen = SymmetricEigen::new(&inverse * stiffness * inverse.transpose());
        let weights = inverse.transpose() * &eigen.eigenvectors;
        let mut order: Vec<usize> = (0..solved.len()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let combined = |&mode: &usize| {
            let mut sum = vec![0.0; solved[0].len()];
            solved.iter().zip(weights.column(mode).iter()).for_each(|(y, weight)| sparse::add(&mut sum, *weight, y));
            sum
        };
        Ok((order.iter().map(|&mode| eigen.eigenvalues[mode]).collect(), order.iter().map(combined).collect()))
    }
}
