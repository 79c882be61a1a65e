//! Generated parts of the paper: claims with their verdicts, those that do not reproduce, and where the numbers are from.

use std::collections::BTreeMap;

use super::board::string_literal;
use super::facts::{Facts, Origin};
use crate::claims::{Claim, Verdict};
use crate::numbers_file::RECORDS;

/// Stands for the words of `#scope()` until it is known what was left out.
pub(super) const SCOPE: char = '\u{2}';

/// The claims whose numbers are at hand as a table: what is claimed, published, ours, verdict; nothing where there is none.
pub(crate) fn claim_table(facts: &Facts) -> Option<String> {
    let row = |claim: &Claim| {
        let cells: Vec<String> = claim_cells(claim, facts).iter().map(|cell| string_literal(cell)).collect();
        format!("({}, {})", cells.join(", "), claim.verdict(&facts.metrics).is_failure())
    };
    let decided = facts.claims.iter().filter(|claim| claim.verdict(&facts.metrics) != Verdict::NotMeasured);
    let rows: Vec<String> = decided.map(row).collect();
    (!rows.is_empty()).then(|| format!("#claim-table(({},))", rows.join(", ")))
}

/// What is claimed, published, ours, and the verdict.
pub(crate) fn claim_cells(claim: &Claim, facts: &Facts) -> [String; 4] {
    let verdict = verdict_in_words(claim, claim.verdict(&facts.metrics));
    [claim.says.clone(), claim.published.clone(), our_numbers(claim, facts), verdict]
}

fn verdict_in_words(claim: &Claim, verdict: Verdict) -> String {
    match (&claim.set_by, verdict) {
        (Some(setting), Verdict::SetByBench | Verdict::FailsByBench) => format!("{}: {setting}", verdict.in_words()),
        _ => verdict.in_words().to_owned(),
    }
}

/// Lists of the claims that do not reproduce, that are not determined and that the bench decides, and how many have no number.
pub(crate) fn failing_claims(facts: &Facts) -> String {
    let (total, open) = (facts.claims.len(), claims_with(facts, Verdict::NotMeasured).count());
    if open == total {
        return "No claim of the original is decided by these numbers.\n".to_owned();
    }
    let lists = [
        (Verdict::Fails, "These do not reproduce:"),
        (Verdict::FailsByBench, "These do not reproduce by the making of the virtual bench:"),
        (Verdict::Undetermined, "The recordings do not determine these; they count neither way:"),
        (Verdict::SetByBench, "Settings of the virtual bench decide that these hold; they do not count as reproduced:"),
    ];
    let lists = lists.map(|(verdict, head)| claim_list(facts, verdict, head)).concat();
    let none_fails = !facts.claims.iter().any(|claim| claim.verdict(&facts.metrics).is_failure());
    let none_fails = if none_fails { "None of the claims whose numbers are at hand fails.\n\n" } else { "" };
    let open = match open {
        0 => String::new(),
        open => format!("Of {total} claims {open} are left out of the table, because their numbers are not at hand.\n"),
    };
    format!("{none_fails}{lists}{open}")
}

fn claims_with(facts: &Facts, verdict: Verdict) -> impl Iterator<Item = &Claim> {
    facts.claims.iter().filter(move |claim| claim.verdict(&facts.metrics) == verdict)
}

/// A list of the claims with a verdict under its head; nothing where there is none.
fn claim_list(facts: &Facts, verdict: Verdict, head: &str) -> String {
    let item = |claim: &Claim| {
        let setting = claim.set_by.as_ref().map_or(String::new(), |setting| format!(" Decided by {setting}."));
        let (says, published) = (&claim.says, &claim.published);
        let words = format!("{says} (published: {published}; ours: {}).{setting}", our_numbers(claim, facts));
        format!("- #{};\n", string_literal(&words))
    };
    let items: String = claims_with(facts, verdict).map(item).collect();
    if items.is_empty() { items } else { format!("{head}\n\n{items}\n") }
}

