//! The check: every number against its expectation and every claim against its rule, as a page of text.

use crate::claims::{Claim, Verdict};
use crate::expected::MetricEntry;
pub use crate::junit::Results;
use crate::outdated;
use crate::paper::Problem;
use diagnostics::Result;

/// The outcome of a check.
pub struct Checked {
    /// The text to print.
    pub text: String,
    /// The same as JUnit XML.
    pub junit: String,
    /// Whether no number drifted or is missing, every record is up to date, and the paper can be built.
    pub holds: bool,
}

/// Compares numbers with expectations, lists claims with their verdicts, and the problems of the paper's source. The last line names what
/// is not up to date.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a text has no form in XML.
pub fn check(results: &Results) -> Result<Checked> {
    let Results { metrics, expected, claims, problems, outdated } = *results;
    let missing: Vec<&str> = expected.missing(metrics).collect();
    let drifted = metrics.iter().any(|m| m.status == "drifted");
    let holds = missing.is_empty() && !drifted && problems.is_empty() && outdated.is_empty();
    let mut lines = vec![format!(
        "{:<52} {:>12} {:<6} {:>10} {:>12} {:>10}  status",
        "metric", "ours", "unit", "published", "expected", "within"
    )];
    lines.extend(metrics.iter().map(metric_line));
    lines.extend(missing.iter().map(|name| format!("{name:<52} {:>12}  it was not computed", "missing")));
    lines.push(String::new());
    lines.extend(claims.iter().map(|claim| claim_line(claim, metrics)));
    lines.push(String::new());
    lines.extend(unreproduced_claims(claims, metrics));
    lines.push(String::new());
    lines.extend(problems.iter().map(Problem::to_string));
    lines.push(count_summary(metrics, &missing, claims));
    lines.extend(outdated::in_words(outdated));
    Ok(Checked { text: lines.join("\n"), junit: results.junit_report()?, holds })
}

fn metric_line(entry: &MetricEntry) -> String {
    let optional_number = |v: Option<f64>| v.map_or_else(|| "–".into(), number_text);
    format!(
        "{:<52} {:>12} {:<6} {:>10} {:>12} {:>10}  {}",
        entry.metric.id,
        number_text(entry.metric.value),
        entry.metric.unit,
        optional_number(entry.published),
        optional_number(entry.expected),
        optional_number(entry.tolerance),
        entry.status
    )
}

fn claim_line(claim: &Claim, metrics: &[MetricEntry]) -> String {
    format!(
        "{:<36}{}\n{:36}rule: {}; ours: {}; published: {}{}",
        claim.verdict(metrics).in_words().to_uppercase(),
        claim.says,
        "",
        claim.rules_in_words(),
        claim.ours(metrics).join(", "),
        claim.published,
        claim.set_by.as_ref().map_or(String::new(), |setting| format!("; decided by {setting}"))
    )
}

/// What does not reproduce, a line each.
fn unreproduced_claims(claims: &[Claim], metrics: &[MetricEntry]) -> Vec<String> {
    let claims_with = |verdict| claims.iter().filter(move |c| c.verdict(metrics) == verdict);
    let verdict_lines = |verdict: Verdict| {
        let lines = claims_with(verdict)
            .map(|c| format!("  {} ({}; published {})", c.says, c.ours(metrics).join(", "), c.published));
        std::iter::once(format!("{}: {}", verdict.in_words(), claims_with(verdict).count()))
            .chain(lines)
            .collect::<Vec<_>>()
    };
    let verdicts =
        [Verdict::Fails, Verdict::FailsByBench, Verdict::Undetermined, Verdict::SetByBench, Verdict::NotMeasured];
    verdicts.map(verdict_lines).concat()
}

fn count_summary(metrics: &[MetricEntry], missing: &[&str], claims: &[Claim]) -> String {
    let count_with = |status: &str| metrics.iter().filter(|m| m.status == status).count();
    let count_claims = |verdict| claims.iter().filter(|c| c.verdict(metrics) == verdict).count();
    format!(
        "{} numbers as expected, {} drifted, {} missing, {} not compared; {} claims reproduce, {} do not, {} more by the bench's making, {} are not determined, {} are set by the bench, {} not measured",
        count_with("as expected"),
        count_with("drifted"),
        missing.len(),
        count_with("not compared"),
        count_claims(Verdict::Reproduces),
        count_claims(Verdict::Fails),
        count_claims(Verdict::FailsByBench),
        count_claims(Verdict::Undetermined),
        count_claims(Verdict::SetByBench),
        count_claims(Verdict::NotMeasured)
    )
}

