//! The paper's source, held to what it may name before anything was computed.

use std::path::Path;

use publish::paper::{Page, Problem, resolve};

fn problems(change: impl Fn(&mut Vec<Page>)) -> Vec<String> {
    let source = study::paper_source(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    let (mut pages, facts) = source.expect("the paper's source lies in the project");
    change(&mut pages);
    resolve(&pages, &facts).err().unwrap_or_default().iter().map(Problem::to_string).collect()
}

fn page<'a>(pages: &'a mut [Page], name: &str) -> &'a mut String {
    &mut pages.iter_mut().find(|page| page.name == name).expect("the paper has this page").text
}

fn append(name: &'static str, text: &'static str) -> impl Fn(&mut Vec<Page>) {
    move |pages| page(pages, name).push_str(text)
}

#[test]
fn the_paper_names_nothing_that_is_not_there_and_leaves_out_nothing_that_is() {
    let found = problems(|_| ());
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_number_that_no_stage_makes_is_one_problem() {
    let found = problems(append("sections/conclusion.typ", "#num(\"identify.nemo.body_e_mpw\")"));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("`identify.nemo.body_e_mpw` is not defined"), "{found:?}");
}

#[test]
fn a_figure_that_is_taken_out_is_one_problem() {
    let found = problems(|pages| {
        let text = page(pages, "sections/dynamics.typ");
        *text = text.replace("#wide(\"dynamics\")", "").replace("(@fig:dynamics)", "");
    });
    assert_eq!(found, ["paper/main.typ: figure `dynamics` is made but not shown in the paper"]);
}

#[test]
fn a_citation_without_an_entry_is_one_problem() {
    let found = problems(append("sections/conclusion.typ", "As in @nobody1900."));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("`@nobody1900` is neither in refs.bib nor a label"), "{found:?}");
}

#[test]
fn an_equation_whose_test_is_renamed_is_one_problem() {
    let renamed = |pages: &mut Vec<Page>| {
        let text = page(pages, "sections/model.typ");
        *text = text.replace("the_adjoint_gradient_passes_the_taylor_test", "another_test");
    };
    let found = problems(renamed);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("no test is called `another_test`"), "{found:?}");
}

#[test]
fn the_results_on_the_front_page_are_those_of_the_tracked_numbers() {
    let results = study::front_page_results(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    let [shown, given] =
        results.expect("the project's files can be read").expect("README.md has a place for its results");
    assert_eq!(shown, given, "`just paper` writes them anew");
}
