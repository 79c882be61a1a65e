//! Tails that stand in for those that a profile lacks: their metrics decide the claims there.

use std::collections::BTreeMap;
use std::path::Path;

use crate::claims::{self, Claim, Part, Rule};
use diagnostics::Result;
use workflow::settings::Profile;

/// Reads the claims as a profile decides them, where other tails stand in for those that it lacks.
///
/// # Errors
/// As [`claims::read`].
pub fn read(path: &Path, profile: Profile) -> Result<Vec<Claim>> {
    let claims::Page { claim, stand_in } = claims::claims_page(path)?;
    let Some(tails) = stand_in.get(&profile) else { return Ok(claim) };
    Ok(claim.into_iter().map(|claim| StandIns(tails).decided_claim(claim)).collect())
}

/// The tail that stands in for each.
struct StandIns<'a>(&'a BTreeMap<String, String>);

impl StandIns<'_> {
    /// A claim decided by metrics of the tails that stand in for its own, unless it is about its tail alone.
    fn decided_claim(&self, claim: Claim) -> Claim {
        if claim.of_its_tail_alone {
            return claim;
        }
        let also = claim.also.iter().map(|metric| self.stand_in_metric(metric)).collect();
        let part =
            |part: Part| Part { metric: self.stand_in_metric(&part.metric), rule: self.stand_in_rule(part.rule) };
        let (rule, and) = (self.stand_in_rule(claim.rule), claim.and.into_iter().map(part).collect());
        Claim { metric: self.stand_in_metric(&claim.metric), also, rule, and, ..claim }
    }

    /// A rule that compares with metrics of the tails that stand in.
    fn stand_in_rule(&self, rule: Rule) -> Rule {
        match rule {
            Rule::SmallerThan(other) => Rule::SmallerThan(self.stand_in_metric(&other)),
            Rule::AtMostTimes(factor, other) => Rule::AtMostTimes(factor, self.stand_in_metric(&other)),
            Rule::Ascending(others) => {
                Rule::Ascending(others.iter().map(|other| self.stand_in_metric(other)).collect())
            }
            limit @ (Rule::AtMost(_) | Rule::AtLeast(_) | Rule::Within(_) | Rule::Outside(_)) => limit,
        }
    }

    /// A metric of a tail's, or of its trial's, as that of the tail that stands in for it.
    fn stand_in_metric(&self, id: &str) -> String {
        let parts = id.split('.').map(|part| {
            let (tail, trial) = part.split_at(part.find('_').unwrap_or(part.len()));
            self.0.get(tail).map_or_else(|| part.to_owned(), |other| format!("{other}{trial}"))
        });
        parts.collect::<Vec<_>>().join(".")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tail_stands_in_for_another_and_for_its_trials_but_not_in_claims_about_that_tail_alone() {
        let claim: Claim = toml::from_str(
            "name = 'a'\nsays = ''\npublished = ''\nmetric = 'validate.nemo_200mbar_2hz.rmse_mm'\nalso = ['camera.focal', \
             'identify.bruce.loss']\nrule = { ascending = ['identify.nemo.loss'] }",
        )
        .unwrap();
        let tails = [("nemo".to_owned(), "marlin".to_owned())].into();
        let tails = StandIns(&tails);
        let decided = tails.decided_claim(claim.clone());
        assert_eq!(decided.metric, "validate.marlin_200mbar_2hz.rmse_mm");
        assert_eq!(decided.also, ["camera.focal", "identify.bruce.loss"]);
        assert_eq!(decided.rule.others(), ["identify.marlin.loss"]);
        let smaller = Claim { rule: Rule::SmallerThan("identify.nemo.loss".into()), ..claim.clone() };
        assert_eq!(tails.decided_claim(smaller).rule.others(), ["identify.marlin.loss"]);
        let alone = Claim { of_its_tail_alone: true, ..claim };
        assert_eq!(tails.decided_claim(alone.clone()), alone);
    }
}
