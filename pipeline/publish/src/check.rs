//! The check: every number against its expectation and every claim against its rule, as a page of text.

use crate::claims::{Claim, Verdict};
use crate::expected::Expected;
use crate::expected::MetricEntry;
use crate::junit::Results;
use crate::paper::Problem;
use diagnostics::Result;

/// The outcome of a check.
pub struct Checked {
    /// The text to print.
    pub text: String,
    /// The same as JUnit XML.
    pub junit: String,
    /// Whether any number drifted or is missing, or the paper cannot be built.
    pub drifted: bool,
}

/// Compares numbers with expectations, lists claims with their verdicts, and the problems of the paper's source.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a text has no form in XML.
pub fn check(metrics: &[MetricEntry], expected: &Expected, claims: &[Claim], problems: &[Problem]) -> Result<Checked> {
    let missing: Vec<&str> = expected.missing(metrics).collect();
    let off = metrics.iter().any(|m| m.status == "drifted");
    let drifted = !missing.is_empty() || off || !problems.is_empty();
    let mut lines = vec![format!(
        "{:<52} {:>12} {:<6} {:>10} {:>12} {:>10}  status",
        "metric", "ours", "unit", "published", "expected", "within"
    )];
    lines.extend(metrics.iter().map(metric_line));
    lines.extend(missing.iter().map(|name| format!("{name:<52} {:>12}  it was not computed", "missing")));
    lines.push(String::new());
    lines.extend(claims.iter().map(|claim| claim_line(claim, metrics)));
    lines.push(String::new());
    lines.extend(plainly(claims, metrics));
    lines.push(String::new());
    lines.extend(problems.iter().map(Problem::to_string));
    lines.push(summary(metrics, &missing, claims));
    let junit = Results { metrics, expected, claims, problems }.junit()?;
    Ok(Checked { text: lines.join("\n"), junit, drifted })
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
    format!(
        "{:<30}{}\n{:30}rule: {} {}; ours: {}; published: {}{}",
        claim.verdict(metrics).in_words().to_uppercase(),
        claim.says,
        "",
        claim.metrics().map(String::as_str).collect::<Vec<_>>().join(" and "),
        claim.rule.in_words(),
        claim.ours(metrics).join(", "),
        claim.published,
        claim.set_by.as_ref().map_or(String::new(), |setting| format!("; decided by {setting}"))
    )
}

/// What does not reproduce, a line each.
fn plainly(claims: &[Claim], metrics: &[MetricEntry]) -> Vec<String> {
    let of = |verdict| claims.iter().filter(move |c| c.verdict(metrics) == verdict);
    let list = |verdict: Verdict| {
        let lines =
            of(verdict).map(|c| format!("  {} ({}; published {})", c.says, c.ours(metrics).join(", "), c.published));
        std::iter::once(format!("{}: {}", verdict.in_words(), of(verdict).count())).chain(lines).collect::<Vec<_>>()
    };
    [Verdict::Fails, Verdict::Undetermined, Verdict::SetByBench, Verdict::NotMeasured].map(list).concat()
}

fn summary(metrics: &[MetricEntry], missing: &[&str], claims: &[Claim]) -> String {
    let count = |status: &str| metrics.iter().filter(|m| m.status == status).count();
    let claims_that = |verdict| claims.iter().filter(|c| c.verdict(metrics) == verdict).count();
    format!(
        "{} numbers as expected, {} drifted, {} missing, {} not compared; {} claims reproduce, {} do not, {} are not determined, {} are set by the bench, {} not measured",
        count("as expected"),
        count("drifted"),
        missing.len(),
        count("not compared"),
        claims_that(Verdict::Reproduces),
        claims_that(Verdict::Fails),
        claims_that(Verdict::Undetermined),
        claims_that(Verdict::SetByBench),
        claims_that(Verdict::NotMeasured)
    )
}

fn tell(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-3..1e5).contains(&v) => format!("{value:.3e}"),
        _ => format!("{value:.4}"),
    }
}
