//! Findings: metrics that decide claims of the paper, derived from other records.

use serde::{Deserialize, Serialize};

use crate::subject::Study;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

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

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("findings.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        files.read_scalars("findings.json")
    }

    fn metrics(&self, _: &str) -> Vec<Metric> {
        self.found.iter().map(|f| Metric::new(format!("findings.{}", f.name), f.value, &f.unit)).collect()
    }

    fn summary(&self) -> String {
        format!("{} metrics that decide claims", self.found.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_survive_their_record_and_are_metrics() {
        let finding = Finding { name: "a.minima".into(), value: 1.0, unit: String::new() };
        let findings = Findings { found: vec![finding] };
        assert_eq!(Findings::from_files(&findings.to_files().unwrap()).unwrap(), findings);
        assert_eq!(findings.metrics("all"), [Metric::new("findings.a.minima", 1.0, "")]);
    }
}
