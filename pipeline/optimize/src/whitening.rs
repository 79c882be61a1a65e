//! Whitening of correlated residuals [seber2003, chapter 2.1.4].
//!
//! With the covariance S = L Lᵀ of the raw residuals r, L⁻¹ r has the covariance I and the Jacobian L⁻¹ J, so ½ ‖L⁻¹ r‖² is the
//! negative log-likelihood. Residuals of different blocks are independent.

use nalgebra::{DMatrix, DVector};

use crate::{OptimiseError, Residuals};

/// Cholesky factors of a block-diagonal covariance.
#[derive(Debug, Clone)]
pub struct Whitening {
    factors: Vec<DMatrix<f64>>,
}

impl Whitening {
    /// From the covariances of independent blocks (each residuals × residuals), in the order of the residuals.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when a block is not square, [`OptimiseError::Undetermined`] when it is not positive definite.
    pub fn new(blocks: &[Vec<f64>]) -> Result<Self, OptimiseError> {
        let factor = |block: &Vec<f64>| {
            let n = block.len().isqrt();
            if n * n != block.len() {
                return Err(OptimiseError::Length { what: "a covariance", found: block.len(), expected: n * n });
            }
            let why = format!("the covariance of a block of {n} residuals is not positive definite");
            let split = DMatrix::from_row_slice(n, n, block).cholesky();
            Ok(split.ok_or(OptimiseError::Undetermined { parameters: 0, why })?.unpack())
        };
        Ok(Self { factors: blocks.iter().map(factor).collect::<Result<_, _>>()? })
    }

    /// ½ ln det S.
    pub fn half_log_determinant(&self) -> f64 {
        self.factors.iter().flat_map(|factor| factor.diagonal().iter().map(|d| d.ln()).collect::<Vec<_>>()).sum()
    }

    /// r and J of the residuals that [`Whitening::apply`] made of them; those beyond its blocks are left out.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when there are fewer than its blocks have.
    pub fn invert(&self, white: &Residuals, parameters: usize) -> Result<Residuals, OptimiseError> {
        let expected: usize = self.factors.iter().map(DMatrix::nrows).sum();
        if white.values.len() < expected || white.jacobian.len() < expected * parameters {
            return Err(OptimiseError::Length { what: "the list of residuals", found: white.values.len(), expected });
        }
        let (mut first, mut values, mut jacobian) = (0, Vec::new(), Vec::new());
        for factor in &self.factors {
            let n = factor.nrows();
            values.extend((factor * DVector::from_column_slice(&white.values[first..first + n])).iter());
            let rows = &white.jacobian[first * parameters..(first + n) * parameters];
            jacobian.extend((factor * DMatrix::from_row_slice(n, parameters, rows)).transpose().iter());
            first += n;
        }
        Ok(Residuals { values, jacobian })
    }

    /// L⁻¹ r and L⁻¹ J.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when the residuals are not as many as the covariances are for.
    pub fn apply(&self, raw: &Residuals, parameters: usize) -> Result<Residuals, OptimiseError> {
        let (found, expected) = (raw.values.len(), self.factors.iter().map(DMatrix::nrows).sum());
        if found != expected || raw.jacobian.len() != found * parameters {
            return Err(OptimiseError::Length { what: "the list of residuals", found, expected });
        }
        let (mut first, mut values, mut jacobian) = (0, Vec::new(), Vec::new());
        for factor in &self.factors {
            let n = factor.nrows();
            let r = solved(factor, DMatrix::from_column_slice(n, 1, &raw.values[first..first + n]));
            let rows = &raw.jacobian[first * parameters..(first + n) * parameters];
            let slopes = solved(factor, DMatrix::from_row_slice(n, parameters, rows));
            values.extend(r.iter());
            jacobian.extend(slopes.transpose().iter());
            first += n;
        }
        Ok(Residuals { values, jacobian })
    }
}

/// L⁻¹ B; the diagonal of a Cholesky factor is positive.
fn solved(factor: &DMatrix<f64>, mut b: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in b.column_iter_mut() {
        let x: DVector<f64> = factor.solve_lower_triangular(&column).unwrap_or_else(|| column.clone_owned());
        column.copy_from(&x);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitened_residuals_have_the_likelihood_of_their_covariance() {
        // S = [[4, 2], [2, 3]]: r S⁻¹ r for r = (1, 2) is (3 − 8 + 16) / 8
        let whitening = Whitening::new(&[vec![4.0, 2.0, 2.0, 3.0], vec![25.0]]).unwrap();
        let raw = Residuals { values: vec![1.0, 2.0, 10.0], jacobian: vec![1.0, 2.0, 10.0] };
        let whitened = whitening.apply(&raw, 1).unwrap();
        assert!((2.0 * whitened.half_sum_of_squares() - (11.0 / 8.0 + 4.0)).abs() < 1e-12);
        assert_eq!(whitened.jacobian, whitened.values);
    }

    #[test]
    fn the_inverse_gives_the_residuals_back_block_by_block() {
        let whitening = Whitening::new(&[vec![4.0, 2.0, 2.0, 3.0], vec![25.0]]).unwrap();
        let raw = Residuals { values: vec![1.0, 2.0, 10.0], jacobian: vec![1.0, 0.5, 2.0, -1.0, 10.0, 3.0] };
        let back = whitening.invert(&whitening.apply(&raw, 2).unwrap(), 2).unwrap();
        let pairs = back.values.iter().zip(&raw.values).chain(back.jacobian.iter().zip(&raw.jacobian));
        pairs.for_each(|(found, exact)| assert!((found - exact).abs() < 1e-12));
        // det S = 8 · 25
        assert!((whitening.half_log_determinant() - 0.5 * 200f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn a_matrix_that_is_not_a_covariance_is_refused() {
        assert!(Whitening::new(&[vec![1.0, 2.0, 2.0, 1.0]]).is_err());
        assert!(Whitening::new(&[vec![1.0, 2.0]]).is_err());
    }
}
