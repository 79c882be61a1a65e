//! Metrics: published numbers, each with its name and unit.
//!
//! Names are `stage.specimen[.variant].quantity`, lower case, the unit at the end of the name.

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
    /// A metric from name, value and unit.
    pub fn new(id: impl Into<String>, value: f64, unit: &str) -> Self {
        Self { id: id.into(), value, unit: unit.into() }
    }
}
