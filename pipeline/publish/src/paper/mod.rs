//! The paper: its source with every number, verdict, figure, table and citation in place, or one problem for each that
//! cannot be resolved.
//!
//! A page is typst with a few additional words, each replaced or only checked:
//!
//! | word | becomes |
//! |---|---|
//! | `#num("metric", digits: 2)`, `#val(…)` | the number; with its unit |
//! | `#verdict("claim")[holds][does not][not measured]` | the block that the numbers choose |
//! | `#when("metric", "fig:name")[at hand][not]` | the same by whether there are these numbers, figures and tables |
//! | `#plate("figure")[caption]`, `#wide(…)` | the figure, in one column or two |
//! | `#tabular("table")[caption]`, `#broad(…)` | the table |
//! | `#eq("test")[$ … $]` | an equation; its test stands in a table at the end |
//! | `#claims()`, `#failing()` | all claims with verdicts; those that do not reproduce |
//! | `#scope()` | where the numbers are from, and what was left out |
//! | `#said[3 %]` | a number from a source, not of this study |
//!
//! What is not at hand is left out with its sentence (`omit`), which `#scope()` says once.

mod board;
mod citations;
mod digits;
mod facts;
mod generated;
mod omit;
mod place;
pub(crate) mod scan;

#[cfg(test)]
pub(crate) use facts::tests::facts as facts_of_tests;
pub use facts::{Facts, Made, Origin};
pub(crate) use facts::{cited_keys, test_names};
pub(crate) use generated::claim_cells;

/// One file of the source: its name below the paper's folder, and its text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// `sections/results.typ`.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// A problem that prevents building the paper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The page.
    pub page: String,
    /// The line, from 1; 0 where it is the whole paper.
    pub line: usize,
    /// The problem.
    pub what: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.line {
            0 => write!(f, "paper/{}: {}", self.page, self.what),
            line => write!(f, "paper/{}:{line}: {}", self.page, self.what),
        }
    }
}

/// Resolves all words of the source.
///
/// # Errors
/// Every [`Problem`] found, each once.
pub fn resolve(pages: &[Page], facts: &Facts) -> Result<Vec<Page>, Vec<Problem>> {
    let mut found = place::Found::default();
    let resolved: Vec<Page> = pages.iter().map(|page| place::resolved_page(page, facts, &mut found)).collect();
    let place::Found { shown, missing, mut problems } = found;
    let resolved = with_omissions(resolved, facts, &missing);
    problems.extend(pages.iter().flat_map(digits::typed_by_hand));
    problems.extend(citations::citation_problems(pages, facts));
    let paper_problem = |what| Problem { page: "main.typ".into(), line: 0, what };
    let unused_problem =
        |kind: &str, name: &str| paper_problem(format!("{kind} `{name}` is made but not shown in the paper"));
    let is_shown = |name: &str| shown.iter().any(|s| s == name);
    problems.extend(facts.figures.iter().filter(|f| !is_shown(&f.name)).map(|f| unused_problem("figure", &f.name)));
    problems.extend(facts.tables.iter().filter(|t| !is_shown(&t.name)).map(|t| unused_problem("table", &t.name)));
    let mut problem_texts = std::collections::BTreeSet::new();
    problems.retain(|problem| problem_texts.insert(problem.what.clone()));
    if problems.is_empty() { Ok(resolved) } else { Err(problems) }
}

/// The pages without the sentences about what is not at hand, which their scope counts.
fn with_omissions(pages: Vec<Page>, facts: &Facts, missing: &[String]) -> Vec<Page> {
    let mut omitted = 0;
    let mut without = |page: Page| {
        let (text, count) = omit::without_absent(&omit::without_references(&page.text, missing));
        omitted += count;
        Page { text, ..page }
    };
    let pages: Vec<Page> = pages.into_iter().map(&mut without).collect();
    let scope = generated::scope_in_words(facts, missing, omitted);
    let with_scope = |page: Page| Page { text: page.text.replace(generated::SCOPE, &scope), ..page };
    pages.into_iter().map(with_scope).collect()
}

