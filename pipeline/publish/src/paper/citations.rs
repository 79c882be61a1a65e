//! Citations: `@key` must be in refs.bib, or be a label of the paper.

use super::facts::Facts;
use super::scan;
use super::{Page, Problem};

/// Prefixes of labels that figures, tables and equations are given where they are shown.
const LABELS: [(&str, &[&str]); 2] = [("fig:", &["plate", "wide"]), ("tab:", &["tabular", "broad"])];

/// Every reference without a target.
pub(crate) fn citation_problems(pages: &[Page], facts: &Facts) -> Vec<Problem> {
    let labels: Vec<String> = pages.iter().flat_map(|page| page_labels(&page.text)).collect();
    let problems_of = |page: &Page| -> Vec<Problem> {
        let unresolved = |(position, key): (usize, String)| {
            let what = format!("`@{key}` is neither in refs.bib nor a label");
            (!facts.cited.contains(&key) && !labels.contains(&key)).then(|| Problem {
                page: page.name.clone(),
                line: scan::line_number(&page.text, position),
                what,
            })
        };
        page_references(&page.text).into_iter().filter_map(unresolved).collect()
    };
    pages.iter().flat_map(problems_of).collect()
}

/// `@key` outside of words (an address has one inside).
fn page_references(text: &str) -> Vec<(usize, String)> {
    let key = |(position, _): (usize, &str)| {
        let within_word = text[..position].ends_with(|c: char| c.is_alphanumeric());
        let key: String =
            text[position + 1..].chars().take_while(|c| c.is_alphanumeric() || "_-:".contains(*c)).collect();
        let key = key.trim_end_matches(':').to_owned();
        (!within_word && !key.is_empty()).then_some((position, key))
    };
    text.match_indices('@').filter_map(key).collect()
}

/// Labels written as `<label>`, and those of figures and tables by their names.
fn page_labels(text: &str) -> Vec<String> {
    let written = text.match_indices('<').filter_map(|(position, _)| {
        let (label, _) = text[position + 1..].split_once('>')?;
        let plain = label.chars().all(|c| c.is_alphanumeric() || "_-:".contains(c));
        (plain && !label.is_empty()).then(|| label.to_owned())
    });
    let mut labels: Vec<String> = written.collect();
    for (prefix, words) in LABELS {
        let mut position = 0;
        while let Some(call) = scan::next_call(text, words, position) {
            labels.push(format!("{prefix}{}", call.name));
            position = call.span.1;
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_end_before_punctuation_and_addresses_are_none() {
        let found: Vec<String> = page_references("see @fig:tail, @du2021: a@b.org").into_iter().map(|r| r.1).collect();
        assert_eq!(found, ["fig:tail", "du2021"]);
    }

    #[test]
    fn figures_and_written_labels_can_be_referred_to() {
        assert_eq!(page_labels("#plate(\"tail\")[x] $a < b$ <eq:one>"), ["eq:one", "fig:tail"]);
    }
}
