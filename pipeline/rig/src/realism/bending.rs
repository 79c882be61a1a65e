//! Comparison of the thin-walled tail with the photograph of a real one at 250 mbar: its end turned by some 70°, its filled side bulging between
//! the ribs, its slack side folded inwards near the clamp.

use std::path::Path;

use diagnostics::Result;
use lab::truth::{self, TrueInflation};
use mesh::wall::buckling_pressure;
use si::{MILLIBAR, MILLIMETRE, Pascal};

use super::{Comparison, range_of};

/// The tail with the walls of the photograph.
const NAME: &str = "nemo";
/// Pressure of the photograph, as the bench's valve settles when 250 mbar are commanded.
const PRESSURE: Pascal = 238.0 * MILLIBAR;
/// Turn of the end, degrees, by the photograph.
const TURN: [f64; 2] = [60.0, 75.0];
/// Depth of the fold and height of the bulges: from what can be seen at all to the half-width of the tail, mm.
const FOLD: [f64; 2] = [2.0, 18.0];
/// Pressure at which the wall folds: below that of the photograph; walls that bend as far hardly dent at 150 mbar
/// ([`crate::specimens`]), mbar.
const FOLDS: [f64; 2] = [150.0, 250.0];

/// Comparisons of the recording under `raw`, over both sides; none where the tail was not recorded.
///
/// # Errors
/// When its ground truth cannot be read.
pub(super) fn bending_comparisons(raw: &Path) -> Result<Vec<Comparison>> {
    let file = raw.join(NAME).join(lab::folder::TRUTH);
    if !file.is_file() {
        return Ok(Vec::new());
    }
    let sides = truth::read(&file)?.inflation;
    let range_at_pressure = |quantity: fn(&TrueInflation) -> &Vec<f64>, unit: f64| {
        range_of(sides.iter().map(|side| at_pressure(&side.pressure, quantity(side)).abs() / unit))
    };
    // a wall that does not fold has its critical pressure nowhere: outside
    let folds = |side: &TrueInflation| buckling_pressure(&side.pressure, &side.dent).unwrap_or(f64::INFINITY);
    let degree = 1f64.to_radians();
    Ok(vec![
        Comparison::new("turn of the end at 238 mbar, nemo (°)", TURN, range_at_pressure(|s| &s.rotation, degree)),
        Comparison::new("bulge of the filled side there (mm)", FOLD, range_at_pressure(|s| &s.bulge, MILLIMETRE)),
        Comparison::new("fold of the slack side there (mm)", FOLD, range_at_pressure(|s| &s.dent, MILLIMETRE)),
        Comparison::new(
            "pressure at which it folds (mbar)",
            FOLDS,
            range_of(sides.iter().map(|s| folds(s) / MILLIBAR)),
        ),
    ])
}

/// `values` at the pressure of the photograph, linear between rising `pressures` (Pa); the last one where they end below.
fn at_pressure(pressures: &[Pascal], values: &[f64]) -> f64 {
    let upper_index = pressures.partition_point(|p| *p < PRESSURE);
    if upper_index == 0 || upper_index == values.len() {
        return values.get(upper_index).or(values.last()).copied().unwrap_or(0.0);
    }
    let [p, q] = [upper_index - 1, upper_index].map(|i| pressures[i]);
    let part = (PRESSURE - p) / (q - p);
    (1.0 - part) * values[upper_index - 1] + part * values[upper_index]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_the_pressure_of_the_photograph_lies_on_the_line_between_its_neighbours() {
        let mbar = |levels: [f64; 3]| levels.map(|p| p * MILLIBAR);
        let rises = at_pressure(&mbar([0.0, 230.0, 250.0]), &[0.0, 1.0, 2.0]);
        assert!((rises - 1.4).abs() < 1e-12, "{rises}");
        assert_eq!(at_pressure(&mbar([0.0, 100.0, 200.0]), &[0.0, 1.0, 2.0]), 2.0);
        assert_eq!(at_pressure(&mbar([240.0, 250.0, 300.0]), &[3.0, 4.0, 5.0]), 3.0);
    }
}
