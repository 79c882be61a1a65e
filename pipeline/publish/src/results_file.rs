//! Results on the project's front page: its numbers and claims stand between two comments and are written from `paper/results.md` whenever the
//! paper is, so that neither is typed by hand.
//!
//! The template is Markdown with two words: `#num("metric", digits: 2)`, the number, and `#claims("verdict")`, the claims with that verdict in the
//! order of `claims.toml`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::claims::{Claim, Verdict, short_number};
use crate::expected::MetricEntry;
use crate::paper::Facts;
use crate::paper::scan::{self, Call};
use diagnostics::{Diagnostic, Result, input};
use workflow::runner::write_atomically;

/// The template, in the paper's folder.
const TEMPLATE: &str = "results.md";
/// The front page, beside the paper's folder.
const PAGE: &str = "README.md";
/// Between these the results stand.
const MARKS: [&str; 2] = ["<!-- results: written by `study paper` -->\n", "<!-- end of results -->\n"];
const WORDS: &[&str] = &["num", "claims"];
/// What stands for a number that is not at hand, and for no claim.
const UNKNOWN: &str = "–";
const NO_CLAIM: &str = "none";

/// The metrics that the template names; none where a project has no template.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be read.
pub(crate) fn named(paper: &Path) -> Result<BTreeSet<String>> {
    if !paper.join(TEMPLATE).exists() {
        return Ok(BTreeSet::new());
    }
    let template = template(paper)?;
    let numbers = calls(&template).into_iter().filter(|call| call.word == "num");
    Ok(numbers.map(|call| call.name.to_owned()).collect())
}

/// Writes the results into the front page, where it has a place for them.
///
/// # Errors
/// A [`Diagnostic`] when a file cannot be read or written, or the template names a verdict that there is not.
pub(crate) fn write(paper: &Path, facts: &Facts) -> Result<()> {
    let Some((path, page)) = front_page(paper)? else { return Ok(()) };
    let Some([before, _, after]) = parts(&page) else { return Ok(()) };
    let text = format!("{before}{}{after}", rendered(paper, facts)?);
    write_atomically(&path, text.as_bytes())
        .map_err(|e| Diagnostic::new(format!("{PAGE} cannot be written"), e, "free some disk space"))
}

/// The results as they stand on the front page and as the numbers give them; nothing where there is no place for them.
///
/// # Errors
/// As [`write`].
pub(crate) fn compared(paper: &Path, facts: &Facts) -> Result<Option<[String; 2]>> {
    let Some((_, page)) = front_page(paper)? else { return Ok(None) };
    let Some([_, shown, _]) = parts(&page) else { return Ok(None) };
    Ok(Some([shown.to_owned(), rendered(paper, facts)?]))
}

/// The template with its numbers and claims in place.
fn rendered(paper: &Path, facts: &Facts) -> Result<String> {
    let template = template(paper)?;
    let (mut text, mut position) = (String::new(), 0);
    for call in calls(&template) {
        text += &template[position..call.span.0];
        text += &if call.word == "num" { number(&call, &facts.metrics) } else { claims(&call, facts)? };
        position = call.span.1;
    }
    Ok(text + &template[position..])
}

fn number(call: &Call, metrics: &[MetricEntry]) -> String {
    let value = metrics.iter().find(|entry| entry.metric.id == call.name).map(|entry| entry.metric.value);
    let digits = |value: f64| call.digits.map_or_else(|| short_number(value), |digits| format!("{value:.digits$}"));
    value.map_or(UNKNOWN.to_owned(), |value| digits(value).replace('-', "−"))
}

fn claims(call: &Call, facts: &Facts) -> Result<String> {
    let verdict = match call.name {
        "fails" => Verdict::Fails,
        "fails_by_bench" => Verdict::FailsByBench,
        "undetermined" => Verdict::Undetermined,
        other => {
            let verdict = format!("paper/{TEMPLATE} lists claims with the verdict `{other}`");
            return Err(Diagnostic::new(
                verdict,
                "there is none of that name",
                "name fails, fails_by_bench or undetermined",
            ));
        }
    };
    let with_verdict = facts.claims.iter().filter(|claim| claim.verdict(&facts.metrics) == verdict);
    let sentences: Vec<&str> = with_verdict.map(|claim: &Claim| claim.says.as_str()).collect();
    Ok(if sentences.is_empty() { NO_CLAIM.to_owned() } else { sentences.join(" · ") } + ".")
}

/// The text before the results, they, and the text after them.
fn parts(page: &str) -> Option<[&str; 3]> {
    let [begin, end] = MARKS;
    let (before, others) = page.split_at(page.find(begin)? + begin.len());
    let (results, after) = others.split_at(others.find(end)?);
    Some([before, results, after])
}

fn front_page(paper: &Path) -> Result<Option<(PathBuf, String)>> {
    let path = paper.with_file_name(PAGE);
    if !path.exists() {
        return Ok(None);
    }
    let text = input::read_text(&path, input::PAGE).map_err(|e| unreadable(&path, &e))?;
    Ok(Some((path, text)))
}

fn template(paper: &Path) -> Result<String> {
    let path = paper.join(TEMPLATE);
    input::read_text(&path, input::PAGE).map_err(|e| unreadable(&path, &e))
}

fn calls(template: &str) -> Vec<Call<'_>> {
    let next = |call: &Call<'_>| scan::next_call(template, WORDS, call.span.1);
    std::iter::successors(scan::next_call(template, WORDS, 0), next).collect()
}

fn unreadable(path: &Path, error: &dyn std::fmt::Display) -> Diagnostic {
    Diagnostic::new(format!("{} cannot be read", path.display()), error, "restore it with git")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::facts_of_tests;

    /// A project's folder with a template and a front page, removed at the end.
    fn in_project(template: &str, page: &str, check: impl FnOnce(&Path)) {
        let project = std::env::temp_dir().join(format!("results-{}-{}", std::process::id(), page.len()));
        let paper = project.join("paper");
        std::fs::create_dir_all(&paper).unwrap();
        std::fs::write(paper.join(TEMPLATE), template).unwrap();
        std::fs::write(project.join(PAGE), page).unwrap();
        check(&paper);
        std::fs::remove_dir_all(project).unwrap();
    }

    #[test]
    fn numbers_and_claims_are_written_between_the_marks_and_compared_with_them() {
        let [begin, end] = MARKS;
        let template = "off by #num(\"a.rmse_mm\", digits: 2), #num(\"b.known\"); not: #claims(\"fails\")\n";
        in_project(template, &format!("# Head\n{begin}old\n{end}tail\n"), |paper| {
            assert_eq!(named(paper).unwrap().into_iter().collect::<Vec<_>>(), ["a.rmse_mm", "b.known"]);
            write(paper, &facts_of_tests()).unwrap();
            let page = std::fs::read_to_string(paper.with_file_name(PAGE)).unwrap();
            assert_eq!(page, format!("# Head\n{begin}off by 0.50, –; not: it is bad.\n{end}tail\n"));
            let [shown, given] = compared(paper, &facts_of_tests()).unwrap().unwrap();
            assert_eq!(shown, given);
        });
    }

    #[test]
    fn a_page_without_marks_stays_and_an_unknown_verdict_is_refused() {
        in_project("#claims(\"maybe\")", "# Head", |paper| {
            write(paper, &facts_of_tests()).unwrap();
            assert_eq!(compared(paper, &facts_of_tests()).unwrap(), None);
            let refused = rendered(paper, &facts_of_tests()).unwrap_err();
            assert!(refused.what.contains("`maybe`"), "{refused}");
        });
    }
}
