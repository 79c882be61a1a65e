//! The claims of the paper: which number decides each, by which rule, and whether it reproduces.
//!
//! `paper/claims.toml` holds them. A claim that does not reproduce is printed as such; only a drift of a number from its
//! expectation, or a number that was not computed, is a failure. A sentence that says several things is one claim with several [`Part`]s.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::expected::MetricEntry;
use diagnostics::{Diagnostic, Result, input};
use workflow::settings::Profile;

/// One claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Its short name, with which the paper's text refers to it.
    pub name: String,
    /// The claim, in one sentence.
    pub says: String,
    /// The metric that decides it.
    pub metric: String,
    /// Others that the same rule must hold for.
    #[serde(default)]
    pub also: Vec<String>,
    /// How it decides.
    pub rule: Rule,
    /// What else the same sentence says: it holds when all of it does.
    #[serde(default)]
    pub and: Vec<Part>,
    /// The settings of the virtual bench that decide its outcome, where they do.
    #[serde(default)]
    pub set_by: Option<String>,
    /// The published statement.
    pub published: String,
    /// Whether it is about its tail alone, so that none stands in for it.
    #[serde(default)]
    pub of_its_tail_alone: bool,
}

/// A further part of a claim: another number with a rule of its own.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The metric that decides it.
    pub metric: String,
    /// How it decides.
    pub rule: Rule,
}

/// The rule of a claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rule {
    /// At most this value.
    AtMost(f64),
    /// At least this value.
    AtLeast(f64),
    /// Between two values.
    Within([f64; 2]),
    /// Below the first or above the second of two values.
    Outside([f64; 2]),
    /// At most a multiple of another metric.
    AtMostTimes(f64, String),
    /// Smaller than another metric.
    SmallerThan(String),
    /// Smaller than a metric that is smaller than the next, and so on.
    Ascending(Vec<String>),
}

/// The verdict on a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Its rule holds for every metric.
    Reproduces,
    /// Its rule does not hold for at least one.
    Fails,
    /// A metric of it was not measured in this profile, and the measured ones do not contradict it.
    NotMeasured,
    /// It is about a quantity whose 95 % interval (metrics `.low` and `.high`) lies on both sides of its rule.
    Undetermined,
    /// Settings of the virtual bench decide that its rule holds: it does not count as reproduced.
    SetByBench,
    /// Settings of the virtual bench decide that its rule does not hold: it counts as not reproduced all the same.
    FailsByBench,
}

impl Verdict {
    /// Whether the original's statement does not hold here, whoever decides it.
    pub(crate) fn is_failure(self) -> bool {
        matches!(self, Self::Fails | Self::FailsByBench)
    }

    /// As `study check` and the paper print it.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Reproduces => "reproduces",
            Self::Fails => "does not reproduce",
            Self::NotMeasured => "not measured in this profile",
            Self::Undetermined => "not determined by the recordings",
            Self::SetByBench => "set by the bench",
            Self::FailsByBench => "does not reproduce (by the bench)",
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Page {
    pub(crate) claim: Vec<Claim>,
    /// By profile, the tail that stands in for each.
    #[serde(default)]
    pub(crate) stand_in: BTreeMap<Profile, BTreeMap<String, String>>,
}

/// Reads the claims as the paper makes them.
///
/// # Errors
/// A [`Diagnostic`] when the page is missing or not understood.
pub fn read(path: &Path) -> Result<Vec<Claim>> {
    Ok(claims_page(path)?.claim)
}

/// The claims, and the tails that stand in for others by profile.
///
/// # Errors
/// As [`read`].
pub(crate) fn claims_page(path: &Path) -> Result<Page> {
    let diagnostic = |e: &dyn std::fmt::Display| {
        Diagnostic::new("paper/claims.toml cannot be read", e.to_string().trim_end(), "correct the line that it names")
    };
    let text = input::read_text(path, input::PAGE).map_err(|e| diagnostic(&e))?;
    let page: Page = toml::from_str(&text).map_err(|e| diagnostic(&e))?;
    let duplicate = (1..page.claim.len()).find(|&i| page.claim[..i].iter().any(|c| c.name == page.claim[i].name));
    match duplicate {
        Some(i) => Err(diagnostic(&format!("two claims are called `{}`", page.claim[i].name))),
        None => Ok(page),
    }
}

impl Claim {
    /// The metrics that decide it, each with its rule.
    fn ruled_metrics(&self) -> impl Iterator<Item = (&String, &Rule)> {
        let own = std::iter::once(&self.metric).chain(&self.also).map(|metric| (metric, &self.rule));
        own.chain(self.and.iter().map(|part| (&part.metric, &part.rule)))
    }

