//! The check as JUnit XML, which interfaces of continuous integration show: a case for each number, each claim and each problem of the
//! paper's source.
//!
//! What fails is what makes the check fail: a number that drifted or is missing, a record that is not up to date, and a paper that cannot be
//! built. A number without an
//! expectation, and a claim that does not reproduce, is a skipped case with its reason.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use crate::claims::{Claim, Verdict};
use crate::expected::{Expected, MetricEntry};
use crate::paper::Problem;

/// A case: its name, and how it ended.
struct Case {
    name: String,
    end: End,
}

/// How a case ended, with the reason.
enum End {
    Passed,
    Failed(String),
    Skipped(String),
}

/// What a report is made of.
pub struct Results<'a> {
    /// The numbers with their expectations.
    pub metrics: &'a [MetricEntry],
    /// Those that are expected.
    pub expected: &'a Expected,
    /// The claims.
    pub claims: &'a [Claim],
    /// The problems of the paper's source.
    pub problems: &'a [Problem],
    /// What is not up to date, each with the reason.
    pub outdated: &'a [String],
}

impl Results<'_> {
    /// The report.
    ///
    /// # Errors
    /// When a text cannot be written as XML.
    pub(crate) fn junit_report(&self) -> io::Result<String> {
        let suites = [
            ("numbers", self.number_cases()),
            ("claims", self.claim_cases()),
            ("paper", self.paper_cases()),
            ("records", self.record_cases()),
        ];
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        writer.create_element("testsuites").with_attribute(("name", "study check")).write_inner_content(|writer| {
            suites
                .iter()
                .filter(|(_, cases)| !cases.is_empty())
                .try_for_each(|(name, cases)| write_suite(writer, name, cases))
        })?;
        let mut bytes = writer.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).map_err(io::Error::other)
    }

    fn number_cases(&self) -> Vec<Case> {
        let measured = self.metrics.iter().map(|entry| Case { name: entry.metric.id.clone(), end: case_end(entry) });
        let uncomputed = self.expected.missing(self.metrics);
        let uncomputed =
            uncomputed.map(|name| Case { name: name.into(), end: End::Failed("it was not computed".into()) });
        measured.chain(uncomputed).collect()
    }

    fn claim_cases(&self) -> Vec<Case> {
        let claim_case = |claim: &Claim| {
            let verdict = claim.verdict(self.metrics);
            let reason = || format!("{}: {} (published: {})", verdict.in_words(), claim.says, claim.published);
            let end = if verdict == Verdict::Reproduces { End::Passed } else { End::Skipped(reason()) };
            Case { name: claim.name.clone(), end }
        };
        self.claims.iter().map(claim_case).collect()
    }

    fn record_cases(&self) -> Vec<Case> {
        let outdated_case = |reason: &String| Case { name: "up to date".into(), end: End::Failed(reason.clone()) };
        self.outdated.iter().map(outdated_case).collect()
    }

    fn paper_cases(&self) -> Vec<Case> {
        let failed_case = |problem: &Problem| Case { name: "source".into(), end: End::Failed(problem.to_string()) };
        let failures: Vec<Case> = self.problems.iter().map(failed_case).collect();
        if failures.is_empty() { vec![Case { name: "source".into(), end: End::Passed }] } else { failures }
    }
}

fn case_end(entry: &MetricEntry) -> End {
    match (entry.status.as_str(), entry.expected.zip(entry.tolerance)) {
        ("drifted", Some((expected, within))) => {
            let (value, unit) = (entry.metric.value, &entry.metric.unit);
            let deviation = (value - expected).abs();
            End::Failed(format!(
                "{value} {unit}; expected {expected} ± {within} {unit}: it drifted by {deviation:.3e} {unit}"
            ))
        }
        (_, Some(_)) => End::Passed,
        _ => End::Skipped("no value is expected in this profile".into()),
    }
}