/// Where the numbers are from, and what was left out because it was not made or not kept.
pub(super) fn scope_in_words(facts: &Facts, missing: &[String], omitted: usize) -> String {
    let origin = match &facts.origin {
        Origin::OtherProfile => {
            "This is a coarse and short profile of the study, not the paper's; its numbers are drawn from its records."
                .to_owned()
        }
        Origin::Tracked(counts) => tracked_in_words(counts),
    };
    let names = |prefix: &str| -> Vec<&str> { missing.iter().filter_map(|label| label.strip_prefix(prefix)).collect() };
    let listed = [("figures", names("fig:")), ("tables", names("tab:"))];
    let listed = listed.iter().filter(|(_, names)| !names.is_empty());
    let listed = listed.map(|(kind, names)| format!("the {kind} {}", names.join(", ")));
    let sentences = (omitted > 0).then(|| format!("{omitted} sentence{}", if omitted == 1 { "" } else { "s" }));
    let left_out: Vec<String> = listed.chain(sentences).collect();
    match left_out.is_empty() {
        true => origin,
        false => {
            let words = format!("Left out, because they need what is not at hand: {}.", left_out.join("; "));
            format!("{origin} #{};", string_literal(&words)).trim_end_matches(';').to_owned()
        }
    }
}

/// The sources of tracked numbers, with how many are from each.
fn tracked_in_words(counts: &BTreeMap<String, usize>) -> String {
    if counts.keys().all(|source| source == RECORDS) {
        return "Every number that this study computes is drawn from the records of one run of the paper profile."
            .to_owned();
    }
    let part = |(source, count): (&String, &usize)| match source.as_str() {
        RECORDS => format!("{count} from records of the paper profile"),
        "figures" => format!("{count} are read off the figures that are tracked with it"),
        "tables" => format!("{count} are read off the tables that are tracked with this source"),
        "expected" => format!("{count} are expected values gathered over several runs"),
        other => format!("{count} from {other}"),
    };
    let parts: Vec<String> = counts.iter().map(part).collect();
    format!(
        "No records were at hand when the page was set. Of the numbers of the paper profile that it uses {}.",
        parts.join(", ")
    )
}

fn our_numbers(claim: &Claim, facts: &Facts) -> String {
    claim.ours(&facts.metrics).join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::facts::tests::facts;
    use super::*;

    #[test]
    fn a_claim_that_fails_is_in_both_and_one_that_holds_is_in_the_table_alone() {
        let (table, list) = (claim_table(&facts()).unwrap(), failing_claims(&facts()));
        assert!(table.contains("\"it is good\", \"1 mm\", \"0.5000 mm\", \"reproduces\", false"), "{table}");
        assert!(table.contains("\"does not reproduce\", true"));
        assert!(
            list.contains("it is bad (published: 1 mm; ours: 0.5000 mm).") && !list.contains("it is good"),
            "{list}"
        );
    }

    #[test]
    fn without_numbers_no_claim_is_said_to_reproduce() {
        let bare = Facts { metrics: Vec::new(), ..facts() };
        assert_eq!(failing_claims(&bare), "No claim of the original is decided by these numbers.\n");
        assert_eq!(claim_table(&bare), None);
    }

    #[test]
    fn what_is_left_out_is_named_once() {
        let missing = ["fig:a", "tab:b", "fig:c"].map(str::to_owned);
        let words = scope_in_words(&facts(), &missing, 2);
        assert!(words.contains("the figures a, c; the tables b; 2 sentences."), "{words}");
        assert!(!scope_in_words(&facts(), &[], 0).contains("Left out"));
    }

    #[test]
    fn numbers_of_several_sources_are_not_said_to_be_of_one_run() {
        let of = |sources: &[(&str, usize)]| {
            tracked_in_words(&sources.iter().map(|(source, count)| ((*source).to_owned(), *count)).collect())
        };
        assert!(of(&[(RECORDS, 9)]).contains("one run"));
        let mixed = of(&[("tables", 3), ("expected", 4)]);
        assert!(!mixed.contains("one run") && mixed.contains("3 are read off") && mixed.contains("4 are expected"));
    }
}