    /// The metrics that decide it.
    pub fn metrics(&self) -> impl Iterator<Item = &String> {
        self.ruled_metrics().map(|(metric, _)| metric)
    }

    /// The metrics with which its rules compare.
    pub fn others(&self) -> impl Iterator<Item = &String> {
        self.rule.others().iter().chain(self.and.iter().flat_map(|part| part.rule.others()))
    }

    /// Its rules in words, each after the metrics that must keep it.
    pub(crate) fn rules_in_words(&self) -> String {
        let own: Vec<&str> = std::iter::once(&self.metric).chain(&self.also).map(String::as_str).collect();
        let parts = self.and.iter().map(|part| format!("{} {}", part.metric, part.rule.in_words()));
        let own = format!("{} {}", own.join(" and "), self.rule.in_words());
        std::iter::once(own).chain(parts).collect::<Vec<_>>().join(" and ")
    }

    /// Its verdict.
    pub fn verdict(&self, metrics: &[MetricEntry]) -> Verdict {
        match self.rule_outcome(metrics) {
            Verdict::Fails if self.set_by.is_some() => Verdict::FailsByBench,
            Verdict::Reproduces if self.set_by.is_some() => Verdict::SetByBench,
            decided => decided,
        }
    }

    /// What its rule gives, whoever decides it.
    pub(crate) fn rule_outcome(&self, metrics: &[MetricEntry]) -> Verdict {
        let rule_results: Vec<Option<bool>> =
            self.ruled_metrics().map(|(id, rule)| rule.holds_for(id, metrics)).collect();
        match () {
            () if self.ruled_metrics().any(|(id, rule)| rule.is_undetermined(id, metrics)) => Verdict::Undetermined,
            () if rule_results.contains(&Some(false)) => Verdict::Fails,
            () if rule_results.contains(&None) => Verdict::NotMeasured,
            () => Verdict::Reproduces,
        }
    }

    /// Our numbers with their units, those that were measured.
    pub fn ours(&self, metrics: &[MetricEntry]) -> Vec<String> {
        let measured = |id: &String| {
            let metric = metrics.iter().find(|m| m.metric.id == *id).map(|m| &m.metric);
            metric.map_or_else(|| "–".into(), |m| format!("{} {}", short_number(m.value), m.unit).trim_end().to_owned())
        };
        self.metrics().chain(self.others()).map(measured).collect()
    }
}

impl Rule {
    /// Whether it holds for a metric; nothing when a number is missing.
    fn holds_for(&self, id: &str, metrics: &[MetricEntry]) -> Option<bool> {
        let value = |id: &str| metrics.iter().find(|m| m.metric.id == id).map(|m| m.metric.value);
        let ours = value(id)?;
        Some(match self {
            Self::AtMost(limit) => ours <= *limit,
            Self::AtLeast(limit) => ours >= *limit,
            Self::Within([low, high]) => (*low..=*high).contains(&ours),
            Self::Outside([low, high]) => ours < *low || ours > *high,
            Self::AtMostTimes(factor, other) => ours <= factor * value(other)?,
            Self::SmallerThan(other) => ours < value(other)?,
            Self::Ascending(thresholds) => {
                let thresholds: Vec<f64> = thresholds.iter().map(|id| value(id)).collect::<Option<_>>()?;
                std::iter::once(&ours).chain(&thresholds).is_sorted_by(|a, b| a < b)
            }
        })
    }

