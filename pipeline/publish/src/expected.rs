//! Expected and published values of each number in each profile: `paper/expected.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};

use diagnostics::{Diagnostic, Result, input};
use workflow::metric::Metric;
use workflow::settings::Profile;

/// One number with its expected and published values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricEntry {
    /// The number itself.
    #[serde(flatten)]
    pub metric: Metric,
    /// The published value.
    pub published: Option<f64>,
    /// The expected value in this profile.
    pub expected: Option<f64>,
    /// Tolerance about `expected`, in the unit of the metric.
    pub tolerance: Option<f64>,
    /// "as expected", "drifted" or "not compared".
    pub status: String,
}

/// The expectations of one profile.
#[derive(Debug, Clone, Default)]
pub struct Expected {
    published: BTreeMap<String, f64>,
    expected: BTreeMap<String, Expectation>,
    named: BTreeSet<String>,
}

/// The expectation of one number.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Expectation {
    /// In the metric's unit.
    pub value: f64,
    /// Its tolerance, in the metric's unit.
    pub within: f64,
    /// Whether more is as good: a speed on another machine.
    #[serde(default)]
    pub or_more: bool,
}

impl Expectation {
    fn holds_for(&self, value: f64) -> bool {
        (value - self.value).abs() <= self.within || self.or_more && value > self.value
    }
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
    #[serde(default)]
    population: BTreeMap<String, Expectation>,
}

impl Expected {
    /// Reads the page for a profile.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it is missing or not understood.
    pub fn read(path: &Path, profile: Profile) -> Result<Self> {
        let diagnostic = |e: &dyn std::fmt::Display| {
            Diagnostic::new(
                "paper/expected.toml cannot be read",
                e.to_string().trim_end(),
                "correct the line that it names",
            )
        };
        let text = input::read_text(path, input::PAGE).map_err(|e| diagnostic(&e))?;
        let page: Page = toml::from_str(&text).map_err(|e| diagnostic(&e))?;
        let listed = [&page.paper, &page.quick, &page.population]
            .into_iter()
            .flat_map(BTreeMap::keys)
            .chain(page.published.keys());
        let named = page.not_in_every_profile.iter().chain(listed).cloned().collect();
        let expected = match profile {
            Profile::Paper => page.paper,
            Profile::Quick => page.quick,
            Profile::Population => page.population,
        };
        Ok(Self { published: page.published, expected, named })
    }

    /// A number with its expected and published values.
    pub fn judge(&self, metric: Metric) -> MetricEntry {
        let expectation = self.expected.get(&metric.id);
        let status = match expectation {
            None => "not compared",
            Some(e) if e.holds_for(metric.value) => "as expected",
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
        let expectation = Expectation { value: 1.0, within: 0.1, or_more: false };
        let expected = Expected { expected: BTreeMap::from([("a".into(), expectation)]), ..Expected::default() };
        let status = |value| expected.judge(Metric::new("a", value, "mm")).status;
        assert_eq!((status(1.05).as_str(), status(1.2).as_str()), ("as expected", "drifted"));
        let speed = Expectation { or_more: true, ..expectation };
        assert!(speed.holds_for(7.0) && !speed.holds_for(0.8));
        assert_eq!(expected.missing(&[]).collect::<Vec<_>>(), ["a"]);
    }
}
