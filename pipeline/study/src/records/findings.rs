//! Findings: numbers that decide claims of the paper and follow from records that are there already.

use serde::{Deserialize, Serialize};

use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Study;

/// All of them, each with its name below `findings.` and its unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Findings {
    /// One each.
    pub found: Vec<Finding>,
}

/// One number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// `specimen.quantity`.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// Empty for pure numbers.
    pub unit: String,
}

impl Record for Findings {
    type Of = Study;
    const STAGE: &'static str = "findings";

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("findings.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("findings.json")
    }

    fn metrics(&self, _: &Study) -> Vec<Metric> {
        self.found.iter().map(|f| Metric::new(format!("findings.{}", f.name), f.value, &f.unit)).collect()
    }

    fn telling(&self) -> String {
        format!("{} numbers that decide claims", self.found.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_survive_their_record_and_are_metrics() {
        let finding = Finding { name: "a.minima".into(), value: 1.0, unit: String::new() };
        let whole = Findings { found: vec![finding] };
        assert_eq!(Findings::unpack(&whole.pack().unwrap()).unwrap(), whole);
        assert_eq!(whole.metrics(&Study { specimens: Vec::new() }), [Metric::new("findings.a.minima", 1.0, "")]);
    }
}
