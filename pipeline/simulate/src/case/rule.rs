//! A rule between entries of a case.

use lab::range::{Checked, violation};

/// An error that states the rule where it does not hold.
pub(super) fn require(key: &str, holds: bool, rule: &str) -> Checked {
    if holds {
        return Ok(());
    }
    let message = format!("`{key}` cannot be followed");
    violation(key, message, rule, "correct the entry")
}
