//! What each number is expected to be in each profile, and what was published: `paper/expected.toml`.
//!
//! Stands on: metric. Never knows: how a number was computed.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::fault::{Fault, Outcome};
use crate::metric::Metric;
use crate::runner::MetricEntry;
use crate::settings::Profile;

/// The expectations of one profile.
#[derive(Debug, Clone, Default)]
pub struct Expected {
    published: BTreeMap<String, f64>,
    expected: BTreeMap<String, Expectation>,
}

/// What one number should be.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// In the metric's unit.
    pub value: f64,
    /// How far it may lie off, in the metric's unit.
    pub within: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Page {
    #[serde(default)]
    published: BTreeMap<String, f64>,
    #[serde(default)]
    paper: BTreeMap<String, Expectation>,
    #[serde(default)]
    quick: BTreeMap<String, Expectation>,
}

impl Expected {
    /// Reads the page for a profile.
    ///
    /// # Errors
    /// A [`Fault`] when it is missing or not understood.
    pub fn read(path: &Path, profile: Profile) -> Outcome<Self> {
        let fault = |e: &dyn std::fmt::Display| {
            Fault::new("paper/expected.toml cannot be read", e.to_string().trim_end(), "mend the line it names")
        };
        let text = std::fs::read_to_string(path).map_err(|e| fault(&e))?;
        let page: Page = toml::from_str(&text).map_err(|e| fault(&e))?;
        let expected = match profile {
            Profile::Paper => page.paper,
            Profile::Quick => page.quick,
        };
        Ok(Self { published: page.published, expected })
    }

    /// A number beside what is known of it.
    pub fn judge(&self, metric: Metric) -> MetricEntry {
        let expectation = self.expected.get(&metric.id);
        let status = match expectation {
            None => "not compared",
            Some(e) if (metric.value - e.value).abs() <= e.within => "as expected",
            Some(_) => "drifted",
        };
        MetricEntry {
            published: self.published.get(&metric.id).copied(),
            expected: expectation.map(|e| e.value),
            tolerance: expectation.map(|e| e.within),
            status: status.into(),
            metric,
        }
    }

    /// Names that are expected but were not computed.
    pub fn missing<'a>(&'a self, computed: &'a [MetricEntry]) -> impl Iterator<Item = &'a str> {
        self.expected.keys().map(String::as_str).filter(|name| !computed.iter().any(|m| m.metric.id == *name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_outside_its_tolerance_has_drifted() {
        let expectation = Expectation { value: 1.0, within: 0.1 };
        let expected = Expected { published: BTreeMap::new(), expected: BTreeMap::from([("a".into(), expectation)]) };
        let status = |value| expected.judge(Metric::new("a", value, "mm")).status;
        assert_eq!((status(1.05).as_str(), status(1.2).as_str()), ("as expected", "drifted"));
        assert_eq!(expected.missing(&[]).collect::<Vec<_>>(), ["a"]);
    }
}
