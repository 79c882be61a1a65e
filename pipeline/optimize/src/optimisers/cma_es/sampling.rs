//! Samples of the search distribution, within the unit cube that the bounds are scaled to.

use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::State;
use crate::Bounds;

/// How often a sample outside of the cube is drawn again.
const DRAWS: usize = 100;

/// The `sampled_population` points of the state's generation, in the unit cube or, after [`DRAWS`] draws, beyond it.
///
/// The seed chooses the generator and the generation its stream, so a generation does not depend on how many numbers those before
/// it have drawn, and a saved state continues bit for bit.
pub(super) fn sampled_population(state: &State, seed: u64, population: usize) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(state.generation);
    let (axes, lengths) = state.principal_axes();
    let mean = DVector::from_column_slice(&state.mean);
    let mut point = || -> Vec<f64> {
        let y = &axes * DVector::from_fn(mean.len(), |i, _| lengths[i] * normal_draw(&mut rng));
        (&mean + state.sigma * y).as_slice().to_vec()
    };
    let is_inside = |candidate: &Vec<f64>| candidate.iter().all(|v| (0.0..=1.0).contains(v));
    // Bounds by resampling: a penalty needs a weight and would rank infeasible points among the feasible ones; clamping every sample
    // would pile the distribution up on the faces. Clamping is left for a mean in a corner, where resampling may not end.
    let feasible_point = |_| {
        let mut candidate = point();
        for _ in 1..DRAWS {
            if is_inside(&candidate) {
                break;
            }
            candidate = point();
        }
        candidate
    };
    (0..population).map(feasible_point).collect()
}

/// A point of the box in the unit cube.
pub(super) fn to_cube(bounds: &Bounds, point: &[f64]) -> Vec<f64> {
    (0..point.len()).map(|i| (point[i] - bounds.low[i]) / (bounds.high[i] - bounds.low[i])).collect()
}

/// A point of the unit cube in the box; beyond the cube, the nearest point of the box.
pub(super) fn from_cube(bounds: &Bounds, point: &[f64]) -> Vec<f64> {
    let unbounded: Vec<f64> =
        (0..point.len()).map(|i| bounds.low[i] + point[i] * (bounds.high[i] - bounds.low[i])).collect();
    bounds.clamp(&unbounded)
}

/// A standard normal number, by Box and Muller.
fn normal_draw(rng: &mut ChaCha8Rng) -> f64 {
    let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let (radius, angle) = ((-2.0 * uniform().ln()).sqrt(), std::f64::consts::TAU * uniform());
    radius * angle.cos()
}
