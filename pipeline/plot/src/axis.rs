//! Axes: a label, a unit, a scale, and the range that is shown.
//!
//! Stands on: the error type. Never knows: what is drawn over it, or how long it is on paper.

use crate::PlotError;

/// How a number finds its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences, equal lengths.
    Linear,
    /// Equal ratios, equal lengths.
    Log,
}

impl Scale {
    /// The number in which places are even: itself, or its decimal logarithm.
    pub(crate) fn even(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }

    /// The number at an even place.
    pub(crate) fn value(self, even: f64) -> f64 {
        match self {
            Self::Linear => even,
            Self::Log => 10f64.powf(even),
        }
    }
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What is shown.
    pub label: String,
    /// Its unit; empty for a number without one.
    pub unit: String,
    /// How numbers find their place.
    pub scale: Scale,
    /// Both ends; without it the axis holds what is drawn.
    pub range: Option<(f64, f64)>,
    /// Whether its numbers and its label are written; `false` where the panel below repeats them.
    pub written: bool,
}

impl Axis {
    /// A linear axis that holds what is drawn.
    pub fn linear(label: &str, unit: &str) -> Self {
        let (label, unit) = (label.to_owned(), unit.to_owned());
        Self { label, unit, scale: Scale::Linear, range: None, written: true }
    }

    /// A logarithmic axis that holds what is drawn.
    pub fn log(label: &str, unit: &str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label, unit) }
    }

    /// The same axis with both ends set.
    pub fn range(self, low: f64, high: f64) -> Self {
        Self { range: Some((low, high)), ..self }
    }

    /// The same axis with its ticks alone, where the panel below has its numbers.
    pub fn unwritten(self) -> Self {
        Self { written: false, ..self }
    }

    /// Label and unit: `time (s)`.
    pub(crate) fn title(&self) -> String {
        match self.unit.as_str() {
            "" => self.label.clone(),
            unit => format!("{} ({unit})", self.label),
        }
    }

    /// The ends that are shown: those that were set, or those of the values with a margin (a part of the range).
    pub(crate) fn ends(&self, values: impl Iterator<Item = f64>, margin: f64) -> Result<(f64, f64), PlotError> {
        let (low, high) = match self.range {
            Some(range) => range,
            None => values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v))),
        };
        if self.scale == Scale::Log && low <= 0.0 {
            return Err(PlotError::NotPositive { axis: self.label.clone(), value: low });
        }
        let empty = PlotError::Range { axis: self.label.clone(), low, high };
        match self.range {
            _ if !(low.is_finite() && high.is_finite()) => Err(empty),
            Some(_) if low < high => Ok((low, high)),
            Some(_) => Err(empty),
            None => Ok(self.widened(low, high, margin)),
        }
    }

    fn widened(&self, low: f64, high: f64, margin: f64) -> (f64, f64) {
        let (a, b) = (self.scale.even(low), self.scale.even(high));
        let pad = match b - a {
            0.0 if a == 0.0 || self.scale == Scale::Log => 0.5,
            0.0 => 0.1 * a.abs(),
            length => margin * length,
        };
        (self.scale.value(a - pad), self.scale.value(b + pad))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_what_is_drawn_with_its_margin() {
        let (low, high) = Axis::linear("x", "m").ends([3.0, 1.0, 2.0].into_iter(), 0.1).unwrap();
        assert!((low - 0.8).abs() < 1e-12 && (high - 3.2).abs() < 1e-12);
    }

    #[test]
    fn a_logarithmic_axis_refuses_zero() {
        let refused = Axis::log("loss", "").ends([0.0, 1.0].into_iter(), 0.0);
        assert!(matches!(refused, Err(PlotError::NotPositive { value: 0.0, .. })));
    }

    #[test]
    fn an_axis_with_one_value_still_has_a_length() {
        for value in [0.0, -4.0, 1e-9] {
            let (low, high) = Axis::linear("x", "m").ends([value].into_iter(), 0.05).unwrap();
            assert!(low < value && value < high);
        }
    }

    #[test]
    fn an_axis_with_nothing_on_it_is_refused() {
        assert!(matches!(Axis::linear("x", "m").ends([].into_iter(), 0.0), Err(PlotError::Range { .. })));
    }
}
