//! Samples of the search distribution, within the unit cube that the bounds are scaled to.

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::State;
use crate::Bounds;

/// How often a sample outside of the cube is drawn again.
const DRAWS: usize = 100;

/// The `population` points of the state's generation, in the unit cube or, after [`DRAWS`] draws, beyond it.
///
/// The seed chooses the generator and the generation its stream, so a generation does not depend on how many numbers those before
/// it have drawn, and a saved state continues bit for bit.
pub(super) fn population(state: &State, seed: u64, population: usize) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(state.generation);
    let (axes, lengths) = state.axes();
    let mean = DVector::from_column_slice(&state.mean);
    let mut point = || -> Vec<f64> {
        let y = &axes * DVector::from_fn(mean.len(), |i, _| lengths[i] * normal(&mut rng));
        (&mean + state.sigma * y).as_slice().to_vec()
    };
    let inside = |at: &Vec<f64>| at.iter().all(|v| (0.0..=1.0).contains(v));
    // Bounds by resampling: a penalty needs a weight and would rank infeasible points among the feasible ones; clamping every sample
    // would pile the distribution up on the faces. Clamping is left for a mean in a corner, where resampling may not end.
    let sample = |_| {
        let mut at = point();
        for _ in 1..DRAWS {
            if inside(&at) {
                break;
            }
            at = point();
        }
        at
    };
    (0..population).map(sample).collect()
}

/// A point of the box in the unit cube.
pub(super) fn to_cube(bounds: &Bounds, at: &[f64]) -> Vec<f64> {
    (0..at.len()).map(|i| (at[i] - bounds.low[i]) / (bounds.high[i] - bounds.low[i])).collect()
}

/// A point of the unit cube in the box; beyond the cube, the nearest point of the box.
pub(super) fn from_cube(bounds: &Bounds, at: &[f64]) -> Vec<f64> {
    let free: Vec<f64> = (0..at.len()).map(|i| bounds.low[i] + at[i] * (bounds.high[i] - bounds.low[i])).collect();
    bounds.clamp(&free)
}

/// A standard normal number, by Box and Muller.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let mut open = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let (radius, angle) = ((-2.0 * open().ln()).sqrt(), std::f64::consts::TAU * open());
    radius * angle.cos()
}
