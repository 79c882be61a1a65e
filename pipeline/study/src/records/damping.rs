//! Damping: how fast a specimen's swing dies.

use serde::{Deserialize, Serialize};
use si::{Metre, Second};

use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// Rayleigh's damping of a specimen, from a release.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Damping {
    /// β, proportional to stiffness, s.
    pub stiffness_damping: Second,
    /// What is left of the release, m.
    pub rmse: Metre,
    /// Every β that was tried, s, and what it left, m.
    pub tried: Vec<(Second, Metre)>,
}

impl Record for Damping {
    type Of = Specimen;
    const STAGE: &'static str = "damping";

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("damping.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("damping.json")
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let id = |what: &str| format!("damping.{}.{what}", of.card.name);
        vec![
            Metric::new(id("stiffness_ms"), 1e3 * self.stiffness_damping, "ms"),
            Metric::new(id("rmse_mm"), 1e3 * self.rmse, "mm"),
        ]
    }

    fn telling(&self) -> String {
        format!("β = {:.2} ms, {:.2} mm are left of the release", 1e3 * self.stiffness_damping, 1e3 * self.rmse)
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
