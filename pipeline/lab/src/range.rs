//! Ranges: numbers that people write, against what their unit allows, so that a slip of unit breaks loudly.
//!
//! Stands on: nothing. Never knows: a file, a line, what the number is for.

/// What is wrong with an entry: the path of its key, and the three parts of the message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// The path of the key, as in `trial.2.offset`.
    pub key: String,
    /// What and where, with number and unit.
    pub what: String,
    /// Measured against limit.
    pub why: String,
    /// The next move.
    pub act: String,
}

/// Whether an entry is as it may be.
pub type Checked = Result<(), Found>;

/// That `value` (in `unit`, which may be empty) lies in low ..= high; NaN does not.
///
/// # Errors
/// [`Found`] names the key, the value and the range.
pub fn within(key: &str, value: f64, low: f64, high: f64, unit: &str) -> Checked {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let gap = if unit.is_empty() { "" } else { " " };
    let what = format!("{key} = {value}{gap}{unit} is out of range");
    let why = format!("the range is {low} to {high}{gap}{unit}; numbers are in SI units");
    found(key, what, &why, "convert the number to SI, or correct it")
}

/// A finding.
///
/// # Errors
/// Always: the finding.
pub fn found(key: &str, what: impl Into<String>, why: &str, act: &str) -> Checked {
    Err(Found { key: key.to_owned(), what: what.into(), why: why.to_owned(), act: act.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_out_of_its_range_is_named_with_both_and_a_hole_is_in_none() {
        let found = within("solid.density", 1.07, 100.0, 3e4, "kg/m³").unwrap_err();
        assert_eq!(found.what, "solid.density = 1.07 kg/m³ is out of range");
        assert!(found.why.starts_with("the range is 100 to 30000 kg/m³"));
        assert!(within("x", f64::NAN, -1.0, 1.0, "").is_err() && within("x", 1.0, -1.0, 1.0, "").is_ok());
    }
}
