//! Ordinary kriging with a wide Gaussian, close to polynomial interpolation [krige1951].

use nalgebra::{DMatrix, DVector};

use super::load::Load;

/// Correlation length: the width of the Gaussian, in units of [`Load::distance_to`].
const WIDTH: f64 = 2.0;
/// Nugget, relative to the variance: it keeps weights small where shapes lie close together.
const NOISE: f64 = 1e-9;
/// Largest sum of absolute weights: above it the prediction extrapolates, and the nearest shape is the better initial guess.
const STRETCHED: f64 = 6.0;

/// Kriging weights of the shapes at `places` for `load`; they sum to one. None where they would extrapolate.
pub(super) fn weights(places: &[Load], load: &Load) -> Option<DVector<f64>> {
    let n = places.len();
    let alike = |a: &Load, b: &Load| (-0.5 * (a.distance_to(b) / WIDTH).powi(2)).exp();
    let among = DMatrix::from_fn(n, n, |i, j| alike(&places[i], &places[j]) + if i == j { NOISE } else { 0.0 });
    let factor = among.cholesky()?;
    let (towards, level) =
        (factor.solve(&DVector::from_fn(n, |i, _| alike(&places[i], load))), factor.solve(&DVector::repeat(n, 1.0)));
    // With a sum of one, and not simple kriging: between distant shapes its weights fade, and the prediction would fall
    // back to rest.
    let weights = &towards + &level * ((1.0 - towards.sum()) / level.sum());
    (weights.iter().map(|w| w.abs()).sum::<f64>() < STRETCHED).then_some(weights)
}
