//! An identified spectrum: its branches, their covariance, and how they follow the moduli.
//!
//! The vibration after a change of the command shows the storage modulus at its frequency, a product of a held modulus and of the relaxation.
//! A modulus that is identified too high therefore comes with a relaxation that is too weak. The two are not independent, and what is
//! predicted from both is more certain than if they were: the response of the strengths to the moduli belongs to the result.

use fem::{Branch, Relaxation};
use optimize::posterior::principal_deviations;
use serde::{Deserialize, Serialize};
use si::{Hertz, Second};

use diagnostics::{Diagnostic, Result};

/// One Maxwell branch with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedBranch {
    /// Relaxation time, s; set, not identified.
    pub time_s: Second,
    /// Modulus of the branch over the long-term modulus, no unit.
    pub strength: f64,
    /// Standard deviation of the logarithm of the strength, the moduli given.
    pub sigma: f64,
    /// That standard deviation over the prior's: near 1 where the films do not determine the branch.
    pub over_prior: f64,
}

/// The relaxation spectrum of a silicone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedSpectrum {
    /// The branches, the fastest first.
    pub branches: Vec<IdentifiedBranch>,
    /// Correlation of the logarithms of their strengths, row after row.
    pub correlation: Vec<f64>,
    /// Time after loading to which the identified Young's moduli belong, s.
    pub modulus_time_s: Second,
    /// By how much the logarithm of each strength follows that of each modulus: moduli × branches.
    pub modulus_response: Vec<Vec<f64>>,
}

/// Step of a strength's logarithm in a difference quotient.
const NUDGE: f64 = 1e-4;

impl IdentifiedSpectrum {
    /// What is wrong with a spectrum that was read from a file: lists that do not have an entry for each branch, or each pair of them.
    pub fn fault(&self) -> Option<String> {
        let (branches, pairs) = (self.branches.len(), self.correlation.len());
        if pairs != branches * branches {
            return Some(format!("{branches} branches have {pairs} correlations"));
        }
        let response = self.modulus_response.iter().find(|response| response.len() != branches)?;
        Some(format!("a modulus has {} responses of {branches} branches", response.len()))
    }

    /// The relaxation.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a branch is one that no solid can have.
    pub fn relaxation(&self) -> Result<Relaxation> {
        let branches: Vec<Branch> =
            self.branches.iter().map(|b| Branch { strength: b.strength, time: b.time_s }).collect();
        Relaxation::maxwell(&branches).map_err(Diagnostic::from)
    }

    /// Storage modulus over the modulus at the stated time, and loss factor, at a frequency (Hz).
    ///
    /// # Errors
    /// As [`IdentifiedSpectrum::relaxation`].
    pub fn at(&self, frequency: Hertz) -> Result<[f64; 2]> {
        Ok(dynamic_modulus(&self.relaxation()?, frequency, self.modulus_time_s))
    }

    /// Standard deviations of [`IdentifiedSpectrum::at`], from the covariance of the strengths.
    ///
    /// # Errors
    /// As [`IdentifiedSpectrum::relaxation`].
    pub fn sigma_at(&self, frequency: Hertz) -> Result<[f64; 2]> {
        let nominal = self.at(frequency)?;
        let slope = |k: usize| {
            let mut nudge = vec![0.0; self.branches.len()];
            nudge[k] = NUDGE;
            let perturbed = self.shifted_spectrum(&nudge).at(frequency)?;
            Ok([0, 1].map(|q| (perturbed[q] - nominal[q]) / NUDGE))
        };
        let slopes = (0..self.branches.len()).map(slope).collect::<Result<Vec<_>>>()?;
        let variance = |q: usize| {
            let pairs = (0..slopes.len()).flat_map(|i| (0..slopes.len()).map(move |j| (i, j)));
            pairs.map(|(i, j)| slopes[i][q] * self.strength_covariance(i, j) * slopes[j][q]).sum::<f64>()
        };
        Ok([0, 1].map(|q| variance(q).max(0.0).sqrt()))
    }

