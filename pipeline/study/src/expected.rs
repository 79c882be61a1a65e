//! What each number is expected to be in each profile, and what was published: `paper/expected.toml`.
//!
//! Stands on: metric. Never knows: how a number was computed.

use std::collections::{BTreeMap, BTreeSet};
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
    named: BTreeSet<String>,
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
    not_in_every_profile: BTreeSet<String>,
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
        let listed = [&page.paper, &page.quick].into_iter().flat_map(BTreeMap::keys).chain(page.published.keys());
        let named = page.not_in_every_profile.iter().chain(listed).cloned().collect();
        let expected = match profile {
            Profile::Paper => page.paper,
            Profile::Quick => page.quick,
        };
        Ok(Self { published: page.published, expected, named })
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

    /// Names of all numbers that the page lists, in whichever profile.
    pub fn named(&self) -> &BTreeSet<String> {
        &self.named
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
        let expected = Expected { expected: BTreeMap::from([("a".into(), expectation)]), ..Expected::default() };
        let status = |value| expected.judge(Metric::new("a", value, "mm")).status;
        assert_eq!((status(1.05).as_str(), status(1.2).as_str()), ("as expected", "drifted"));
        assert_eq!(expected.missing(&[]).collect::<Vec<_>>(), ["a"]);
    }
}
