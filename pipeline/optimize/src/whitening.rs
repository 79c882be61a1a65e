//! Whitening of correlated residuals [seber2003, chapter 2.1.4].
//!
//! With a root M of the covariance S = M Mᵀ of the raw residuals r, M⁻¹ r has the covariance I and the Jacobian M⁻¹ J, so ½ ‖M⁻¹ r‖² is the
//! negative log-likelihood. Residuals of different blocks are independent, but for causes that they have in common:
//!
//!   S = L Lᵀ + U Uᵀ,  M = L (I + V Vᵀ)^½,  V = L⁻¹ U
//!
//! with the Cholesky factors L of the blocks and a column of U for each cause. With VᵀV = Q Λ Qᵀ, a function f of I + V Vᵀ is
//! f(1) I + V Q (f(1 + Λ) − f(1)) Λ⁻¹ Qᵀ Vᵀ: common causes cost no factor of the whole.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::{OptimiseError, Residuals};

/// A root of a covariance of blocks with common causes.
#[derive(Debug, Clone)]
pub struct Whitening {
    /// L of each block.
    factors: Vec<DMatrix<f64>>,
    /// V Q, residuals × causes.
    common: DMatrix<f64>,
    /// Λ.
    squares: DVector<f64>,
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
            let reason = format!("the covariance of a block of {n} residuals is not positive definite");
            let decomposition = DMatrix::from_row_slice(n, n, block).cholesky();
            Ok(decomposition.ok_or(OptimiseError::Undetermined { parameters: 0, why: reason })?.unpack())
        };
        let factors: Vec<DMatrix<f64>> = blocks.iter().map(factor).collect::<Result<_, _>>()?;
        let residuals = factors.iter().map(DMatrix::nrows).sum();
        Ok(Self { factors, common: DMatrix::zeros(residuals, 0), squares: DVector::zeros(0) })
    }

    /// With causes that the blocks have in common: by how much each residual follows one standard deviation of each.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when a cause has not as many residuals as the blocks.
    pub fn with_common(self, causes: &[Vec<f64>]) -> Result<Self, OptimiseError> {
        let expected = self.common.nrows();
        if let Some(cause) = causes.iter().find(|cause| cause.len() != expected) {
            return Err(OptimiseError::Length { what: "a common cause", found: cause.len(), expected });
        }
        let columns = DMatrix::from_fn(expected, causes.len(), |i, k| causes[k][i]);
        let whitened = self.for_each_block(&columns, solved_lower);
        let decomposition = SymmetricEigen::new(whitened.tr_mul(&whitened));
        Ok(Self {
            common: whitened * &decomposition.eigenvectors,
            squares: decomposition.eigenvalues.map(|square| square.max(0.0)),
            ..self
        })
    }

    /// `operation` each factor and the rows of its block.
    fn for_each_block(
        &self,
        rows: &DMatrix<f64>,
        operation: fn(&DMatrix<f64>, DMatrix<f64>) -> DMatrix<f64>,
    ) -> DMatrix<f64> {
        let (mut first, mut result) = (0, rows.clone());
        for factor in &self.factors {
            let n = factor.nrows();
            let block_result = operation(factor, rows.rows(first, n).into_owned());
            result.rows_mut(first, n).copy_from(&block_result);
            first += n;
        }
        result
    }

    /// (I + V Vᵀ)^`power` of rows.
    fn common_power(&self, rows: &DMatrix<f64>, power: f64) -> DMatrix<f64> {
        let projected = self.common.tr_mul(rows);
        let gain = |square: f64| if square > SMALL { ((1.0 + square).powf(power) - 1.0) / square } else { power };
        let scaled = DMatrix::from_diagonal(&self.squares.map(gain)) * projected;
        rows + &self.common * scaled
    }

    /// ½ ln det S.
    pub fn half_log_determinant(&self) -> f64 {
        let blocks: f64 = self.factors.iter().map(|factor| factor.diagonal().map(f64::ln).sum()).sum();
        blocks + 0.5 * self.squares.iter().map(|square| square.ln_1p()).sum::<f64>()
    }

    /// r and J of the residuals that [`Whitening::apply`] made of them; those beyond its blocks are left out.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when there are fewer than its blocks have.
    pub fn invert(&self, white: &Residuals, parameters: usize) -> Result<Residuals, OptimiseError> {
        let expected = self.common.nrows();
        if white.values.len() < expected || white.jacobian.len() < expected * parameters {
            return Err(OptimiseError::Length { what: "the list of residuals", found: white.values.len(), expected });
        }
        let root =
            |rows: DMatrix<f64>| self.for_each_block(&self.common_power(&rows, 0.5), |factor, block| factor * block);
        Ok(self.transform_rows(white, parameters, root))
    }

    /// M⁻¹ r and M⁻¹ J.
    ///
    /// # Errors
    /// [`OptimiseError::Length`] when the residuals are not as many as the covariances are for.
    pub fn apply(&self, raw: &Residuals, parameters: usize) -> Result<Residuals, OptimiseError> {
        let (found, expected) = (raw.values.len(), self.common.nrows());
        if found != expected || raw.jacobian.len() != found * parameters {
            return Err(OptimiseError::Length { what: "the list of residuals", found, expected });
        }
        Ok(self
            .transform_rows(raw, parameters, |rows| self.common_power(&self.for_each_block(&rows, solved_lower), -0.5)))
    }

    /// `transform` r and J, each as rows.
    fn transform_rows(
        &self,
        residuals: &Residuals,
        columns: usize,
        transform: impl Fn(DMatrix<f64>) -> DMatrix<f64>,
    ) -> Residuals {
        let rows = self.common.nrows();
        let values = transform(DMatrix::from_column_slice(rows, 1, &residuals.values[..rows]));
        let jacobian = transform(DMatrix::from_row_slice(rows, columns, &residuals.jacobian[..rows * columns]));
        Residuals { values: values.iter().copied().collect(), jacobian: jacobian.transpose().iter().copied().collect() }
    }
}

