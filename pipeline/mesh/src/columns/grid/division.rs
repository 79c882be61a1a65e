//! Division: how far rows stand apart, in units of the wall's thickness.

use super::Grading;
use super::stations::Slab;
use crate::columns::sheets::Layers;
use si::Metre;

/// Cells of a strip that holds a chamber, at least, between those beside its ends.
const LEAST_INSIDE: f64 = 2.0;
/// The first cell beside a rib is at most this part of a chamber.
const LARGEST_SHARE: f64 = 0.2;
/// Longest cells where there is no chamber, over the wall's thickness.
pub(super) const SOLID: f64 = 3.0;

/// Rows of a plan: cells in units of a wall's thickness.
pub(super) struct Rows<'a> {
    /// m.
    pub wall: Metre,
    pub grading: &'a Grading,
}

impl Rows<'_> {
    /// Rows between the stations of each slab, as fractions of it.
    pub(crate) fn rows_inside(&self, slabs: &[Slab], layers: &[Option<Layers>]) -> Vec<Vec<f64>> {
        let [beside, between] = self.grading.along.map(|part| part * self.wall);
        let mut layers = layers.iter();
        let rows = slabs.iter().map(|slab| {
            let length = slab.length();
            match holds_chamber(slab, &layers.by_ref().take(slab.strips().count()).collect::<Vec<_>>()) {
                true => graded_fractions(length, beside.min(LARGEST_SHARE * length), between),
                // Long cells: refining through a rib's thickness to third order changed the angle by 0.6 % only.
                false => even_fractions(length / (SOLID * self.wall)),
            }
        });
        rows.collect()
    }
}

/// Whether a slab is hollow over most of its height: a channel through a rib is no chamber that its wall bulges over.
fn holds_chamber(slab: &Slab, layers: &[&Option<Layers>]) -> bool {
    let middle = 0.5 * (slab.from + slab.to);
    let (mut hollow, mut solid) = (0.0, 0.0);
    for ((_, lower), layers) in slab.strips().zip(layers) {
        let height = slab.curve_position(lower + 1, middle) - slab.curve_position(lower, middle);
        match layers {
            Some(layers) if layers.is_hollow() => hollow += height,
            Some(_) => solid += height,
            None => {}
        }
    }
    hollow > solid
}

/// Fractions of a chamber with a short cell at either end.
fn graded_fractions(length: Metre, beside: Metre, longest: Metre) -> Vec<f64> {
    // Short cells at both ends: the error of a thin tail's angle lay at the junction of rib and wall and in the
    // boundary layers beside it; refining along the chamber alone to third order changed the angle by 2.4 to 4.6 %.
    let pieces = ((length - 2.0 * beside) / longest).ceil().max(LEAST_INSIDE);
    let fraction = |n: usize| (beside + (length - 2.0 * beside) * n as f64 / pieces) / length;
    (0..=pieces as usize).map(fraction).collect()
}

/// Fractions that divide a length of so many cells evenly.
pub(super) fn even_fractions(cells: f64) -> Vec<f64> {
    let pieces = cells.ceil().max(1.0) as usize;
    (1..pieces).map(|n| n as f64 / pieces as f64).collect()
}