    /// Whether it holds at one end of a metric's 95 % interval and not at the other; false for a metric without an interval.
    fn is_undetermined(&self, id: &str, metrics: &[MetricEntry]) -> bool {
        let [low, high] = ["low", "high"].map(|end| self.holds_for(&format!("{id}.{end}"), metrics));
        low.zip(high).is_some_and(|(low, high)| low != high)
    }

    /// The metrics that it compares with.
    pub fn others(&self) -> &[String] {
        match self {
            Self::SmallerThan(other) | Self::AtMostTimes(_, other) => std::slice::from_ref(other),
            Self::Ascending(others) => others,
            Self::AtMost(_) | Self::AtLeast(_) | Self::Within(_) | Self::Outside(_) => &[],
        }
    }

    /// In words.
    pub fn in_words(&self) -> String {
        match self {
            Self::AtMost(limit) => format!("≤ {limit}"),
            Self::AtLeast(limit) => format!("≥ {limit}"),
            Self::Within([low, high]) => format!("{low} … {high}"),
            Self::Outside([low, high]) => format!("< {low} or > {high}"),
            Self::AtMostTimes(factor, other) => format!("≤ {factor} × {other}"),
            Self::SmallerThan(other) => format!("< {other}"),
            Self::Ascending(others) => others.iter().map(|o| format!("< {o}")).collect::<Vec<_>>().join(" "),
        }
    }
}

/// A number with a readable number of digits.
pub(crate) fn short_number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-3..1e5).contains(&v) => format!("{value:.2e}"),
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expected::Expected;
    use workflow::metric::Metric;

    fn claim(rule: Rule, also: &[&str]) -> Claim {
        let also = also.iter().map(|s| (*s).to_owned()).collect();
        Claim {
            name: "a".into(),
            says: "a".into(),
            metric: "a".into(),
            also,
            rule,
            and: Vec::new(),
            set_by: None,
            published: String::new(),
            of_its_tail_alone: false,
        }
    }

    fn metrics() -> Vec<MetricEntry> {
        [("a", 2.0), ("b", 3.0), ("d", 4.0)].map(|(id, v)| Expected::default().judge(Metric::new(id, v, ""))).into()
    }

    #[test]
    fn a_claim_is_decided_by_its_rule_and_open_without_its_metric() {
        let verdict = |rule| claim(rule, &[]).verdict(&metrics());
        assert_eq!(verdict(Rule::AtMost(1.0)), Verdict::Fails);
        assert_eq!(verdict(Rule::Within([1.0, 2.0])), Verdict::Reproduces);
        assert_eq!(verdict(Rule::SmallerThan("b".into())), Verdict::Reproduces);
        assert_eq!(verdict(Rule::SmallerThan("c".into())), Verdict::NotMeasured);
    }

    #[test]
    fn a_tail_stands_in_for_another_in_a_known_profile_only() {
        let page =
            |profile: &str| toml::from_str::<Page>(&format!("claim = []\n[stand_in.{profile}]\nnemo = 'marlin'"));
        assert_eq!(page("quick").unwrap().stand_in[&Profile::Quick]["nemo"], "marlin");
        let refused = page("quik").err().unwrap().to_string();
        assert!(refused.contains("quik") && refused.contains("`quick`"), "{refused}");
    }

    #[test]
    fn a_number_is_not_smaller_than_its_equal() {
        assert_eq!(claim(Rule::SmallerThan("a".into()), &[]).verdict(&metrics()), Verdict::Fails);
        assert_eq!(claim(Rule::Ascending(vec!["a".into()]), &[]).verdict(&metrics()), Verdict::Fails);
        assert_eq!(claim(Rule::AtLeast(2.0), &[]).verdict(&metrics()), Verdict::Reproduces);
        assert_eq!(claim(Rule::AtMost(2.0), &[]).verdict(&metrics()), Verdict::Reproduces);
    }

    #[test]
    fn a_number_is_shown_with_about_three_digits() {
        let shown = [0.0, 2e-4, 1e-3, 0.5, 1.0, 12.345, 100.0, -2345.6, 1e5].map(short_number);
        assert_eq!(shown, ["0", "2.00e-4", "0.0010", "0.5000", "1.00", "12.35", "100", "-2346", "1.00e5"]);
    }

    #[test]
    fn what_the_bench_makes_true_does_not_count_as_reproduced_and_what_it_makes_false_counts_as_not() {
        let set = |rule| Claim { set_by: Some("material".into()), ..claim(rule, &[]) };
        for (rule, verdict) in [(1.0, Verdict::FailsByBench), (5.0, Verdict::SetByBench)] {
            let rule = Rule::AtMost(rule);
            assert_eq!(set(rule.clone()).verdict(&metrics()), verdict);
            assert_eq!(set(rule.clone()).rule_outcome(&metrics()), claim(rule, &[]).verdict(&metrics()));
        }
        assert_eq!(set(Rule::SmallerThan("c".into())).verdict(&metrics()), Verdict::NotMeasured);
    }

    #[test]
    fn an_interval_on_both_sides_of_a_rule_decides_nothing() {
        let of = |low: f64, high: f64| {
            let all = [("a", 2.0), ("a.low", low), ("a.high", high)];
            let metrics = all.map(|(id, v)| Expected::default().judge(Metric::new(id, v, "")));
            claim(Rule::AtLeast(1.5), &[]).verdict(&metrics)
        };
        assert_eq!(of(1.0, 3.0), Verdict::Undetermined);
        assert_eq!(of(1.8, 2.2), Verdict::Reproduces);
    }

    #[test]
    fn a_number_is_compared_with_a_multiple_of_another_and_with_the_outside_of_a_range() {
        let verdict = |rule| claim(rule, &[]).verdict(&metrics());
        assert_eq!(verdict(Rule::AtMostTimes(0.7, "b".into())), Verdict::Reproduces);
        assert_eq!(verdict(Rule::AtMostTimes(0.6, "b".into())), Verdict::Fails);
        assert_eq!(verdict(Rule::AtMostTimes(0.6, "c".into())), Verdict::NotMeasured);
        assert_eq!(verdict(Rule::Outside([1.0, 1.5])), Verdict::Reproduces);
        assert_eq!(verdict(Rule::Outside([1.0, 2.5])), Verdict::Fails);
    }

    #[test]
    fn a_sentence_of_two_parts_holds_when_both_do() {
        let with = |limit| Claim {
            and: vec![Part { metric: "d".into(), rule: Rule::AtMost(limit) }],
            ..claim(Rule::AtMost(2.0), &[])
        };
        assert_eq!([5.0, 3.0].map(|limit| with(limit).verdict(&metrics())), [Verdict::Reproduces, Verdict::Fails]);
        assert_eq!(with(3.0).rules_in_words(), "a ≤ 2 and d ≤ 3");
        assert_eq!(with(3.0).ours(&metrics()), ["2.00", "4.00"]);
    }

    #[test]
    fn a_chain_holds_when_every_link_does() {
        let chain = |ids: [&str; 2]| claim(Rule::Ascending(ids.map(str::to_owned).into()), &[]).verdict(&metrics());
        assert_eq!(chain(["b", "d"]), Verdict::Reproduces);
        assert_eq!(chain(["d", "b"]), Verdict::Fails);
        assert_eq!(chain(["b", "c"]), Verdict::NotMeasured);
    }

    #[test]
    fn a_claim_of_several_numbers_fails_by_one_and_is_open_when_only_good_ones_are_there() {
        assert_eq!(claim(Rule::AtMost(2.5), &["b"]).verdict(&metrics()), Verdict::Fails);
        assert_eq!(claim(Rule::AtMost(2.5), &["c"]).verdict(&metrics()), Verdict::NotMeasured);
        assert_eq!(claim(Rule::AtMost(3.5), &["b"]).verdict(&metrics()), Verdict::Reproduces);
        assert_eq!(claim(Rule::AtMost(1.0), &["c"]).verdict(&metrics()), Verdict::Fails);
    }
}
