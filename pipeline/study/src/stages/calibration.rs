//! Calibration: estimates of many specimens against their truths; the share inside the stated intervals says whether these are honest.

use serde::{Deserialize, Serialize};

use diagnostics::Result;
use records::{self, Coverage, Estimate, QuantityKind, Recovered};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Calibration;

/// `[calibration]` in `study.toml`: nothing to set.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

impl Stage for Calibration {
    type Settings = Settings;
    type Card = ();
    type Needs = Recovered;
    type Makes = records::Calibration;
    const DESCRIPTION: &'static str = "the share of true values inside their intervals is counted";
    const VERSION: u32 = 1;

    fn run((): &(), _: &Settings, recovered: Recovered, _: &dyn StageContext) -> Result<records::Calibration> {
        let estimates: Vec<&Estimate> = recovered.specimens.iter().flat_map(|s| &s.estimates).collect();
        let kinds = QuantityKind::ALL.map(|(kind, name, title)| {
            let estimates_of_kind = || estimates.iter().filter(|e| e.quantity.kind() == kind);
            let errors = estimates_of_kind().map(|e| e.standardised_error()).collect();
            Coverage {
                name: name.into(),
                title: title.into(),
                errors,
                sigma: median(estimates_of_kind().map(|e| e.sigma).collect()),
            }
        });
        let kinds = kinds.into_iter().filter(|kind| !kind.errors.is_empty()).collect();
        Ok(records::Calibration { specimens: recovered.specimens.len(), kinds })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_one() {
        assert_eq!(median(vec![3.0, 1.0, 9.0]), 3.0);
        assert!(median(Vec::new()).is_nan());
    }
}
