//! Rulers: the map from an axis to points of print, and the choice of its ticks.

use crate::axis::Scale;
use crate::text::{number, power_of_ten};

/// An axis between two places on the page (points of print).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ruler {
    /// Linear or logarithmic.
    pub scale: Scale,
    /// The values at both ends.
    pub ends: (f64, f64),
    /// The places of both ends; the second may be the smaller one.
    pub places: (f64, f64),
}

/// The ticks of an axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ticks {
    /// Values with their tick labels.
    pub major: Vec<(f64, String)>,
    /// Values without a label.
    pub minor: Vec<f64>,
}

/// A value this close to an end, as a fraction of the range, counts as inside: round-off must not drop the last tick.
const END_TOLERANCE: f64 = 1e-9;

/// Candidates for the ticks of a logarithmic axis, from many to few: leading digits, and the step in decades.
const FAMILIES: [(&[f64], i32); 8] = [
    (&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], 1),
    (&[1.0, 2.0, 3.0, 5.0], 1),
    (&[1.0, 2.0, 5.0], 1),
    (&[1.0, 3.0], 1),
    (&[1.0], 1),
    (&[1.0], 2),
    (&[1.0], 3),
    (&[1.0], 6),
];

impl Ruler {
    /// The place of a value.
    pub fn place_of(&self, value: f64) -> f64 {
        let linearised = |v| self.scale.to_linear(v);
        let start = linearised(self.ends.0);
        let part = (linearised(value) - start) / (linearised(self.ends.1) - start);
        self.places.0 + part * (self.places.1 - self.places.0)
    }

    /// The value at a place.
    pub fn value_at(&self, place: f64) -> f64 {
        let part = (place - self.places.0) / (self.places.1 - self.places.0);
        let (a, b) = (self.scale.to_linear(self.ends.0), self.scale.to_linear(self.ends.1));
        self.scale.value_of(a + part * (b - a))
    }

    /// Ticks at least `apart` from each other (points of print).
    pub fn ticks(&self, apart: f64) -> Ticks {
        match self.scale {
            Scale::Linear => self.linear_ticks(((self.places.1 - self.places.0).abs() / apart).max(1.0)),
            Scale::Log => self.log_ticks(apart),
        }
    }

    fn linear_ticks(&self, most: f64) -> Ticks {
        let step = nice_step((self.ends.1 - self.ends.0) / most);
        let values = multiples_between(step, self.ends);
        let largest = self.ends.0.abs().max(self.ends.1.abs());
        let text = |v: f64| tick_label(v, step, largest);
        Ticks { major: values.into_iter().map(|v| (v, text(v))).collect(), minor: vec![] }
    }

    fn log_ticks(&self, apart: f64) -> Ticks {
        let (from, to) = (self.ends.0.log10().floor() as i32, self.ends.1.log10().ceil() as i32);
        let family = |digits: &[f64], every: i32| -> Vec<f64> {
            let exponents = (from..=to).filter(|e| e % every == 0);
            let values = exponents.flat_map(|e| digits.iter().map(move |d| d * 10f64.powi(e)));
            values.filter(|v| self.contains(*v)).collect()
        };
        let gap = |pair: &[f64]| (self.place_of(pair[1]) - self.place_of(pair[0])).abs();
        let fits = |values: &Vec<f64>| values.windows(2).all(|pair| gap(pair) >= apart);
        let families = FAMILIES.iter().map(|(digits, every)| family(digits, *every));
        let values = families.into_iter().find(fits).unwrap_or_default();
        if values.len() < 2 {
            return self.linear_ticks(((self.places.1 - self.places.0).abs() / apart).clamp(1.0, 4.0));
        }
        let plain = self.ends.0 >= 1e-3 && self.ends.1 <= 1e4;
        let minor = family(FAMILIES[0].0, 1).into_iter().filter(|v| !values.contains(v) && to - from < 6).collect();
        Ticks { major: values.into_iter().map(|v| (v, log_tick_label(v, plain))).collect(), minor }
    }

    /// Whether a value lies between the ends.
    pub fn contains(&self, value: f64) -> bool {
        let slack = END_TOLERANCE * (self.ends.1 - self.ends.0).abs();
        value >= self.ends.0 - slack && value <= self.ends.1 + slack
    }
}

/// The smallest of 1, 2, 5 × 10ⁿ that is not below a length.
fn nice_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    let digit = [1.0, 2.0, 5.0, 10.0].into_iter().find(|d| d * decade >= least * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * decade
}

