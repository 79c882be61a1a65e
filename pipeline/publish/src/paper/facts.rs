//! Names that the paper may use: numbers, claims, figures, tables, citations, tests.

use std::collections::{BTreeMap, BTreeSet};

use crate::claims::Claim;
use crate::expected::MetricEntry;

/// All names that the source may use.
#[derive(Debug, Clone, Default)]
pub struct Facts {
    /// The numbers of this profile.
    pub metrics: Vec<MetricEntry>,
    /// Names of the numbers of any profile.
    pub known: BTreeSet<String>,
    /// The claims.
    pub claims: Vec<Claim>,
    /// Every figure that the study makes.
    pub figures: Vec<Made>,
    /// Every table that the study makes; its CSV.
    pub tables: Vec<Made>,
    /// Keys of refs.bib.
    pub cited: BTreeSet<String>,
    /// Names of the project's tests; none where its programs lie elsewhere.
    pub tests: Option<BTreeSet<String>>,
    /// Whether all of them must exist: the paper profile, where it has records.
    pub strict: bool,
    /// Where the numbers are from.
    pub origin: Origin,
}

/// Where the numbers of a paper are from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Origin {
    /// The records of a profile that is not the paper's.
    #[default]
    OtherProfile,
    /// Numbers that are tracked with the source: how many from each of its sources.
    Tracked(BTreeMap<String, usize>),
}

/// A figure or table, and its text where this profile made it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// Its name.
    pub name: String,
    /// CSV of a table; anything for a figure; nothing where it was not made.
    pub text: Option<String>,
    /// Whether another recipe than that of the paper makes it: until then its place is marked.
    pub elsewhere: bool,
}

/// The keys of a BibTeX file.
pub(crate) fn cited_keys(bib: &str) -> BTreeSet<String> {
    let key = |line: &str| {
        let (_, entry) = line.trim_start().strip_prefix('@')?.split_once('{')?;
        Some(entry.split_once(',')?.0.trim().to_owned())
    };
    bib.lines().filter_map(key).collect()
}

/// The names of the tests in a Rust source.
pub(crate) fn test_names(source: &str) -> BTreeSet<String> {
    let lines: Vec<&str> = source.lines().map(str::trim).collect();
    let test_name = |i: usize| {
        let signature = lines[i + 1..].iter().take(3).find(|line| line.starts_with("fn "))?;
        Some(signature.strip_prefix("fn ")?.split_once('(')?.0.to_owned())
    };
    (0..lines.len()).filter(|&i| lines[i] == "#[test]").filter_map(test_name).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::claims::Rule;
    use crate::expected::Expected;
    use workflow::metric::Metric;

    /// A number, two claims on it, a figure, a table, a reference and a test.
    pub fn facts() -> Facts {
        let claim = |name: &str, limit| Claim {
            name: name.into(),
            says: format!("it is {name}"),
            metric: "a.rmse_mm".into(),
            also: Vec::new(),
            rule: Rule::AtMost(limit),
            and: Vec::new(),
            set_by: None,
            published: "1 mm".into(),
            of_its_tail_alone: false,
        };
        let set = |name: &str| BTreeSet::from([name.to_owned()]);
        Facts {
            metrics: vec![Expected::default().judge(Metric::new("a.rmse_mm", 0.5, "mm"))],
            known: set("b.known"),
            claims: vec![claim("good", 1.0), claim("bad", 0.1)],
            figures: vec![Made { name: "tail".into(), text: Some(String::new()), elsewhere: false }],
            tables: vec![Made {
                name: "trials".into(),
                text: Some("a,b: ours (s),b: published (s)\nx,1,2\n".into()),
                elsewhere: false,
            }],
            cited: set("du2021"),
            tests: Some(set("a_test_that_is")),
            strict: false,
            origin: Origin::OtherProfile,
        }
    }

    #[test]
    fn keys_and_tests_are_found_by_name() {
        assert_eq!(cited_keys("% x\n@book{a1, title = {b}}\n"), BTreeSet::from(["a1".to_owned()]));
        let source = "#[test]\n    fn it_is_so() {\n}\nfn no_test() {}\n";
        assert_eq!(test_names(source), BTreeSet::from(["it_is_so".to_owned()]));
    }
}
