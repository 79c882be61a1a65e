//! Four parameters: both moduli and both Poisson's ratios, identified together, with the iterates.

use optimize::posterior::WITHIN_95;
use serde::{Deserialize, Serialize};
use si::Pascal;

use super::Uncertainty;
use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The elastic constants of a specimen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Four {
    /// E of the body, Pa.
    pub body_e_pa: Pascal,
    /// E of the spine, Pa.
    pub spine_e_pa: Pascal,
    /// ν of the body.
    pub body_nu: f64,
    /// ν of the spine.
    pub spine_nu: f64,
}

impl Four {
    /// In the order of the fields: MPa, GPa and no unit.
    pub fn in_display_units(&self) -> [f64; 4] {
        [1e-6 * self.body_e_pa, 1e-9 * self.spine_e_pa, self.body_nu, self.spine_nu]
    }
}

/// The search over four parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FourParameters {
    /// Where it ended.
    pub best: Four,
    /// The loss there.
    pub loss: f64,
    /// Every point and its loss, in order.
    pub iterates: Vec<(Four, f64)>,
    /// Lowest and highest plausible value of each parameter: Pa, Pa, no unit, no unit.
    pub plausible: [[f64; 2]; 4],
    /// Deviations of ln E and of ln (½ − ν).
    pub uncertainty: Uncertainty,
}

impl FourParameters {
    /// The 95 % interval of each parameter in the units of [`Four::in_display_units`]. Where it is as wide as the plausible range, the
    /// recordings do not determine the parameter.
    pub fn intervals(&self) -> [[f64; 2]; 4] {
        let best = self.best.in_display_units();
        let half = |k: usize| WITHIN_95 * self.uncertainty.sigma[k];
        let modulus = |k: usize| [-1.0, 1.0].map(|sign: f64| best[k] * (sign * half(k)).exp());
        // a larger ½ − ν is a smaller ν
        let ratio = |k: usize| [1.0, -1.0].map(|sign: f64| 0.5 - (0.5 - best[k]) * (sign * half(k)).exp());
        [modulus(0), modulus(1), ratio(2), ratio(3)]
    }
}

impl Record for FourParameters {
    type Of = Specimen;
    const STAGE: &'static str = "four_parameters";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.has_sheet()
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("four_parameters.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("four_parameters.json")
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("four_parameters.{subject}.{quantity}");
        let names = [("body_e_mpa", "MPa"), ("spine_e_gpa", "GPa"), ("body_nu", ""), ("spine_nu", "")];
        let estimates = names.into_iter().zip(self.best.in_display_units()).zip(self.intervals());
        let parameter = |(((name, unit), value), [low, high]): (((&str, &str), f64), [f64; 2])| {
            let end = |word: &str, value| Metric::new(id(&format!("{name}.{word}")), value, unit);
            [Metric::new(id(name), value, unit), end("low", low), end("high", high)]
        };
        let searched =
            [Metric::new(id("loss"), self.loss, ""), Metric::new(id("iterations"), self.iterates.len() as f64, "")];
        estimates.flat_map(parameter).chain(searched).collect()
    }

    fn summary(&self) -> String {
        let [body, spine, body_nu, spine_nu] = self.best.in_display_units();
        let words = &self.uncertainty.words;
        format!("body {body:.4} MPa, ν {body_nu:.4}; spine {spine:.3} GPa, ν {spine_nu:.3}; {words}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_parameters_survive_their_record() {
        let best = Four { body_e_pa: 2e5, spine_e_pa: 3e9, body_nu: 0.48, spine_nu: 0.37 };
        let plausible = [[1e5, 3e5], [1e9, 6e9], [0.45, 0.495], [0.3, 0.45]];
        let uncertainty = Uncertainty { sigma: vec![0.1; 4], ..Uncertainty::default() };
        let parameters = FourParameters { best, loss: 1e-3, iterates: vec![(best, 1e-3)], plausible, uncertainty };
        assert_eq!(FourParameters::from_files(&parameters.to_files().unwrap()).unwrap(), parameters);
        let [body, _, nu, _] = parameters.intervals();
        // a tenth in the logarithm: E by a fifth either way, ½ − ν likewise
        assert!((body[1] / 0.2 - (0.196f64).exp()).abs() < 1e-3 && body[0] < 0.2, "{body:?}");
        assert!((0.5 - nu[0]) / 0.02 > 1.2 && (0.5 - nu[1]) / 0.02 < 0.83, "{nu:?}");
        assert!(parameters.metrics("a").iter().any(|m| m.id == "four_parameters.a.body_nu.low" && m.value == nu[0]));
    }
}
