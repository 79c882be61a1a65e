//! Relaxation: the spectrum of a specimen's silicone, from the transients of its staircases.

use fem::Branch;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Second};

use crate::records::Identified;
use crate::subject::Specimen;
use diagnostics::{Diagnostic, Result};
use sysid::relaxation::Transient;
use sysid::{Model, Viscoelastic};
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// One Maxwell branch with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedBranch {
    /// Relaxation time, s; set, not identified.
    pub time_s: Second,
    /// Modulus of the branch over the long-term modulus, no unit.
    pub strength: f64,
    /// Standard deviation of the logarithm of the strength.
    pub sigma: f64,
    /// That standard deviation over the prior's: near 1 where the films do not determine the branch.
    pub over_prior: f64,
}

/// The relaxation spectrum of a specimen's silicone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Relaxation {
    /// The branches, the fastest first.
    pub branches: Vec<IdentifiedBranch>,
    /// Correlation of the logarithms of their strengths, row after row.
    pub correlation: Vec<f64>,
    /// Time after loading to which the identified Young's modulus belongs, s.
    pub modulus_time_s: Second,
    /// Root mean square error of all windows, each about its mean, m.
    pub rmse_m: Metre,
    /// The same of the elastic model without relaxation, m.
    pub elastic_rmse_m: Metre,
    /// Correlation time of the residuals, s.
    pub correlation_time_s: Second,
    /// The windows of the film that is shown.
    pub transients: Vec<Transient>,
}

/// Frequencies at which storage modulus and loss factor are reported, Hz.
pub(crate) const REPORTED: [Hertz; 3] = [1.0, 2.0, 8.0];

impl Relaxation {
    /// The spectrum.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a branch is one that no solid can have.
    pub(crate) fn spectrum(&self) -> Result<fem::Relaxation> {
        let branches: Vec<Branch> =
            self.branches.iter().map(|b| Branch { strength: b.strength, time: b.time_s }).collect();
        fem::Relaxation::maxwell(&branches).map_err(Diagnostic::from)
    }

    /// The constants of a model with this silicone and the moduli of `identified`.
    ///
    /// # Errors
    /// As [`Relaxation::spectrum`].
    pub(crate) fn silicone(&self, model: &Model, identified: &Identified) -> Result<Viscoelastic> {
        let held = identified.elastic(model);
        Ok(Viscoelastic::measured_at(self.modulus_time_s, held, self.spectrum()?))
    }

    /// Storage modulus over the modulus at the stated time, and loss factor, at a frequency (Hz).
    pub(crate) fn at(&self, frequency: Hertz) -> Result<[f64; 2]> {
        Ok(dynamic(&self.spectrum()?, frequency, self.modulus_time_s))
    }
}

/// Step of a strength's logarithm in a difference quotient.
const NUDGE: f64 = 1e-4;

impl Relaxation {
    /// Standard deviations of [`Relaxation::at`], from the covariance of the strengths.
    ///
    /// # Errors
    /// As [`Relaxation::spectrum`].
    pub(crate) fn sigma_at(&self, frequency: Hertz) -> Result<[f64; 2]> {
        let count = self.branches.len();
        let here = self.at(frequency)?;
        let mut slopes = Vec::with_capacity(count);
        for k in 0..count {
            let mut other = self.clone();
            other.branches[k].strength *= NUDGE.exp();
            let there = other.at(frequency)?;
            slopes.push([0, 1].map(|q| self.branches[k].sigma * (there[q] - here[q]) / NUDGE));
        }
        let variance = |q: usize| {
            let pairs = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
            pairs.map(|(i, j)| slopes[i][q] * self.correlation[i * count + j] * slopes[j][q]).sum::<f64>()
        };
        Ok([0, 1].map(|q| variance(q).max(0.0).sqrt()))
    }
}

/// Storage modulus over the modulus at a time after loading (s), and loss factor, at a frequency (Hz).
pub(crate) fn dynamic(spectrum: &fem::Relaxation, frequency: Hertz, held: Second) -> [f64; 2] {
    let [storage, loss] = spectrum.complex_modulus(std::f64::consts::TAU * frequency);
    [storage / spectrum.modulus(held), loss / storage]
}

impl Record for Relaxation {
    type Of = Specimen;
    const STAGE: &'static str = "relaxation";

    fn pack(&self) -> std::result::Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("relaxation.json", self)
    }

    fn unpack(files: &RecordFiles) -> std::result::Result<Self, RecordError> {
        files.read_scalars("relaxation.json")
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |what: &str| format!("relaxation.{subject}.{what}");
        let mut metrics = vec![
            Metric::new(id("rmse_mm"), 1e3 * self.rmse_m, "mm"),
            Metric::new(id("elastic_rmse_mm"), 1e3 * self.elastic_rmse_m, "mm"),
            Metric::new(id("modulus_time_s"), self.modulus_time_s, "s"),
        ];
        for frequency in REPORTED {
            let Ok([storage, loss]) = self.at(frequency) else { continue };
            metrics.push(Metric::new(id(&format!("storage_ratio_{frequency}hz")), storage, ""));
            metrics.push(Metric::new(id(&format!("loss_factor_{frequency}hz")), loss, ""));
        }
        metrics
    }

    fn summary(&self) -> String {
        let branch = |b: &IdentifiedBranch| {
            let note = if b.over_prior > UNDETERMINED { " (prior)" } else { "" };
            format!("{:.3} at {:.1e} s{note}", b.strength, b.time_s)
        };
        let branches: Vec<String> = self.branches.iter().map(branch).collect();
        let (rmse, elastic) = (1e3 * self.rmse_m, 1e3 * self.elastic_rmse_m);
        format!(
            "branches {}; moduli at {:.1} s; RMSE {rmse:.3} mm, elastic {elastic:.3}",
            branches.join(", "),
            self.modulus_time_s
        )
    }
}

/// A branch whose deviation is above this share of the prior's is called undetermined.
const UNDETERMINED: f64 = 0.7;

#[cfg(test)]
mod tests {
    use super::*;

    fn whole() -> Relaxation {
        let branch = |time_s, strength| IdentifiedBranch { time_s, strength, sigma: 0.1, over_prior: 0.1 };
        Relaxation {
            branches: vec![branch(0.01, 0.2), branch(1.0, 0.1)],
            correlation: vec![1.0, 0.3, 0.3, 1.0],
            modulus_time_s: 3.0,
            rmse_m: 1e-4,
            elastic_rmse_m: 1e-3,
            correlation_time_s: 0.1,
            transients: vec![Transient {
                time_s: vec![0.0, 0.1],
                measured_m: vec![0.0, 1e-3],
                simulated_m: vec![0.0, 9e-4],
                command_pa: 2e4,
            }],
        }
    }

    #[test]
    fn a_relaxation_survives_its_record() {
        assert_eq!(Relaxation::unpack(&whole().pack().unwrap()).unwrap(), whole());
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
}
