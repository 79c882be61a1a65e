//! The check: every number against its expectation and every claim against its rule, as a page of text.
//!
//! Stands on: claims, expected. Never knows: how a number was computed.

use crate::claims::Claim;
use crate::expected::Expected;
use crate::runner::MetricEntry;

/// The outcome of a check.
pub struct Checked {
    /// What to print.
    pub text: String,
    /// Whether any number drifted or is missing.
    pub drifted: bool,
}

/// Sets numbers beside expectations and claims beside their verdicts.
pub fn check(metrics: &[MetricEntry], expected: &Expected, claims: &[Claim]) -> Checked {
    let missing: Vec<&str> = expected.missing(metrics).collect();
    let drifted = !missing.is_empty() || metrics.iter().any(|m| m.status == "drifted");
    let mut lines = vec![format!(
        "{:<52} {:>12} {:<6} {:>10} {:>12} {:>10}  status",
        "metric", "ours", "unit", "published", "expected", "within"
    )];
    lines.extend(metrics.iter().map(metric_line));
    lines.extend(missing.iter().map(|name| format!("{name:<52} {:>12}  it was not computed", "missing")));
    lines.push(String::new());
    lines.extend(claims.iter().map(|claim| claim_line(claim, metrics)));
    lines.push(String::new());
    lines.push(summary(metrics, &missing, claims));
    Checked { text: lines.join("\n"), drifted }
}

fn metric_line(entry: &MetricEntry) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "–".into(), tell);
    format!(
        "{:<52} {:>12} {:<6} {:>10} {:>12} {:>10}  {}",
        entry.metric.id,
        tell(entry.metric.value),
        entry.metric.unit,
        number(entry.published),
        number(entry.expected),
        number(entry.tolerance),
        entry.status
    )
}

fn claim_line(claim: &Claim, metrics: &[MetricEntry]) -> String {
    let ours = metrics.iter().find(|m| m.metric.id == claim.metric);
    let ours = ours.map_or_else(|| "not computed".into(), |m| format!("{} {}", tell(m.metric.value), m.metric.unit));
    let verdict = match claim.reproduces(metrics) {
        Some(true) => "REPRODUCES",
        Some(false) => "DOES NOT REPRODUCE",
        None => "OPEN",
    };
    format!(
        "{verdict:<18}  {}\n{:20}rule: {} {}; ours: {}; published: {}",
        claim.says,
        "",
        claim.metric,
        claim.rule_in_words(),
        ours.trim_end(),
        claim.published
    )
}

fn summary(metrics: &[MetricEntry], missing: &[&str], claims: &[Claim]) -> String {
    let count = |status: &str| metrics.iter().filter(|m| m.status == status).count();
    let claims_that = |verdict| claims.iter().filter(|c| c.reproduces(metrics) == verdict).count();
    format!(
        "{} numbers as expected, {} drifted, {} missing, {} not compared; {} claims reproduce, {} do not, {} open",
        count("as expected"),
        count("drifted"),
        missing.len(),
        count("not compared"),
        claims_that(Some(true)),
        claims_that(Some(false)),
        claims_that(None)
    )
}

fn tell(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-3..1e5).contains(&v) => format!("{value:.3e}"),
        _ => format!("{value:.4}"),
    }
}
