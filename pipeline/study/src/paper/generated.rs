//! Generated parts of the paper: all claims with their verdicts, and those that do not reproduce.
//!
//! Stands on: claims, facts, board. Never knows: the text around them.

use super::board::literal;
use super::facts::Facts;
use crate::claims::{Claim, Verdict};

/// All claims as a table: what is claimed, published, ours, verdict.
pub fn all(facts: &Facts) -> String {
    let row = |claim: &Claim| {
        let verdict = claim.verdict(&facts.metrics);
        let cells = [claim.says.clone(), claim.published.clone(), ours(claim, facts), verdict.in_words().to_owned()];
        let cells: Vec<String> = cells.iter().map(|cell| literal(cell)).collect();
        format!("({}, {})", cells.join(", "), verdict == Verdict::Fails)
    };
    let rows: Vec<String> = facts.claims.iter().map(row).collect();
    format!("#claim-table(({},))", rows.join(", "))
}

/// A list of the claims that do not reproduce, and one of those that this profile does not measure.
pub fn failing(facts: &Facts) -> String {
    let list = |verdict: Verdict| {
        let of = facts.claims.iter().filter(|c| c.verdict(&facts.metrics) == verdict);
        let item = |c: &Claim| {
            format!("- #{}\n", literal(&format!("{} (published: {}; ours: {}).", c.says, c.published, ours(c, facts))))
        };
        of.map(item).collect::<String>()
    };
    let said = |text: String, none: &str, some: &str| match text.is_empty() {
        true => format!("{none}\n\n"),
        false => format!("{some}\n\n{text}\n"),
    };
    let failing = said(list(Verdict::Fails), "Every claim that was measured reproduces.", "These do not:");
    let open = said(
        list(Verdict::NotMeasured),
        "All were measured.",
        "These were not measured in this profile, or not whole:",
    );
    failing + &open
}

fn ours(claim: &Claim, facts: &Facts) -> String {
    claim.ours(&facts.metrics).join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::facts::tests::facts;
    use super::*;

    #[test]
    fn a_claim_that_fails_is_in_both_and_one_that_holds_is_in_the_table_alone() {
        let (table, list) = (all(&facts()), failing(&facts()));
        assert!(table.contains("\"it is good\", \"1 mm\", \"0.5000 mm\", \"reproduces\", false"), "{table}");
        assert!(table.contains("\"does not reproduce\", true"));
        assert!(
            list.contains("it is bad (published: 1 mm; ours: 0.5000 mm).") && !list.contains("it is good"),
            "{list}"
        );
    }

    #[test]
    fn without_numbers_every_claim_is_said_to_be_unmeasured() {
        let bare = Facts { metrics: Vec::new(), ..facts() };
        assert!(failing(&bare).contains("not measured in this profile, or not whole:\n\n- #\"it is good"));
    }
}
