//! Fitted laws of a report in SI units, for programs that use them: mean and covariance of the parameters.

use nalgebra::{DMatrix, DVector};

use super::Report;
use super::ladder::{LawResult, supported_law};

/// A law fitted to all recordings that are marked so.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedLaw {
    /// Its name in the table.
    pub name: &'static str,
    /// Name and SI unit of each parameter.
    pub parameters: Vec<(&'static str, &'static str)>,
    /// In SI units.
    pub mean: Vec<f64>,
    /// In SI units, linearised at the mean.
    pub covariance: DMatrix<f64>,
    /// Bayes' information criterion, relative to the best law's.
    pub criterion: f64,
    /// Whether the recordings support it: the simplest law within the uncertainty of the best one.
    pub supported: bool,
}

impl Report {
    /// Every law of the ladder, from the simplest to the richest.
    pub fn laws(&self) -> Vec<FittedLaw> {
        let best = supported_law(&self.results);
        self.results.iter().enumerate().map(|(n, result)| self.fitted_law(result, n == best)).collect()
    }

    fn fitted_law(&self, result: &LawResult, supported: bool) -> FittedLaw {
        let fitted = &result.joint.fitted;
        let scales: Vec<_> = fitted.law.parameters.iter().map(|quantity| quantity.scale(self.page.range)).collect();
        // The search runs in the logarithm of positive parameters: dθ = θ d(ln θ).
        let slope = |(scale, value): (&super::laws::Scale, &f64)| if scale.logarithmic { *value } else { 1.0 };
        let slopes = DMatrix::from_diagonal(&DVector::from_vec(scales.iter().zip(&fitted.values).map(slope).collect()));
        let count = scales.len();
        let law_covariance = fitted.covariance.view((0, 0), (count, count));
        FittedLaw {
            name: fitted.law.name,
            parameters: scales.iter().map(|scale| (scale.name, scale.unit)).collect(),
            mean: fitted.values.clone(),
            covariance: &slopes * law_covariance * &slopes,
            criterion: result.criterion,
            supported,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_of_positive_parameters_are_in_their_units() {
        let laws = super::super::testing::report().laws();
        let names: Vec<_> = laws.iter().map(|law| (law.name, law.supported, law.criterion)).collect();
        assert_eq!(names, [("elastic_beta", false, 7.25), ("springpot_yeoh", true, 0.0)]);
        assert_eq!(laws[0].parameters, [("youngs_modulus", "Pa"), ("stiffness_damping", "s")]);
        // 2 % of 100 kPa, 120 % of 2 ms, and a correlation of one half
        let should =
            DMatrix::from_row_slice(2, 2, &[2e3 * 2e3, 0.5 * 2e3 * 2.4e-3, 0.5 * 2e3 * 2.4e-3, 2.4e-3 * 2.4e-3]);
        assert!(laws[0].covariance.iter().zip(should.iter()).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        // C₂₀/C₁₀ and the exponent are searched as they are
        let deviations: Vec<f64> = laws[1].covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        for (found, should) in deviations.iter().zip([1e4, 5e-3, 0.03, 0.25]) {
            assert!((found / should - 1.0).abs() < 1e-12, "{deviations:?}");
        }
        assert_eq!(laws[1].mean, [2e5, 0.05, 0.3, -0.5]);
    }
}
