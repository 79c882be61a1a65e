//! Checks of places: planes, boxes and vectors.

use lab::range::{Checked, within};

use super::Place;
use super::rule::require;

/// Largest coordinate, m.
pub(super) const FAR: f64 = 10.0;

pub(super) fn check_place(key: &str, place: Option<Place>) -> Checked {
    match place {
        None => require(key, false, "it has either plane = { x = 0.0 } (or y, or z) or box = { low = …, high = … }"),
        Some(Place::Plane(_, offset)) => within(&format!("{key}.plane"), offset, -FAR..=FAR, "m"),
        Some(Place::Block(block)) => {
            check_vector(&format!("{key}.box.low"), &block.low, FAR, "m")?;
            check_vector(&format!("{key}.box.high"), &block.high, FAR, "m")?;
            let ordered = (0..3).all(|k| block.low[k] <= block.high[k]);
            require(&format!("{key}.box"), ordered, "low is not above high on any axis")
        }
    }
}

pub(super) fn check_vector(key: &str, value: &[f64; 3], limit: f64, unit: &str) -> Checked {
    value.iter().enumerate().try_for_each(|(i, x)| within(&format!("{key}.{i}"), *x, -limit..=limit, unit))
}