    /// The spectrum that would have been identified with the logarithms of the moduli off by `moduli`.
    pub fn following(&self, moduli: &[f64]) -> Self {
        let shift = |k: usize| {
            moduli.iter().zip(&self.modulus_response).map(|(deviation, response)| deviation * response[k]).sum()
        };
        self.shifted_spectrum(&(0..self.branches.len()).map(shift).collect::<Vec<_>>())
    }

    /// The spectrum off by `part` of a standard deviation along each principal axis of the strengths' covariance.
    pub fn deviations(&self, part: f64) -> impl Iterator<Item = Self> + '_ {
        let axes = principal_deviations(self.branches.len(), &|i, j| part * part * self.strength_covariance(i, j));
        axes.into_iter().map(|deviation| self.shifted_spectrum(&deviation))
    }

    /// Of the logarithms of two strengths, the moduli given.
    fn strength_covariance(&self, i: usize, j: usize) -> f64 {
        let count = self.branches.len();
        self.branches[i].sigma * self.branches[j].sigma * self.correlation[i * count + j]
    }

    /// With the logarithms of the strengths off by `log_factors`.
    fn shifted_spectrum(&self, log_factors: &[f64]) -> Self {
        let mut shifted = self.clone();
        shifted
            .branches
            .iter_mut()
            .zip(log_factors)
            .for_each(|(branch, log_factor)| branch.strength *= log_factor.exp());
        shifted
    }
}

/// Storage modulus over the modulus at a time after loading (s), and loss factor, at a frequency (Hz).
pub fn dynamic_modulus(relaxation: &Relaxation, frequency: Hertz, held: Second) -> [f64; 2] {
    let [storage, loss] = relaxation.complex_modulus(std::f64::consts::TAU * frequency);
    [storage / relaxation.modulus(held), loss / storage]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole() -> IdentifiedSpectrum {
        let branch = |time_s, strength| IdentifiedBranch { time_s, strength, sigma: 0.1, over_prior: 0.1 };
        IdentifiedSpectrum {
            branches: vec![branch(0.01, 0.2), branch(1.0, 0.1)],
            correlation: vec![1.0, 0.3, 0.3, 1.0],
            modulus_time_s: 3.0,
            modulus_response: vec![vec![-2.0, 0.5], vec![-1.0, 0.0]],
        }
    }

    #[test]
    fn the_deviation_of_the_loss_is_that_of_the_branches() {
        let mut one = whole();
        one.branches.truncate(1);
        one.correlation = vec![1.0];
        // with one branch of 10 ms, E at 3 s is the long-term modulus: storage and loss follow from g by hand
        let (g, x) = (0.2, std::f64::consts::TAU * 8.0 * 0.01);
        let (storage, loss) = (g * x * x / (1.0 + x * x), g * x / (1.0 + x * x));
        let slope = loss / (1.0 + storage) - loss * storage / (1.0 + storage).powi(2);
        let [of_storage, of_loss] = one.sigma_at(8.0).unwrap();
        assert!((of_storage / (0.1 * storage) - 1.0).abs() < 1e-3, "{of_storage}");
        assert!((of_loss / (0.1 * slope) - 1.0).abs() < 1e-3, "{of_loss} {slope}");
    }

    #[test]
    fn a_fast_motion_meets_the_sum_of_all_branches_and_loses_nothing() {
        let [storage, loss] = whole().at(1e6).unwrap();
        assert!((storage - 1.3 / (1.0 + 0.1 * (-3f64).exp())).abs() < 1e-6 && loss < 1e-3);
    }

    #[test]
    fn strengths_follow_every_modulus() {
        let followed = whole().following(&[0.01, 0.02]);
        let logarithm = |k: usize| (followed.branches[k].strength / whole().branches[k].strength).ln();
        assert!((logarithm(0) + 0.04).abs() < 1e-12 && (logarithm(1) - 0.005).abs() < 1e-12);
    }

    #[test]
    fn the_squares_of_all_deviations_are_the_covariance() {
        let here = whole();
        let off = |k: usize| -> Vec<f64> {
            here.deviations(1.0).map(|d| (d.branches[k].strength / here.branches[k].strength).ln()).collect()
        };
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (first, second) = (off(0), off(1));
        assert!((product(&first, &first) - 0.01).abs() < 1e-9 && (product(&first, &second) - 0.003).abs() < 1e-9);
    }
}