#[cfg(test)]
mod tests {
    use super::facts::tests::facts;
    use super::*;

    fn page(text: &str) -> Page {
        Page { name: "main.typ".into(), text: text.into() }
    }

    const WHOLE: &str = "#plate(\"tail\")[Seen @du2021.] #tabular(\"trials\")[Runs.] ";

    fn problems(text: &str) -> Vec<String> {
        let all = resolve(&[page(&format!("{WHOLE}{text}"))], &facts()).err().unwrap_or_default();
        all.iter().map(Problem::to_string).collect()
    }

    #[test]
    fn a_whole_page_has_its_numbers_in_place() {
        let text = format!("{WHOLE}It is #val(\"a.rmse_mm\", digits: 1) off.");
        let resolved = resolve(&[page(&text)], &facts()).unwrap();
        assert!(resolved[0].text.ends_with("It is #\"0.5\u{a0}mm\"; off."), "{}", resolved[0].text);
    }

    #[test]
    fn an_undefined_number_is_one_problem_with_its_line() {
        assert_eq!(
            problems("\n#num(\"a.rsme_mm\")"),
            [
                "paper/main.typ:2: number `a.rsme_mm` is not defined: no stage makes it and paper/expected.toml does not list it"
            ]
        );
    }

    #[test]
    fn an_unused_figure_is_one_problem() {
        let bare = resolve(&[page("#tabular(\"trials\")[Runs.]")], &facts()).unwrap_err();
        assert_eq!(bare.len(), 1);
        assert!(bare[0].what.contains("figure `tail` is made but not shown"), "{}", bare[0]);
    }

    #[test]
    fn a_missing_citation_is_one_problem() {
        assert_eq!(
            problems("As in @nobody1900."),
            ["paper/main.typ:1: `@nobody1900` is neither in refs.bib nor a label"]
        );
    }

    #[test]
    fn an_equation_whose_test_is_gone_is_one_problem() {
        assert_eq!(problems("#eq(\"a_test_that_is\")[$ a $]"), Vec::<String>::new());
        assert_eq!(problems("#eq(\"gone\")[$ a $]").len(), 1);
    }

    #[test]
    fn a_verdict_chooses_its_block_and_what_is_in_it_is_placed_too() {
        let text = format!(
            "{WHOLE}#verdict(\"good\")[It is #num(\"a.rmse_mm\", digits: 2)][no][open]#verdict(\"bad\")[yes][No.][open]"
        );
        let resolved = resolve(&[page(&text)], &facts()).unwrap();
        assert!(resolved[0].text.ends_with("It is #\"0.50\";No."), "{}", resolved[0].text);
    }

    #[test]
    fn a_number_typed_by_hand_is_one_problem_and_a_said_one_is_none() {
        assert_eq!(problems("It is 0.5 mm off.").len(), 1);
        assert_eq!(problems("They had #said[3 %] and $0.5 x$.").len(), 0);
    }

    #[test]
    fn a_figure_that_is_not_made_is_a_problem_of_the_profile_that_makes_it() {
        let without = |elsewhere| {
            let mut facts = Facts { strict: true, ..facts() };
            (facts.figures[0].text, facts.figures[0].elsewhere) = (None, elsewhere);
            resolve(&[page(WHOLE)], &facts)
        };
        assert_eq!(without(false).unwrap_err()[0].what, "figure `tail` was not made: study run tail");
        let left = without(true).unwrap().remove(0).text;
        assert!(!left.contains("tail") && !left.contains("Seen") && left.contains("trials"), "{left}");
    }

    #[test]
    fn what_is_not_at_hand_is_left_out_with_its_sentence_and_counted_once() {
        let text = format!("{WHOLE}\n\n#scope()\n\nIt is #num(\"b.known\") off. It stays.");
        let resolved = resolve(&[page(&text)], &facts()).unwrap().remove(0).text;
        assert!(resolved.contains("hand: 1 sentence.") && resolved.ends_with("\n\nIt stays."), "{resolved}");
        let strict = Facts { strict: true, ..facts() };
        assert_eq!(resolve(&[page(&text)], &strict).unwrap_err().len(), 1);
    }
}