fn number_text(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-3..1e5).contains(&v) => format!("{value:.3e}"),
        _ => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Rule;
    use crate::expected::Expected;
    use workflow::metric::Metric;

    fn entry(id: &str, value: f64, status: &str) -> MetricEntry {
        let (published, expected, tolerance) = (None, Some(1.0), Some(0.5));
        MetricEntry { metric: Metric::new(id, value, "mm"), published, expected, tolerance, status: status.to_owned() }
    }

    fn claim(says: &str, rule: Rule, set_by: Option<&str>) -> Claim {
        let (metric, published) = ("a".to_owned(), "so".to_owned());
        let (name, also, set_by) = (says.to_owned(), Vec::new(), set_by.map(str::to_owned));
        let and = Vec::new();
        Claim { name, says: says.to_owned(), metric, also, rule, and, set_by, published, of_its_tail_alone: false }
    }

    fn checked(outdated: &[String]) -> Checked {
        let metrics = [
            entry("a", 2.0, "as expected"),
            entry("b", 4e-5, "drifted"),
            entry("c", 0.0, "not compared"),
            entry("d", 3.0, "as expected"),
        ];
        let claims = [
            claim("it is large", Rule::AtLeast(1.0), None),
            claim("it is small", Rule::AtMost(1.0), None),
            claim("it is chosen", Rule::AtMost(1.0), Some("its mould")),
        ];
        let expected = &Expected::default();
        check(&Results { metrics: &metrics, expected, claims: &claims, problems: &[], outdated }).unwrap()
    }

    #[test]
    fn a_number_stands_in_a_line_with_what_is_expected() {
        let text = checked(&[]).text;
        let words =
            |start: &str| text.lines().find(|l| l.starts_with(start)).unwrap().split_whitespace().collect::<Vec<_>>();
        assert_eq!(words("a "), ["a", "2.0000", "mm", "–", "1.0000", "0.5000", "as", "expected"]);
        assert_eq!(words("b ")[1..3], ["4.000e-5", "mm"]);
        assert_eq!(words("c ")[1], "0");
    }

    #[test]
    fn a_claim_stands_with_its_verdict_its_rule_and_both_values() {
        let text = checked(&[]).text;
        let lines: Vec<String> = text.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        let after = |line: &str| lines[1 + lines.iter().position(|l| l == line).unwrap()].clone();
        assert_eq!(after("REPRODUCES it is large"), "rule: a ≥ 1; ours: 2.00 mm; published: so");
        assert_eq!(
            after("DOES NOT REPRODUCE (BY THE BENCH) it is chosen"),
            "rule: a ≤ 1; ours: 2.00 mm; published: so; decided by its mould"
        );
        assert_eq!(after("does not reproduce: 1"), "it is small (2.00 mm; published so)");
    }

    #[test]
    fn the_last_line_counts_numbers_and_claims() {
        let counts = "2 numbers as expected, 1 drifted, 0 missing, 1 not compared; 1 claims reproduce, 1 do not, 1 more by the bench's making, \
                      0 are not determined, 0 are set by the bench, 0 not measured";
        assert_eq!(checked(&[]).text.lines().last(), Some(counts));
    }

    #[test]
    fn the_last_line_names_what_is_not_up_to_date_and_the_check_does_not_hold() {
        let metrics = [entry("a", 2.0, "as expected")];
        let expected = &Expected::default();
        let with = |outdated: &[String]| {
            check(&Results { metrics: &metrics, expected, claims: &[], problems: &[], outdated }).unwrap()
        };
        assert!(with(&[]).holds);
        let stale = with(&["reduce/fish: stale: setting `tolerance` was 1 and is 2".into(), "drag/fish: stale".into()]);
        let last = "not up to date: 2, the first reduce/fish: stale: setting `tolerance` was 1 and is 2; do: study run";
        assert_eq!((stale.text.lines().last(), stale.holds), (Some(last), false));
    }
}
