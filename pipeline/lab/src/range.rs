//! Ranges: numbers of a card or case against the range of their unit, so that a wrong unit is found.

use std::ops::RangeInclusive;

/// An entry that violates its range: the path of its key, and the three parts of the message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The path of the key, as in `trial.2.offset`.
    pub key: String,
    /// What and where, with number and unit.
    pub what: String,
    /// Measured against limit.
    pub why: String,
    /// What to do.
    pub action: String,
}

/// The result of a check.
pub type Checked = Result<(), Violation>;

/// Checks that `value` (in `unit`, which may be empty) lies in the range; NaN does not.
///
/// # Errors
/// [`Violation`] names the key, the value and the range.
pub fn within(key: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    let blank = if unit.is_empty() { "" } else { " " };
    // Beyond this, digits without an exponent are not legible.
    let number = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
    let defect = format!("{key} = {number}{blank}{unit} is out of range");
    let (low, high) = range.into_inner();
    let reason = format!("the range is {low} to {high}{blank}{unit}; numbers are in SI units");
    violation(key, defect, &reason, "convert the number to SI, or correct it")
}

/// A failed check.
///
/// # Errors
/// Always: the [`Violation`].
pub fn violation(key: &str, what: impl Into<String>, why: &str, action: &str) -> Checked {
    Err(Violation { key: key.to_owned(), what: what.into(), why: why.to_owned(), action: action.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_out_of_its_range_and_nan_are_refused() {
        let found = within("solid.density", 1.07, 100.0..=3e4, "kg/m³").unwrap_err();
        assert_eq!(found.what, "solid.density = 1.07 kg/m³ is out of range");
        assert!(found.why.starts_with("the range is 100 to 30000 kg/m³"));
        let huge = |value: f64| within("x", value, 0.0..=1.0, "m").unwrap_err().what;
        assert_eq!([999e12, 1e15].map(huge), ["999000000000000", "1e15"].map(|x| format!("x = {x} m is out of range")));
        assert!(within("x", f64::NAN, -1.0..=1.0, "").is_err() && within("x", 1.0, -1.0..=1.0, "").is_ok());
    }
}