fn write_suite(writer: &mut Writer<Vec<u8>>, name: &str, cases: &[Case]) -> io::Result<()> {
    let count_ends = |predicate: fn(&End) -> bool| cases.iter().filter(|case| predicate(&case.end)).count().to_string();
    let (failed, skipped) =
        (count_ends(|end| matches!(end, End::Failed(_))), count_ends(|end| matches!(end, End::Skipped(_))));
    let total = cases.len().to_string();
    let counts = [("tests", &*total), ("failures", &*failed), ("errors", "0"), ("skipped", &*skipped)];
    let element = writer.create_element("testsuite").with_attribute(("name", name)).with_attributes(counts);
    element.write_inner_content(|writer| cases.iter().try_for_each(|case| write_case(writer, name, case)))?;
    Ok(())
}

fn write_case(writer: &mut Writer<Vec<u8>>, suite: &str, case: &Case) -> io::Result<()> {
    let kind = if suite == "numbers" { "drift" } else { "problem" };
    let attributes = [("classname", suite), ("name", &*case.name), ("time", "0")];
    let element = writer.create_element("testcase").with_attributes(attributes);
    match &case.end {
        End::Passed => element.write_empty()?,
        End::Skipped(reason) => element.write_inner_content(|writer| {
            writer.create_element("skipped").with_attribute(("message", &**reason)).write_empty().map(drop)
        })?,
        End::Failed(reason) => element.write_inner_content(|writer| {
            let failure = writer.create_element("failure").with_attribute(("message", &**reason));
            failure.with_attribute(("type", kind)).write_text_content(BytesText::new(reason)).map(drop)
        })?,
    };
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use workflow::metric::Metric;
    use workflow::settings::Profile;

    fn entry(expected: Option<f64>, status: &str) -> MetricEntry {
        let metric = Metric::new("validate.a<b.rmse", 0.3, "mm");
        MetricEntry { metric, published: None, expected, tolerance: expected.map(|_| 0.1), status: status.into() }
    }

    fn report(metrics: &[MetricEntry]) -> String {
        let expected = Expected::default();
        Results { metrics, expected: &expected, claims: &[], problems: &[], outdated: &[] }.junit_report().unwrap()
    }

    #[test]
    fn a_number_that_drifted_is_a_failed_case_with_its_value_and_its_expectation() {
        let text = report(&[entry(Some(0.1), "drifted"), entry(None, "not compared"), entry(Some(0.3), "as expected")]);
        let numbers = r#"<testsuite name="numbers" tests="3" failures="1" errors="0" skipped="1">"#;
        assert!(text.contains(numbers), "{text}");
        let message = "0.3 mm; expected 0.1 ± 0.1 mm: it drifted by 2.000e-1 mm";
        assert!(text.contains(&format!(r#"<failure message="{message}" type="drift">{message}</failure>"#)), "{text}");
        assert!(text.contains(r#"name="validate.a&lt;b.rmse""#), "{text}");
    }

    #[test]
    fn a_record_that_is_not_up_to_date_is_a_failed_case() {
        let outdated = ["mesh/fish: stale: setting `edge` was 1 and is 2".to_owned()];
        let results =
            Results { metrics: &[], expected: &Expected::default(), claims: &[], problems: &[], outdated: &outdated };
        let text = results.junit_report().unwrap();
        assert!(text.contains("<failure message=\"mesh/fish: stale: setting `edge` was 1 and is 2\""), "{text}");
    }

    #[test]
    fn a_number_that_was_not_computed_is_a_failed_case() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../paper/expected.toml");
        let expected = Expected::read(&path, Profile::Quick).unwrap();
        let text = Results { metrics: &[], expected: &expected, claims: &[], problems: &[], outdated: &[] }
            .junit_report()
            .unwrap();
        assert!(
            text.contains(r#"<failure message="it was not computed""#)
                && !text.contains(
                    r#"failures="0" errors="0" skipped="0">
    <testcase classname="numbers"#
                )
        );
    }
}
