//! The claims of the paper: which number decides each, by which rule, and whether it reproduces.
//!
//! `paper/claims.toml` holds them. A claim that does not reproduce is printed as such; only a drift of a number from its
//! expectation, or a number that was not computed, is a failure.
//!
//! Stands on: metric. Never knows: how a number was computed.

use std::path::Path;

use serde::Deserialize;

use crate::fault::{Fault, Outcome};
use crate::runner::MetricEntry;

/// One claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// What is claimed, in one sentence.
    pub says: String,
    /// The metric that decides it.
    pub metric: String,
    /// How it decides.
    pub rule: Rule,
    /// What was published, in words.
    pub published: String,
}

/// How a metric decides a claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rule {
    /// At most so much.
    AtMost(f64),
    /// At least so much.
    AtLeast(f64),
    /// Between two values.
    Within([f64; 2]),
    /// Smaller than another metric.
    SmallerThan(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Page {
    claim: Vec<Claim>,
}

/// Reads the claims.
///
/// # Errors
/// A [`Fault`] when the page is missing or not understood.
pub fn read(path: &Path) -> Outcome<Vec<Claim>> {
    let fault = |e: &dyn std::fmt::Display| {
        Fault::new("paper/claims.toml cannot be read", e.to_string().trim_end(), "mend the line it names")
    };
    let text = std::fs::read_to_string(path).map_err(|e| fault(&e))?;
    let page: Page = toml::from_str(&text).map_err(|e| fault(&e))?;
    Ok(page.claim)
}

impl Claim {
    /// Whether it reproduces; nothing when a metric it needs was not computed.
    pub fn reproduces(&self, metrics: &[MetricEntry]) -> Option<bool> {
        let value = |id: &str| metrics.iter().find(|m| m.metric.id == id).map(|m| m.metric.value);
        let ours = value(&self.metric)?;
        Some(match &self.rule {
            Rule::AtMost(limit) => ours <= *limit,
            Rule::AtLeast(limit) => ours >= *limit,
            Rule::Within([low, high]) => (*low..=*high).contains(&ours),
            Rule::SmallerThan(other) => ours < value(other)?,
        })
    }

    /// The rule in words.
    pub fn rule_in_words(&self) -> String {
        match &self.rule {
            Rule::AtMost(limit) => format!("≤ {limit}"),
            Rule::AtLeast(limit) => format!("≥ {limit}"),
            Rule::Within([low, high]) => format!("{low} … {high}"),
            Rule::SmallerThan(other) => format!("< {other}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expected::Expected;
    use crate::metric::Metric;

    fn claim(rule: Rule) -> Claim {
        Claim { says: "a".into(), metric: "a".into(), rule, published: String::new() }
    }

    #[test]
    fn a_claim_is_decided_by_its_rule_and_open_without_its_metric() {
        let metrics: Vec<_> =
            [("a", 2.0), ("b", 3.0)].map(|(id, v)| Expected::default().judge(Metric::new(id, v, ""))).into();
        assert_eq!(claim(Rule::AtMost(1.0)).reproduces(&metrics), Some(false));
        assert_eq!(claim(Rule::Within([1.0, 2.0])).reproduces(&metrics), Some(true));
        assert_eq!(claim(Rule::SmallerThan("b".into())).reproduces(&metrics), Some(true));
        assert_eq!(claim(Rule::SmallerThan("c".into())).reproduces(&metrics), None);
    }
}
