//! Calibration: the share of true values inside the stated intervals, over many specimens of the virtual bench.

use optimize::coverage::{HALF_WIDTHS, count_inside, share_bounds};
use serde::{Deserialize, Serialize};

use crate::QuantityKind;
use crate::subject::Study;
use lab::card::Origin;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Fewest specimens whose shares say anything: with ten, a share of 0.95 is uncertain by 0.15.
const FEWEST: usize = 10;

/// Errors of the estimates of one kind of quantity over their stated deviations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Its name in metrics.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Error of the logarithm over its stated deviation, one an estimate.
    pub errors: Vec<f64>,
    /// Median of the stated deviations.
    pub sigma: f64,
}

impl Coverage {
    /// The share inside the intervals of half width `half` deviations, and its bounds as if the estimates of one specimen were one:
    /// they share their recordings.
    pub fn covered_share(&self, half: f64, specimens: usize) -> (f64, [f64; 2]) {
        let share = count_inside(&self.errors, half) as f64 / self.errors.len().max(1) as f64;
        (share, share_bounds(share, specimens))
    }
}

/// Coverage by kind of quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Number of specimens.
    pub specimens: usize,
    /// One a kind, in the order of the pipeline.
    pub kinds: Vec<Coverage>,
}

impl Calibration {
    /// All kinds as one.
    pub fn all(&self) -> Coverage {
        let errors = self.kinds.iter().flat_map(|kind| kind.errors.clone()).collect();
        Coverage { name: String::new(), title: "all".into(), errors, sigma: f64::NAN }
    }
}

impl Record for Calibration {
    type Of = Study;
    const STAGE: &'static str = "calibration";

    fn is_made_for(study: &Study) -> bool {
        study.specimens.iter().filter(|s| s.card.origin == Origin::VirtualBench).count() >= FEWEST
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("calibration.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("calibration.json")
    }

    fn metrics(&self, _: &str) -> Vec<Metric> {
        let coverage_metrics = |kind: &Coverage| {
            let dot = if kind.name.is_empty() { "" } else { "." };
            HALF_WIDTHS.map(|(stated, half)| {
                let id = format!("calibration.{}{dot}coverage_{:.0}_percent", kind.name, 100.0 * stated);
                Metric::new(id, 100.0 * kind.covered_share(half, self.specimens).0, "%")
            })
        };
        std::iter::once(self.all()).chain(self.kinds.clone()).flat_map(|kind| coverage_metrics(&kind)).collect()
    }

    fn summary(&self) -> String {
        let pooled = self.all();
        let share = |k: usize| 100.0 * pooled.covered_share(HALF_WIDTHS[k].1, self.specimens).0;
        let (specimens, kinds) = (self.specimens, QuantityKind::ALL.len());
        format!(
            "{specimens} specimens, {kinds} kinds: {:.0} % of the true values in their 95 % intervals, {:.0} % in those of 68 %",
            share(1),
            share(0)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_metrics_over_all_and_by_kind() {
        let kind = |name: &str, errors: &[f64]| Coverage {
            name: name.into(),
            title: name.into(),
            errors: errors.to_vec(),
            sigma: 0.1,
        };
        let calibration = Calibration { specimens: 20, kinds: vec![kind("a", &[0.5, -1.5]), kind("b", &[0.1, -3.0])] };
        assert_eq!(Calibration::from_files(&calibration.to_files().unwrap()).unwrap(), calibration);
        let value = |id: &str| calibration.metrics("all").into_iter().find(|m| m.id == id).map(|m| m.value);
        assert_eq!(value("calibration.coverage_68_percent"), Some(50.0));
        assert_eq!(value("calibration.coverage_95_percent"), Some(75.0));
        assert_eq!(value("calibration.a.coverage_95_percent"), Some(100.0));
    }
}
