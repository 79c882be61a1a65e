//! Generated parts of the paper: all claims with their verdicts, and those that do not reproduce.

use super::board::string_literal;
use super::facts::Facts;
use crate::claims::{Claim, Verdict};

/// All claims as a table: what is claimed, published, ours, verdict.
pub(crate) fn claim_table(facts: &Facts) -> String {
    let row = |claim: &Claim| {
        let verdict = claim.verdict(&facts.metrics);
        let cells =
            [claim.says.clone(), claim.published.clone(), our_numbers(claim, facts), verdict_in_words(claim, verdict)];
        let cells: Vec<String> = cells.iter().map(|cell| string_literal(cell)).collect();
        format!("({}, {})", cells.join(", "), verdict == Verdict::Fails)
    };
    let rows: Vec<String> = facts.claims.iter().map(row).collect();
    format!("#claim-table(({},))", rows.join(", "))
}

fn verdict_in_words(claim: &Claim, verdict: Verdict) -> String {
    match (&claim.set_by, verdict) {
        (Some(setting), Verdict::SetByBench) => format!("{}: {setting}", verdict.in_words()),
        _ => verdict.in_words().to_owned(),
    }
}

/// A list of the claims that do not reproduce, and the number that this profile does not measure.
pub(crate) fn failing_claims(facts: &Facts) -> String {
    let claims_with = |verdict: Verdict| facts.claims.iter().filter(move |c| c.verdict(&facts.metrics) == verdict);
    let words = |c: &Claim| format!("{} (published: {}; ours: {}).", c.says, c.published, our_numbers(c, facts));
    let items: String = claims_with(Verdict::Fails).map(|c| format!("- #{};\n", string_literal(&words(c)))).collect();
    let (total, open) = (facts.claims.len(), claims_with(Verdict::NotMeasured).count());
    let failing = match items.is_empty() {
        true => "Every claim that was measured reproduces.\n".to_owned(),
        false => format!("These do not reproduce:\n\n{items}"),
    };
    let open = match open {
        0 => "All claims were measured.".to_owned(),
        open => {
            format!("Of {total} claims {open} are not measured in this profile, or not whole; the table marks them.")
        }
    };
    let set: String = claims_with(Verdict::SetByBench)
        .map(|c| format!("- #{};\n", string_literal(&format!("{} {}", words(c), c.set_by.clone().unwrap_or_default()))))
        .collect();
    let set = match set.is_empty() {
        true => String::new(),
        false => {
            format!("Settings of the virtual bench decide the outcome of these, which count neither way:\n\n{set}\n")
        }
    };
    let items: String =
        claims_with(Verdict::Undetermined).map(|c| format!("- #{};\n", string_literal(&words(c)))).collect();
    let undetermined = match items.is_empty() {
        true => String::new(),
        false => format!("The recordings do not determine these; they count neither way:\n\n{items}\n"),
    };
    format!("{failing}\n{undetermined}{set}{open}\n")
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
        let (table, list) = (claim_table(&facts()), failing_claims(&facts()));
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
        assert!(
            failing_claims(&bare).contains("Of 2 claims 2 are not measured in this profile"),
            "{}",
            failing_claims(&bare)
        );
    }
}