/// Square of a cause, in deviations of the blocks, below which the power is its slope.
const SMALL: f64 = 1e-9;

/// L⁻¹ B; the diagonal of a Cholesky factor is positive.
fn solved_lower(factor: &DMatrix<f64>, mut b: DMatrix<f64>) -> DMatrix<f64> {
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
    fn a_common_cause_is_that_of_the_whole_covariance() {
        let (blocks, causes) = ([vec![4.0, 2.0, 2.0, 3.0], vec![25.0]], [vec![1.0, -2.0, 3.0], vec![0.5, 0.0, 1.0]]);
        let whole: Vec<f64> = {
            let block = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 25.0]);
            let common = DMatrix::from_fn(3, 2, |i, k| causes[k][i]);
            (block + &common * common.transpose()).iter().copied().collect()
        };
        let [low_rank, dense] =
            [Whitening::new(&blocks).unwrap().with_common(&causes).unwrap(), Whitening::new(&[whole]).unwrap()];
        let raw = Residuals { values: vec![1.0, 2.0, -10.0], jacobian: vec![1.0, 0.5, 2.0, -1.0, 10.0, 3.0] };
        let [a, b] = [&low_rank, &dense].map(|of| of.apply(&raw, 2).unwrap());
        assert!((a.half_sum_of_squares() - b.half_sum_of_squares()).abs() < 1e-12);
        let product = |of: &Residuals| of.jacobian.chunks(2).map(|row| row[0] * row[1]).sum::<f64>();
        assert!((product(&a) - product(&b)).abs() < 1e-12);
        assert!((low_rank.half_log_determinant() - dense.half_log_determinant()).abs() < 1e-12);
        let back = low_rank.invert(&a, 2).unwrap();
        assert!(back.values.iter().zip(&raw.values).all(|(found, exact)| (found - exact).abs() < 1e-12));
        assert!(Whitening::new(&blocks).unwrap().with_common(&[vec![1.0]]).is_err());
    }

    #[test]
    fn a_matrix_that_is_not_a_covariance_is_refused() {
        assert!(Whitening::new(&[vec![1.0, 2.0, 2.0, 1.0]]).is_err());
        assert!(Whitening::new(&[vec![1.0, 2.0]]).is_err());
    }
}
