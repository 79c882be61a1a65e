//! Known deviations of the bench from real instruments: quantities that may lie outside of the measured range, each with its reason. Anything else
//! outside fails `rig check`, and with it `just all`.

use std::fmt::Write;

use serde::Deserialize;

use super::Comparison;

/// A quantity that is known to lie outside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Deviation {
    /// The words with which its name begins.
    quantity: String,
    reason: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Page {
    deviation: Vec<Deviation>,
}

/// The list that comes with the bench.
pub(crate) fn known_deviations() -> Vec<Deviation> {
    let page: Page = toml::from_str(include_str!("known_deviations.toml")).expect("a test reads the list");
    page.deviation
}

/// The comparisons that lie outside the measured range and that no deviation names.
pub(crate) fn unexplained_comparisons<'a>(
    comparisons: &'a [Comparison],
    deviations: &[Deviation],
) -> Vec<&'a Comparison> {
    let named = |comparison: &Comparison| deviations.iter().any(|deviation| deviation.names_quantity(comparison));
    comparisons.iter().filter(|comparison| !comparison.is_inside() && !named(comparison)).collect()
}

/// A line for each known deviation whose quantity was compared: the reason, or that it deviates no longer.
pub(crate) fn explanation_text(comparisons: &[Comparison], deviations: &[Deviation]) -> String {
    let mut text = String::new();
    for deviation in deviations {
        let mut compared = comparisons.iter().filter(|comparison| deviation.names_quantity(comparison)).peekable();
        if compared.peek().is_none() {
            continue;
        }
        let outside = compared.any(|comparison| !comparison.is_inside());
        let word = if outside { &*deviation.reason } else { "inside by now: remove it from known_deviations.toml" };
        writeln!(text, "known deviation, {}: {word}", deviation.quantity).expect("a string takes any text");
    }
    text
}

impl Deviation {
    fn names_quantity(&self, comparison: &Comparison) -> bool {
        comparison.quantity.starts_with(&self.quantity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comparison(quantity: &str, bench: f64) -> Comparison {
        Comparison::new(quantity, [0.0, 1.0], [0.5, bench])
    }

    #[test]
    fn every_known_deviation_has_a_reason() {
        assert!(
            known_deviations().iter().all(|deviation| !deviation.quantity.is_empty() && !deviation.reason.is_empty())
        );
    }

    #[test]
    fn what_lies_outside_without_an_entry_is_unexplained() {
        let known = [Deviation { quantity: "force".into(), reason: "it bends far".into() }];
        let all = [comparison("force at 1 Hz", 2.0), comparison("noise", 2.0), comparison("drift", 0.9)];
        let names: Vec<&str> = unexplained_comparisons(&all, &known).iter().map(|c| &*c.quantity).collect();
        assert_eq!(names, ["noise"]);
    }

    #[test]
    fn an_entry_is_explained_and_one_that_deviates_no_longer_is_named() {
        let known = |quantity: &str| Deviation { quantity: quantity.into(), reason: "it bends far".into() };
        let known = [known("force"), known("noise"), known("not compared")];
        let text = explanation_text(&[comparison("force at 1 Hz", 2.0), comparison("noise", 0.9)], &known);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "known deviation, force: it bends far");
        assert!(lines.len() == 2 && lines[1].starts_with("known deviation, noise: inside by now"), "{text}");
    }
}
