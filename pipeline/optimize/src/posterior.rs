//! The posterior of the parameters at the minimum, by Laplace's approximation [seber2003, chapter 2].
//!
//! Near its maximum the posterior is normal with the covariance (JᵀJ)⁻¹ of whitened residuals. Where the residuals are larger than
//! their covariance predicts, it is scaled by χ²/(m − n); it is never narrowed, because a small χ² of few residuals is chance.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::{Covariance, OptimiseError, Residuals};

/// 95 % of a normal distribution lie within so many deviations.
pub const WITHIN_95: f64 = 1.959_964;

/// A standard deviation above this (no unit: parameters are logarithms) counts as uncertain.
pub const UNCERTAIN: f64 = 0.1;

/// One principal axis of the covariance ellipsoid.
#[derive(Debug, Clone, PartialEq)]
pub struct PrincipalAxis {
    /// Standard deviation along it, in units of the parameters.
    pub sigma: f64,
    /// Its unit vector (parameters), the largest component positive.
    pub along: Vec<f64>,
}

impl Residuals {
    /// The covariance of the parameters, for whitened residuals.
    ///
    /// # Errors
    /// [`OptimiseError::Undetermined`] when there are not more residuals than parameters, or JᵀJ is singular.
    pub fn posterior(&self, parameters: usize) -> Result<Covariance, OptimiseError> {
        let by_scatter = self.covariance(parameters)?;
        let widening = by_scatter.residual_variance.max(1.0) / by_scatter.residual_variance;
        Ok(by_scatter.scaled_by(widening))
    }

    /// By how much the parameters at the minimum follow when the residuals change by `change`: −(JᵀJ)⁻¹ Jᵀ change. With the change that one
    /// standard deviation of a parameter kept fixed makes, it is that parameter's part in the uncertainty of the others, as in a
    /// consider covariance \[tapley2004, section 6.2\].
    ///
    /// # Errors
    /// [`OptimiseError::Undetermined`] when JᵀJ is singular.
    pub fn parameter_response(&self, change: &[f64], parameters: usize) -> Result<Vec<f64>, OptimiseError> {
        let changed = Residuals { values: change.to_vec(), jacobian: self.jacobian.clone() };
        let singular =
            || "JᵀJ is singular: the residuals do not change along some direction of the parameters".to_owned();
        changed
            .damped_step(0.0, &vec![true; parameters])
            .ok_or_else(|| OptimiseError::Undetermined { parameters, why: singular() })
    }

    /// χ² over the degrees of freedom: near 1 when the residuals have the covariance that was assumed.
    pub fn reduced_chi_square(&self, parameters: usize) -> f64 {
        2.0 * self.half_sum_of_squares() / self.values.len().saturating_sub(parameters).max(1) as f64
    }
}

impl Covariance {
    /// The principal axes, the least certain first.
    pub(crate) fn principal_axes(&self) -> Vec<PrincipalAxis> {
        let n = self.parameters();
        let decomposition = SymmetricEigen::new(DMatrix::from_fn(n, n, |i, j| self.of(i, j)));
        let axis = |k: usize| {
            let direction: Vec<f64> = decomposition.eigenvectors.column(k).iter().copied().collect();
            let largest = direction.iter().copied().fold(0.0, |l: f64, v| if v.abs() > l.abs() { v } else { l });
            let sigma = decomposition.eigenvalues[k].max(0.0).sqrt();
            PrincipalAxis { sigma, along: direction.iter().map(|v| v * largest.signum()).collect() }
        };
        let mut axes: Vec<PrincipalAxis> = (0..n).map(axis).collect();
        axes.sort_by(|a, b| b.sigma.total_cmp(&a.sigma));
        axes
    }

    /// Which combinations are certain, as text: parameters are logarithms, so an axis is a product of powers.
    pub fn summary(&self, names: &[&str]) -> String {
        let principal_axes = self.principal_axes();
        let (loose, tight): (Vec<&PrincipalAxis>, Vec<&PrincipalAxis>) =
            principal_axes.iter().partition(|d| d.sigma > UNCERTAIN);
        let listed = |axes: &[&PrincipalAxis]| -> Vec<String> {
            axes.iter().map(|d| format!("{} to {:.1} %", power_law(&d.along, names), 100.0 * d.sigma)).collect()
        };
        match (loose.is_empty(), tight.is_empty()) {
            (true, _) => format!("all are certain: {}", listed(&tight).join(", ")),
            (_, true) => format!("none is certain: {}", listed(&loose).join(", ")),
            _ => format!("only {} certain; uncertain: {}", listed(&tight).join(", "), listed(&loose).join(", ")),
        }
    }
}

/// Components below this are left out of the text.
const SHOWN: f64 = 0.15;

