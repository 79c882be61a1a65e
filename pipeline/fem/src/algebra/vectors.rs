//! Sums over vectors, in the order of their entries.
//!
//! Stands on: nothing. Never knows: what an entry stands for.

/// a · b, summed from the first entry to the last.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// sum += scale · part, of equal length or an empty part.
pub(crate) fn add(sum: &mut [f64], scale: f64, part: &[f64]) {
    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += scale * part);
}
