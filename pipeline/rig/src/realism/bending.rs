//! Comparison of the thin-walled tail with the photograph of a real one at 250 mbar: its end turned by some 70°, its filled side bulging between
//! the ribs, its slack side folded inwards near the clamp.

use std::path::Path;

use diagnostics::Result;
use lab::truth::{self, TrueInflation};
use mesh::wall::buckling_pressure;
use si::{MILLIBAR, MILLIMETRE};

use super::{Comparison, range};

/// The tail with the walls of the photograph.
const NAME: &str = "marlin";
/// Turn of the end, degrees: 60 to 75 by the photograph, taken at 250 mbar, of which the droop of the bench's valve leaves 240.
const TURN: [f64; 2] = [55.0, 75.0];
/// Depth of the fold and height of the bulges: from what can be seen at all to the half-width of the tail, mm.
const FOLD: [f64; 2] = [2.0, 18.0];
/// Pressure at which the wall folds: below that of the photograph; walls that bend as far hardly dent at 150 mbar
/// ([`crate::specimens`]), mbar.
const FOLDS: [f64; 2] = [150.0, 250.0];

/// Comparisons of the recording under `raw`, over both sides; none where the tail was not recorded.
///
/// # Errors
/// When its ground truth cannot be read.
pub(super) fn comparisons(raw: &Path) -> Result<Vec<Comparison>> {
    let file = raw.join(NAME).join(lab::folder::TRUTH);
    if !file.is_file() {
        return Ok(Vec::new());
    }
    let sides = truth::read(&file)?.inflation;
    let last = |of: fn(&TrueInflation) -> &Vec<f64>, unit: f64| {
        range(sides.iter().filter_map(|side| of(side).last()).map(|value| value.abs() / unit))
    };
    // a wall that does not fold has its critical pressure nowhere: outside
    let folds = |side: &TrueInflation| buckling_pressure(&side.pressure, &side.dent).unwrap_or(f64::INFINITY);
    let degree = 1f64.to_radians();
    Ok(vec![
        Comparison::new("turn of the end at the highest pressure, marlin (°)", TURN, last(|s| &s.rotation, degree)),
        Comparison::new("bulge of the filled side there (mm)", FOLD, last(|s| &s.bulge, MILLIMETRE)),
        Comparison::new("fold of the slack side there (mm)", FOLD, last(|s| &s.dent, MILLIMETRE)),
        Comparison::new("pressure at which it folds (mbar)", FOLDS, range(sides.iter().map(|s| folds(s) / MILLIBAR))),
    ])
}
