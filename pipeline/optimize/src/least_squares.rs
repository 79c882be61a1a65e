//! Nonlinear least squares at one point: the loss, its gradient, a damped step and the covariance of the parameters.
//!
//! With residuals r(θ) of one common standard deviation σ and J = ∂r/∂θ, the loss is ½ ‖r‖² and its gradient Jᵀr; JᵀJ is the
//! Gauss–Newton approximation of its Hessian.

use nalgebra::{DMatrix, DVector};

use crate::OptimiseError;
use crate::levenberg_marquardt::{self, Scaling};

/// Residuals and their Jacobian at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Residuals {
    /// Simulated less measured, each divided by its weight so that all have one standard deviation.
    pub values: Vec<f64>,
    /// ∂residual/∂parameter: residuals × parameters, row after row.
    pub jacobian: Vec<f64>,
}

impl Residuals {
    /// ½ ‖r‖², what least squares minimises.
    pub fn half_sum_of_squares(&self) -> f64 {
        0.5 * self.values.iter().map(|r| r * r).sum::<f64>()
    }

    /// Jᵀr, the gradient of ½ ‖r‖² (parameters).
    pub fn gradient(&self, parameters: usize) -> Vec<f64> {
        self.gradient_vector(parameters).as_slice().to_vec()
    }

    fn gradient_vector(&self, parameters: usize) -> DVector<f64> {
        self.jacobian_matrix(parameters).tr_mul(&DVector::from_column_slice(&self.values))
    }

    fn jacobian_matrix(&self, parameters: usize) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.values.len(), parameters, &self.jacobian)
    }

    /// The Levenberg–Marquardt step in the free parameters.
    ///
    /// (JᵀJ + λ diag JᵀJ) δ = −Jᵀr      \[marquardt1963\]
    ///
    /// Returns δ (parameters), zero where `free` is false, or `None` when the matrix is singular.
    #[allow(non_snake_case)]
    pub(crate) fn damped_step(&self, damping: f64, free: &[bool]) -> Option<Vec<f64>> {
        let axes: Vec<usize> = (0..free.len()).filter(|&i| free[i]).collect();
        let J = self.jacobian_matrix(free.len()).select_columns(&axes);
        let right_side = -J.tr_mul(&DVector::from_column_slice(&self.values));
        let solution = levenberg_marquardt::damped_step(J.tr_mul(&J), &right_side, damping, Scaling::Relative)?;
        let mut step = vec![0.0; free.len()];
        for (position, axis) in axes.iter().enumerate() {
            step[*axis] = solution[position];
        }
        Some(step)
    }

    /// The reduction of ½ ‖r‖² that the linear model predicts for a step: −gᵀδ − ½ ‖Jδ‖².
    pub(crate) fn predicted_reduction(&self, step: &[f64]) -> f64 {
        let step = DVector::from_column_slice(step);
        let residual_change = self.jacobian_matrix(step.len()) * &step;
        -self.gradient_vector(step.len()).dot(&step) - 0.5 * residual_change.norm_squared()
    }

    /// The covariance of the parameters at the minimum.
    ///
    /// Σ = σ² (JᵀJ)⁻¹,  σ² = ‖r‖² / (m − n)      \[seber2003\], chapter 2
    ///
    /// # Errors
    /// [`OptimiseError::Undetermined`] when there are not more residuals than parameters, or JᵀJ is singular.
    #[allow(non_snake_case)]
    pub fn covariance(&self, parameters: usize) -> Result<Covariance, OptimiseError> {
        let residuals = self.values.len();
        if residuals <= parameters {
            let reason = format!("there are {residuals} residuals; more than {parameters} are needed");
            return Err(OptimiseError::Undetermined { parameters, why: reason });
        }
        let variance = 2.0 * self.half_sum_of_squares() / (residuals - parameters) as f64;
        let J = self.jacobian_matrix(parameters);
        let Some(inverse) = J.tr_mul(&J).cholesky().map(|c| c.inverse()) else {
            let reason =
                "JᵀJ is singular: the residuals do not change along some direction of the parameters".to_owned();
            return Err(OptimiseError::Undetermined { parameters, why: reason });
        };
        Ok(Covariance { parameters, values: (inverse * variance).as_slice().to_vec(), residual_variance: variance })
    }
}

/// A covariance of the parameters, in the square of their units.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    parameters: usize,
    values: Vec<f64>,
    /// σ² of the residuals.
    pub residual_variance: f64,
}

impl Covariance {
    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// The covariance times a factor.
    pub(crate) fn scaled_by(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v *= factor);
        self
    }

    /// The sum of independent errors, each given by the move of all parameters by one deviation of it.
    pub fn of_errors(parameters: usize, errors: &[Vec<f64>]) -> Self {
        let zero = Self { parameters, values: vec![0.0; parameters * parameters], residual_variance: 1.0 };
        errors.iter().fold(zero, |sum, error| sum.with_error(error))
    }

    /// With an independent error of one size along `error`, the move of each parameter by one deviation of it: C + error errorᵀ.
    #[must_use]
    pub fn with_error(mut self, error: &[f64]) -> Self {
        let n = self.parameters;
        self.values.iter_mut().enumerate().for_each(|(i, v)| *v += error[i / n] * error[i % n]);
        self
    }

    /// The covariance of the first `count` parameters, whatever the others are.
    #[must_use]
    pub fn marginal(&self, count: usize) -> Self {
        let values = (0..count * count).map(|i| self.of(i / count, i % count)).collect();
        Self { parameters: count, values, residual_variance: self.residual_variance }
    }

    /// Covariance of two parameters.
    pub fn of(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.parameters + j]
    }

    /// Standard deviation of a parameter.
    pub fn sigma(&self, i: usize) -> f64 {
        self.of(i, i).sqrt()
    }

    /// Correlation of two parameters, −1 to 1.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        self.of(i, j) / (self.sigma(i) * self.sigma(j))
    }
}