/// The multiples of a step between two ends, with a tolerance of 10⁻⁹ of the step.
fn multiples_between(step: f64, (low, high): (f64, f64)) -> Vec<f64> {
    let (from, to) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (from..=to).map(|k| k as f64 * step).collect()
}

/// A tick label: a decimal number while it is short, else a mantissa with a power of ten.
fn tick_label(value: f64, step: f64, largest: f64) -> String {
    let decimals = (-(step * 1.0001).log10().floor()).max(0.0) as usize;
    if value == 0.0 && decimals > 3 {
        return "0".to_owned();
    }
    if decimals <= 3 && largest < 1e5 {
        return number(value, decimals);
    }
    let exponent = largest.log10().floor() as i32;
    let digits = (f64::from(exponent) - (step * 1.0001).log10().floor()).max(0.0) as usize;
    format!("{}·{}", number(value / 10f64.powi(exponent), digits), power_of_ten(exponent))
}

fn log_tick_label(value: f64, plain: bool) -> String {
    let exponent = (value * 1.0001).log10().floor() as i32;
    let digit = (value / 10f64.powi(exponent)).round();
    match (plain, digit) {
        (true, _) => number(value, (-exponent).max(0) as usize),
        (false, 1.0) => power_of_ten(exponent),
        (false, _) => format!("{digit}·{}", power_of_ten(exponent)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: Scale, ends: (f64, f64), length: f64) -> Vec<String> {
        let ruler = Ruler { scale, ends, places: (0.0, length) };
        ruler.ticks(20.0).major.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers_with_equal_digits() {
        assert_eq!(texts(Scale::Linear, (-0.3, 1.1), 100.0), ["0.0", "0.5", "1.0"]);
        assert_eq!(texts(Scale::Linear, (0.0, 250.0), 120.0), ["0", "50", "100", "150", "200", "250"]);
    }

    #[test]
    fn small_numbers_have_a_power_of_ten() {
        assert_eq!(texts(Scale::Linear, (0.0, 2e-6), 60.0), ["0", "1·10⁻⁶", "2·10⁻⁶"]);
    }

    #[test]
    fn a_log_axis_of_a_decade_or_less_has_round_digits() {
        assert_eq!(texts(Scale::Log, (0.1, 1.0), 120.0), ["0.1", "0.2", "0.3", "0.5", "1"]);
        assert_eq!(texts(Scale::Log, (0.1, 1.0), 80.0), ["0.1", "0.2", "0.5", "1"]);
        assert_eq!(texts(Scale::Log, (0.1, 0.4), 150.0), ["0.1", "0.2", "0.3", "0.4"]);
    }

    #[test]
    fn a_log_axis_of_many_decades_has_powers_of_ten() {
        assert_eq!(texts(Scale::Log, (1e-5, 1e-1), 100.0), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"]);
    }

    #[test]
    fn minor_ticks_are_left_out_beyond_six_decades() {
        let minor = |from: f64| Ruler { scale: Scale::Log, ends: (from, 0.1), places: (0.0, 200.0) }.ticks(20.0).minor;
        assert!(!minor(1e-4).is_empty() && minor(1e-9).is_empty());
    }

    #[test]
    fn numbers_from_a_hundred_thousand_on_have_a_power_of_ten() {
        let last = |most: f64| texts(Scale::Linear, (0.0, most), 60.0).pop().unwrap();
        assert_eq!([last(5e4), last(1e5)], ["40000", "1.0·10⁵"]);
    }

    #[test]
    fn a_log_axis_over_a_fraction_of_a_decade_has_linear_steps() {
        assert_eq!(texts(Scale::Log, (0.21, 0.28), 80.0), ["0.22", "0.24", "0.26", "0.28"]);
        let elsewhere = Ruler { scale: Scale::Log, ends: (0.21, 0.28), places: (180.0, 100.0) };
        assert_eq!(elsewhere.ticks(20.0).major.len(), 4);
    }

    #[test]
    fn value_is_the_inverse_of_place() {
        let ruler = Ruler { scale: Scale::Log, ends: (0.02, 3.0), places: (90.0, 10.0) };
        assert!((ruler.value_at(ruler.place_of(0.7)) - 0.7).abs() < 1e-12);
        assert!((ruler.place_of(0.02) - 90.0).abs() < 1e-12);
    }
}
