//! Metrics: the numbers that leave the house, each with its name, unit and what was published.
//!
//! Names are `stage.specimen[.variant].quantity`, lower case, the unit at the end of the name.
//!
//! Stands on: nothing. Never knows: how a number was computed.

use serde::{Deserialize, Serialize};

/// One computed number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// `stage.specimen[.variant].quantity`.
    pub id: String,
    /// The number, in `unit`.
    pub value: f64,
    /// Its unit; empty for pure numbers.
    pub unit: String,
}

impl Metric {
    /// A metric from its parts.
    pub fn new(id: impl Into<String>, value: f64, unit: &str) -> Self {
        Self { id: id.into(), value, unit: unit.into() }
    }

    /// Whether the number depends on how fast the machine was, and so is not compared from run to run.
    pub fn is_a_duration(&self) -> bool {
        self.unit == "s" && self.id.contains("second")
    }
}
