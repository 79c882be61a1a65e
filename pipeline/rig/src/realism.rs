//! Realism: what short runs of the bench's instruments show, beside what was measured on real ones.
//!
//! The valve and the load cell alone, and the forces of recordings in water where they lie there. The measured figures are those of FACTS; where it gives one number
//! without a spread, the spread here says why. Everything on our side is of the virtual bench.
//!
//! Stands on: the valve, the instruments, `lab`. Never knows: the screen.

mod cell;
mod valve;
mod water;

use std::fmt::Write;
use std::path::Path;

use crate::fault::Fault;
use crate::settings::Settings;
use crate::specimens::ALL;

/// One quantity, measured on real instruments and on ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What, with its unit.
    pub quantity: String,
    /// Lowest and highest that real instruments showed.
    pub measured: [f64; 2],
    /// Lowest and highest of ours, over levels or seeds.
    pub ours: [f64; 2],
}

impl Figure {
    /// A figure of which ours is a range.
    pub fn new(quantity: impl Into<String>, measured: [f64; 2], ours: [f64; 2]) -> Self {
        Self { quantity: quantity.into(), measured, ours }
    }

    /// Whether ours lies within what was measured.
    pub fn inside(&self) -> bool {
        self.measured[0] <= self.ours[0] && self.ours[1] <= self.measured[1]
    }
}

/// Lowest and highest of `values`.
fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// To the digits that were measured.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Every figure, in the order of FACTS.
pub fn figures(set: &Settings) -> Vec<Figure> {
    let mut figures = valve::figures(&set.valve);
    figures.extend(cell::figures(set));
    figures
}

/// The figures, and those of the recordings under `raw` where there are some.
///
/// # Errors
/// [`Fault`] when a recording of the bench cannot be read.
pub fn with_recordings(set: &Settings, raw: &Path) -> Result<Vec<Figure>, Fault> {
    let mut all = figures(set);
    all.extend(water::figures(raw, &ALL.iter().map(|specimen| specimen.name).collect::<Vec<_>>())?);
    Ok(all)
}

/// The figures as CSV, with the same bytes every time.
pub fn csv(figures: &[Figure]) -> String {
    let mut text = String::from("# virtual bench beside real instruments\n");
    text.push_str("quantity,measured_low,measured_high,ours_low,ours_high,inside\n");
    for f in figures {
        let ([low, high], [from, to], inside) = (f.measured.map(rounded), f.ours, f.inside());
        writeln!(text, "{},{low},{high},{from:.4},{to:.4},{inside}", f.quantity).expect("a string takes any text");
    }
    text
}

/// The figures as a person reads them, a line each.
pub fn table(figures: &[Figure]) -> String {
    let mut text = format!("{:<52} {:>17} {:>19}\n", "quantity (virtual bench)", "measured", "ours");
    for f in figures {
        let word = if f.inside() { "inside" } else { "OUTSIDE" };
        let measured = format!("{} to {}", rounded(f.measured[0]), rounded(f.measured[1]));
        let ours = format!("{:.3} to {:.3}", f.ours[0], f.ours[1]);
        writeln!(text, "{:<52} {measured:>17} {ours:>19}  {word}", f.quantity).expect("a string takes any text");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_of_the_bench_lies_within_what_was_measured() {
        let outside: Vec<Figure> = figures(&Settings::built_in()).into_iter().filter(|f| !f.inside()).collect();
        assert!(outside.is_empty(), "{}", table(&outside));
    }

    #[test]
    fn a_valve_that_is_too_slow_is_found() {
        let mut set = Settings::built_in();
        set.valve.fill *= 2.0;
        assert!(figures(&set).iter().any(|f| !f.inside() && f.quantity.contains("within 5 %")));
    }

    #[test]
    fn the_same_figures_come_again() {
        let set = Settings::built_in();
        assert_eq!(csv(&figures(&set)), csv(&figures(&set)));
    }
}
