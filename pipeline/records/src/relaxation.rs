//! Relaxation: the spectrum of a specimen's silicone, from the transients of its staircases.

use serde::{Deserialize, Serialize};
use si::{Hertz, Metre, Second};

use crate::Identified;
use crate::subject::Specimen;
use diagnostics::Result;
use sysid::relaxation::{IdentifiedBranch, IdentifiedSpectrum, Transient};
use sysid::{Model, Viscoelastic};
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The relaxation spectrum of a specimen's silicone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Relaxation {
    /// The spectrum.
    #[serde(flatten)]
    pub spectrum: IdentifiedSpectrum,
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
pub const REPORTED: [Hertz; 3] = [1.0, 2.0, 8.0];

impl Relaxation {
    /// The constants of a model with this silicone and the moduli of `identified`.
    ///
    /// # Errors
    /// As [`IdentifiedSpectrum::relaxation`].
    pub fn silicone(&self, model: &Model, identified: &Identified) -> Result<Viscoelastic> {
        let elastic = identified.elastic(model);
        Ok(Viscoelastic::measured_at(self.spectrum.modulus_time_s, elastic, self.spectrum.relaxation()?))
    }
}

impl Record for Relaxation {
    type Of = Specimen;
    const STAGE: &'static str = "relaxation";

    fn to_files(&self) -> std::result::Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("relaxation.json", self)
    }

    fn from_files(files: &RecordFiles) -> std::result::Result<Self, RecordError> {
        let relaxation: Self = files.read_scalars("relaxation.json")?;
        let fault = relaxation.spectrum.fault().map(|cause| super::inconsistent_file("relaxation.json", cause));
        fault.map_or(Ok(relaxation), Err)
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("relaxation.{subject}.{quantity}");
        let mut metrics = vec![
            Metric::new(id("rmse_mm"), 1e3 * self.rmse_m, "mm"),
            Metric::new(id("elastic_rmse_mm"), 1e3 * self.elastic_rmse_m, "mm"),
            Metric::new(id("modulus_time_s"), self.spectrum.modulus_time_s, "s"),
        ];
        for frequency in REPORTED {
            let Ok([storage, loss]) = self.spectrum.at(frequency) else { continue };
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
        let branches: Vec<String> = self.spectrum.branches.iter().map(branch).collect();
        let (rmse, elastic) = (1e3 * self.rmse_m, 1e3 * self.elastic_rmse_m);
        format!(
            "branches {}; moduli at {:.1} s; RMSE {rmse:.3} mm, elastic {elastic:.3}",
            branches.join(", "),
            self.spectrum.modulus_time_s
        )
    }
}

/// A branch whose deviation is above this share of the prior's is called undetermined.
const UNDETERMINED: f64 = 0.7;

#[cfg(test)]
mod tests {
    use super::*;

    fn relaxation() -> Relaxation {
        let branch = |time_s, strength| IdentifiedBranch { time_s, strength, sigma: 0.1, over_prior: 0.1 };
        let spectrum = IdentifiedSpectrum {
            branches: vec![branch(0.01, 0.2), branch(1.0, 0.1)],
            correlation: vec![1.0, 0.3, 0.3, 1.0],
            modulus_time_s: 3.0,
            modulus_response: vec![vec![-2.0, 0.5]],
        };
        Relaxation {
            spectrum,
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
        assert_eq!(Relaxation::from_files(&relaxation().to_files().unwrap()).unwrap(), relaxation());
    }

    #[test]
    fn a_relaxation_with_lists_of_another_number_of_branches_is_refused_with_its_file() {
        let (mut fewer, mut response) = (relaxation(), relaxation());
        fewer.spectrum.correlation.pop();
        response.spectrum.modulus_response[0].push(0.1);
        for (damaged, words) in [(fewer, "2 branches have 3 correlations"), (response, "3 responses of 2 branches")] {
            let error = Relaxation::from_files(&damaged.to_files().unwrap()).unwrap_err().to_string();
            assert!(error.contains("relaxation.json") && error.contains(words), "{error}");
        }
    }
}
