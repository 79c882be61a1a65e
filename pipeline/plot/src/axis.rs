//! Axes: a label, a unit, a scale, and the range that is shown.

use crate::PlotError;

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences have equal lengths.
    Linear,
    /// Equal ratios have equal lengths.
    Log,
}

impl Scale {
    /// The quantity that is linear along the axis: the value, or its decimal logarithm.
    pub(crate) fn to_linear(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }

    /// The inverse of [`Scale::to_linear`].
    pub(crate) fn value_of(self, linearised: f64) -> f64 {
        match self {
            Self::Linear => linearised,
            Self::Log => 10f64.powf(linearised),
        }
    }
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the quantity.
    pub label: String,
    /// Its unit; empty for a dimensionless quantity.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Both ends; without it, the range of the data.
    pub range: Option<(f64, f64)>,
    /// Whether it has tick labels and an axis label; `false` where the panel below has them.
    pub tick_labels: bool,
}

impl Axis {
    /// A linear axis with the range of the data.
    pub fn linear(label: &str, unit: &str) -> Self {
        let (label, unit) = (label.to_owned(), unit.to_owned());
        Self { label, unit, scale: Scale::Linear, range: None, tick_labels: true }
    }

    /// A logarithmic axis with the range of the data.
    pub fn log(label: &str, unit: &str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label, unit) }
    }

    /// The same axis with both ends set.
    pub fn range(self, low: f64, high: f64) -> Self {
        Self { range: Some((low, high)), ..self }
    }

    /// The same axis without tick labels and axis label, where the panel below has them.
    pub fn without_tick_labels(self) -> Self {
        Self { tick_labels: false, ..self }
    }

    /// Label and unit: `time (s)`.
    pub(crate) fn full_title(&self) -> String {
        match self.unit.as_str() {
            "" => self.label.clone(),
            unit => format!("{} ({unit})", self.label),
        }
    }

    /// The ends that are shown: those that were set, or those of the values with a margin (a fraction of the range).
    pub(crate) fn shown_ends(&self, values: impl Iterator<Item = f64>, margin: f64) -> Result<(f64, f64), PlotError> {
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
            None => Ok(self.widened_ends(low, high, margin)),
        }
    }

    fn widened_ends(&self, low: f64, high: f64, margin: f64) -> (f64, f64) {
        let (a, b) = (self.scale.to_linear(low), self.scale.to_linear(high));
        let pad = match b - a {
            0.0 if a == 0.0 || self.scale == Scale::Log => 0.5,
            0.0 => 0.1 * a.abs(),
            length => margin * length,
        };
        (self.scale.value_of(a - pad), self.scale.value_of(b + pad))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_is_that_of_the_data_with_a_margin() {
        let (low, high) = Axis::linear("x", "m").shown_ends([3.0, 1.0, 2.0].into_iter(), 0.1).unwrap();
        assert!((low - 0.8).abs() < 1e-12 && (high - 3.2).abs() < 1e-12);
    }

    #[test]
    fn a_logarithmic_axis_refuses_zero() {
        let refused = Axis::log("loss", "").shown_ends([0.0, 1.0].into_iter(), 0.0);
        assert!(matches!(refused, Err(PlotError::NotPositive { value: 0.0, .. })));
    }

    #[test]
    fn an_axis_with_one_value_has_a_positive_range() {
        for value in [0.0, -4.0, 1e-9] {
            let (low, high) = Axis::linear("x", "m").shown_ends([value].into_iter(), 0.05).unwrap();
            assert!(low < value && value < high);
        }
    }

    #[test]
    fn an_axis_without_data_is_refused() {
        assert!(matches!(Axis::linear("x", "m").shown_ends([].into_iter(), 0.0), Err(PlotError::Range { .. })));
    }
}
