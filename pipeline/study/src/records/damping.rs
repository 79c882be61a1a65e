//! Damping: the decay of a specimen's free vibration.

use serde::{Deserialize, Serialize};
use si::{Metre, Second};

use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Rayleigh damping of a specimen, from a release.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Damping {
    /// β, proportional to stiffness, s.
    pub stiffness_damping: Second,
    /// Root mean square error of the free vibration, m.
    pub rmse: Metre,
    /// Every β evaluated, s, with its root mean square error, m.
    pub tried: Vec<(Second, Metre)>,
}

impl Record for Damping {
    type Of = Specimen;
    const STAGE: &'static str = "damping";

    fn pack(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("damping.json", self)
    }

    fn unpack(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("damping.json")
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |what: &str| format!("damping.{subject}.{what}");
        vec![
            Metric::new(id("stiffness_ms"), 1e3 * self.stiffness_damping, "ms"),
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
        ]
    }

    fn summary(&self) -> String {
        format!("β = {:.2} ms, RMSE {:.2} mm of the release", 1e3 * self.stiffness_damping, 1e3 * self.rmse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damping_survives_its_record() {
        let whole = Damping { stiffness_damping: 2e-3, rmse: 1e-4, tried: vec![(1e-3, 2e-4), (2e-3, 1e-4)] };
        assert_eq!(Damping::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