/// An axis as text: "body", "the ratio of body and spine", "body^0.8 · spine^-0.6".
fn power_law(along: &[f64], names: &[&str]) -> String {
    let factors: Vec<(&str, f64)> =
        names.iter().copied().zip(along.iter().copied()).filter(|p| p.1.abs() > SHOWN).collect();
    match factors[..] {
        [(name, _)] => name.to_owned(),
        [(a, x), (b, y)] if (x.abs() / y.abs()).ln().abs() < 0.5 => {
            format!("the {} of {a} and {b}", if x * y > 0.0 { "product" } else { "ratio" })
        }
        _ => factors.iter().map(|(name, exponent)| format!("{name}^{exponent:.2}")).collect::<Vec<_>>().join(" · "),
    }
}

/// Residuals of even spacing that count as one independent one: 1 + 2 Σ ρ, summed until the autocorrelation ρ falls below zero.
pub fn integrated_correlation(series: &[f64]) -> f64 {
    let sum_of_squares: f64 = series.iter().map(|x| x * x).sum();
    let correlation_at =
        |lag: usize| series.iter().zip(&series[lag..]).map(|(a, b)| a * b).sum::<f64>() / sum_of_squares;
    1.0 + 2.0 * (1..series.len()).map(correlation_at).take_while(|correlation| *correlation > 0.0).sum::<f64>()
}

/// Principal axes of a `count` × `count` covariance, each as long as its standard deviation: independent errors whose squares add up to it.
pub fn principal_deviations(count: usize, covariance: &dyn Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let decomposition = SymmetricEigen::new(DMatrix::from_fn(count, count, covariance));
    let axis = |k: usize| {
        decomposition.eigenvectors.column(k).iter().map(|v| v * decomposition.eigenvalues[k].max(0.0).sqrt()).collect()
    };
    (0..count).map(axis).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviations_of_a_covariance_give_it_back() {
        let axes = principal_deviations(2, &|i, j| [[0.01, -0.024], [-0.024, 0.09]][i][j]);
        let of = |i: usize, j: usize| axes.iter().map(|a| a[i] * a[j]).sum::<f64>();
        assert!((of(0, 0) - 0.01).abs() < 1e-12 && (of(1, 1) - 0.09).abs() < 1e-12 && (of(0, 1) + 0.024).abs() < 1e-12);
    }

    /// Residuals that depend on the sum of two parameters with one weight and on their difference with another.
    fn residuals(sum: f64, difference: f64) -> Residuals {
        Residuals { values: vec![0.5, -0.5, 0.5], jacobian: vec![sum, sum, difference, -difference, 0.0, 0.0] }
    }

    #[test]
    fn an_alternating_residual_is_independent_and_a_slow_one_is_not() {
        let fast: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(integrated_correlation(&fast), 1.0);
        let slow: Vec<f64> = (0..400).map(|i| (std::f64::consts::TAU * f64::from(i) / 40.0).cos()).collect();
        assert!(integrated_correlation(&slow) > 10.0);
    }

    #[test]
    fn a_change_that_a_parameter_can_undo_is_answered_by_minus_that_parameter() {
        let response = residuals(1.0, 3.0).parameter_response(&[0.2, 0.6, 0.0], 2).unwrap();
        // the changes are those of 0.2 in the first parameter: 0.2 × (1, 3)
        assert!((response[0] + 0.2).abs() < 1e-12 && response[1].abs() < 1e-12, "{response:?}");
    }

    #[test]
    fn an_error_along_a_change_of_the_parameters_widens_them_by_its_square() {
        let alone = residuals(1.0, 3.0).posterior(2).unwrap();
        let widened = alone.clone().with_error(&[0.3, -0.4]);
        let by = |i, j| widened.of(i, j) - alone.of(i, j);
        assert!((by(0, 0) - 0.09).abs() < 1e-12 && (by(0, 1) + 0.12).abs() < 1e-12 && (by(1, 1) - 0.16).abs() < 1e-12);
    }

    #[test]
    fn residuals_of_the_difference_alone_leave_only_the_ratio_certain() {
        let words = residuals(1.0, 100.0).posterior(2).unwrap().summary(&["body", "spine"]);
        assert!(words.starts_with("only the ratio of body and spine to 0.7 % certain"), "{words}");
        assert!(words.contains("uncertain: the product of body and spine"), "{words}");
    }

    #[test]
    fn principal_axes_are_the_axes_of_the_ellipse() {
        let axes = residuals(1.0, 100.0).posterior(2).unwrap().principal_axes();
        // the sum is (1, 1)·θ = √2 along its axis: σ = 1/√2 of one deviation
        assert!((axes[0].sigma - 0.5f64.sqrt()).abs() < 1e-9 && (axes[1].sigma - 0.005 * 2f64.sqrt()).abs() < 1e-9);
        assert!(axes[0].along[0] * axes[0].along[1] > 0.0 && axes[1].along[0] * axes[1].along[1] < 0.0);
    }

    #[test]
    fn a_larger_scatter_than_predicted_widens_and_a_smaller_one_never_narrows() {
        let narrow = residuals(1.0, 1.0).posterior(2).unwrap().sigma(0);
        let scattered = Residuals { values: vec![0.0, 0.0, 3.0], ..residuals(1.0, 1.0) };
        assert!((scattered.posterior(2).unwrap().sigma(0) / narrow - 3.0).abs() < 1e-9);
    }
}
