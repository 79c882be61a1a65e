//! Comparison of the bench's instruments with measurements of real ones.
//!
//! Short runs of the valve and the load cell, and the forces of recordings in water where there are some. Where a measurement is a single number
//! without a range, the range used is justified at its constant. The drag of the bench's water was chosen so that mean forces agree with
//! those measured; their comparison is no independent test of it.

mod bending;
mod cell;
mod deviation;
mod silicone;
mod valve;
mod water;

use std::fmt::Write;
use std::path::Path;

use diagnostics::Result;

use crate::settings::Settings;
use crate::specimens::ALL;
pub(crate) use deviation::{explanation_text, known_deviations, unexplained_comparisons};

/// One quantity of real instruments and of the bench.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Comparison {
    /// Its name and unit.
    pub(crate) quantity: String,
    /// Measured range of real instruments.
    pub(crate) measured: [f64; 2],
    /// Range of the bench over levels or seeds.
    pub(crate) bench: [f64; 2],
}

impl Comparison {
    /// A comparison of two ranges.
    pub(crate) fn new(quantity: impl Into<String>, measured: [f64; 2], bench: [f64; 2]) -> Self {
        Self { quantity: quantity.into(), measured, bench }
    }

    /// Whether the bench's range is inside the measured one.
    pub(crate) fn is_inside(&self) -> bool {
        self.measured[0] <= self.bench[0] && self.bench[1] <= self.measured[1]
    }
}

/// Least and greatest of `values`.
fn range_of(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// Rounded to the digits of the measurements.
fn rounded_value(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// All comparisons of the instruments.
pub(crate) fn instrument_comparisons(set: &Settings) -> Vec<Comparison> {
    let mut comparisons = valve::valve_comparisons(&set.valve);
    comparisons.extend(cell::cell_comparisons(set));
    comparisons.extend(silicone::silicone_comparisons(set));
    comparisons
}

/// All comparisons, with those of the recordings under `raw` where there are some.
///
/// # Errors
/// When a recording of the bench cannot be read.
pub(crate) fn with_recordings(set: &Settings, raw: &Path) -> Result<Vec<Comparison>> {
    let mut comparisons = instrument_comparisons(set);
    comparisons.extend(water::water_comparisons(raw, &ALL.iter().map(|specimen| &*specimen.name).collect::<Vec<_>>())?);
    comparisons.extend(bending::bending_comparisons(raw)?);
    Ok(comparisons)
}

/// The comparisons as CSV with fixed digits.
pub(crate) fn comparisons_csv(comparisons: &[Comparison]) -> String {
    let mut text = String::from("# virtual bench compared with real instruments\n");
    text.push_str("quantity,measured_low,measured_high,bench_low,bench_high,inside\n");
    for f in comparisons {
        let ([low, high], [from, to], inside) = (f.measured.map(rounded_value), f.bench, f.is_inside());
        writeln!(text, "{},{low},{high},{from:.4},{to:.4},{inside}", f.quantity).expect("a string takes any text");
    }
    text
}

/// The comparisons as text, one a line.
pub(crate) fn comparisons_table(comparisons: &[Comparison]) -> String {
    let mut text = format!("{:<52} {:>17} {:>19}\n", "quantity", "measured", "bench");
    for f in comparisons {
        let word = if f.is_inside() { "inside" } else { "OUTSIDE" };
        let measured = format!("{} to {}", rounded_value(f.measured[0]), rounded_value(f.measured[1]));
        let bench = format!("{:.3} to {:.3}", f.bench[0], f.bench[1]);
        writeln!(text, "{:<52} {measured:>17} {bench:>19}  {word}", f.quantity).expect("a string takes any text");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_of_the_bench_is_inside_the_measured_range() {
        let outside: Vec<Comparison> =
            instrument_comparisons(&Settings::built_in()).into_iter().filter(|f| !f.is_inside()).collect();
        assert!(outside.is_empty(), "{}", comparisons_table(&outside));
    }

    #[test]
    fn a_valve_that_is_too_slow_is_detected() {
        let mut set = Settings::built_in();
        set.valve.fill *= 2.0;
        assert!(instrument_comparisons(&set).iter().any(|f| !f.is_inside() && f.quantity.contains("within 5 %")));
    }

    #[test]
    fn a_comparison_is_shown_with_both_ranges_and_a_word() {
        let two =
            [Comparison::new("a (Hz)", [1.8, 2.00004], [1.9, 1.95]), Comparison::new("b", [0.0, 1.0], [0.5, 1.5])];
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let lines: Vec<Vec<String>> = comparisons_table(&two).lines().map(words).collect();
        assert_eq!(lines[1], ["a", "(Hz)", "1.8", "to", "2", "1.900", "to", "1.950", "inside"]);
        assert_eq!(lines[2].last().unwrap(), "OUTSIDE");
        assert_eq!(comparisons_csv(&two).lines().nth(2), Some("a (Hz),1.8,2,1.9000,1.9500,true"));
    }

    #[test]
    fn instruments_and_silicone_are_compared_in_many_quantities() {
        let all = instrument_comparisons(&Settings::built_in());
        let of = |word: &str| all.iter().filter(|c| c.quantity.starts_with(word)).count();
        let counts = ["silicone", "tank", "fill"].map(of);
        assert!(counts[0] == 2 && counts[1..].iter().all(|count| *count >= 3), "{}", comparisons_table(&all));
    }

    #[test]
    fn the_comparisons_are_reproducible() {
        let set = Settings::built_in();
        assert_eq!(comparisons_csv(&instrument_comparisons(&set)), comparisons_csv(&instrument_comparisons(&set)));
    }
}
