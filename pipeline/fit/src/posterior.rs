//! How sure: what weighed residuals at the minimum say of the parameters around it.
//!
//! Laplace: near its peak the posterior is normal, with the covariance (JᵀJ)⁻¹ of residuals of one deviation each. Where the
//! residuals are larger than their covariance foretold, it is widened by χ²/(m − n), never narrowed.      [seber2003], chapter 2
//!
//! Stands on: least squares, nalgebra. Never knows: what a parameter means; it is told their names.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::{Covariance, FitError, Residuals};

/// 95 % of a normal distribution lie within so many deviations.
pub const WITHIN_95: f64 = 1.959_964;

/// A deviation above this (no unit: parameters are logarithms) is not certain.
pub const UNCERTAIN: f64 = 0.1;

/// One axis of the ellipsoid of likely parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Standard deviation along it, in units of the parameters.
    pub sigma: f64,
    /// Its unit vector (parameters), the largest component positive.
    pub along: Vec<f64>,
}

impl Residuals {
    /// The covariance of the parameters, where each residual is in its own deviations.
    ///
    /// # Errors
    /// [`FitError::Undetermined`] when there are not more residuals than parameters, or JᵀJ is singular.
    pub fn posterior(&self, parameters: usize) -> Result<Covariance, FitError> {
        let by_scatter = self.covariance(parameters)?;
        let widened = by_scatter.residual_variance.max(1.0) / by_scatter.residual_variance;
        Ok(by_scatter.scaled(widened))
    }

    /// χ² of the residuals over the freedoms they leave: near 1 when the covariance told the truth.
    pub fn reduced_chi_square(&self, parameters: usize) -> f64 {
        2.0 * self.half_square() / self.values.len().saturating_sub(parameters).max(1) as f64
    }
}

impl Covariance {
    /// The axes of the ellipsoid, the least certain first.
    pub fn directions(&self) -> Vec<Direction> {
        let n = self.parameters();
        let split = SymmetricEigen::new(DMatrix::from_fn(n, n, |i, j| self.of(i, j)));
        let axis = |k: usize| {
            let along: Vec<f64> = split.eigenvectors.column(k).iter().copied().collect();
            let largest = along.iter().copied().fold(0.0, |l: f64, v| if v.abs() > l.abs() { v } else { l });
            let sigma = split.eigenvalues[k].max(0.0).sqrt();
            Direction { sigma, along: along.iter().map(|v| v * largest.signum()).collect() }
        };
        let mut all: Vec<Direction> = (0..n).map(axis).collect();
        all.sort_by(|a, b| b.sigma.total_cmp(&a.sigma));
        all
    }

    /// What is certain, in words: parameters are logarithms, so a direction is a product of powers.
    pub fn in_words(&self, names: &[&str]) -> String {
        let directions = self.directions();
        let (loose, tight): (Vec<&Direction>, Vec<&Direction>) = directions.iter().partition(|d| d.sigma > UNCERTAIN);
        let said = |all: &[&Direction]| -> Vec<String> {
            all.iter().map(|d| format!("{} to {:.1} %", power(&d.along, names), 100.0 * d.sigma)).collect()
        };
        match (loose.is_empty(), tight.is_empty()) {
            (true, _) => format!("all are certain: {}", said(&tight).join(", ")),
            (_, true) => format!("none is certain: {}", said(&loose).join(", ")),
            _ => format!("only {} certain; uncertain: {}", said(&tight).join(", "), said(&loose).join(", ")),
        }
    }
}

/// The least component of a direction that is worth a word.
const WORTH: f64 = 0.15;

/// A direction as a person says it: "body", "the ratio of body and spine", "body^0.8 · spine^-0.6".
fn power(along: &[f64], names: &[&str]) -> String {
    let parts: Vec<(&str, f64)> =
        names.iter().copied().zip(along.iter().copied()).filter(|p| p.1.abs() > WORTH).collect();
    match parts[..] {
        [(one, _)] => one.to_owned(),
        [(a, x), (b, y)] if (x.abs() / y.abs()).ln().abs() < 0.5 => {
            format!("the {} of {a} and {b}", if x * y > 0.0 { "product" } else { "ratio" })
        }
        _ => parts.iter().map(|(name, by)| format!("{name}^{by:.2}")).collect::<Vec<_>>().join(" · "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals that feel the sum of two parameters with one weight and their difference with another.
    fn felt(sum: f64, difference: f64) -> Residuals {
        Residuals { values: vec![0.5, -0.5, 0.5], jacobian: vec![sum, sum, difference, -difference, 0.0, 0.0] }
    }

    #[test]
    fn what_only_the_difference_feels_leaves_only_the_ratio_certain() {
        let words = felt(1.0, 100.0).posterior(2).unwrap().in_words(&["body", "spine"]);
        assert!(words.starts_with("only the ratio of body and spine to 0.7 % certain"), "{words}");
        assert!(words.contains("uncertain: the product of body and spine"), "{words}");
    }

    #[test]
    fn directions_are_the_axes_of_the_ellipse() {
        let axes = felt(1.0, 100.0).posterior(2).unwrap().directions();
        // the sum is felt as (1, 1)·θ = √2 along its axis: σ = 1/√2 of one deviation
        assert!((axes[0].sigma - 0.5f64.sqrt()).abs() < 1e-9 && (axes[1].sigma - 0.005 * 2f64.sqrt()).abs() < 1e-9);
        assert!(axes[0].along[0] * axes[0].along[1] > 0.0 && axes[1].along[0] * axes[1].along[1] < 0.0);
    }

    #[test]
    fn scatter_beyond_the_foretold_widens_and_less_never_narrows() {
        let narrow = felt(1.0, 1.0).posterior(2).unwrap().sigma(0);
        let wild = Residuals { values: vec![0.0, 0.0, 3.0], ..felt(1.0, 1.0) };
        assert!((wild.posterior(2).unwrap().sigma(0) / narrow - 3.0).abs() < 1e-9);
    }
}
