//! The stiffness of a solid in single precision, for the quasi-Newton method of a step and for its adjoint.
//!
//! A step's residual is exact, so is that of its adjoint, and the tangent only says where to look next: rounded to single precision it takes as many iterations, and half
//! as many bytes go through twice as wide registers. The derivative ∂P/∂F is made once for eight points, 9 × 9, and multiplied by each
//! coordinate's ∂F/∂q: fewer products than the law's derivative along each of them.

use wide::f32x8;

use crate::lanes::{Blocks, Lanes};
use crate::law::{Constants, Deformed, Symmetric, at};

/// Nine numbers of a tensor, columns one below the other.
type Tensor = [f32x8; 9];

/// ∂F/∂q of every point by every coordinate, and weights (m³).
#[derive(Debug, Clone)]
pub(crate) struct SingleGradients {
    coordinates: usize,
    /// blocks × coordinates.
    values: Vec<Tensor>,
    weights: Vec<f32x8>,
}

impl SingleGradients {
    /// Of the same in double precision.
    pub(crate) fn new(gradients: &Blocks<9>, weights: &[Lanes]) -> Self {
        let blocks = 0..gradients.block_count();
        let values = blocks.flat_map(|block| gradients.block(block)).map(|tensor| tensor.map(round_lanes)).collect();
        let coordinates = gradients.block(0).len();
        Self { coordinates, values, weights: weights.iter().map(|weight| round_lanes(*weight)).collect() }
    }

    /// Adds the upper triangle of one block's K (J), row after row, with the stress `held` (Pa) in its geometric part.
    pub(crate) fn add_tangent(
        &self,
        block: usize,
        deformed: &Deformed,
        (constants, held): (&Constants, &Symmetric),
        stiffness: &mut [f32x8],
    ) {
        let gradients = &self.values[block * self.coordinates..(block + 1) * self.coordinates];
        let tangent = tangent_moduli(deformed, constants, held, self.weights[block]);
        let mut remaining_rows = stiffness;
        for (m, change) in gradients.iter().enumerate() {
            let mut image = [f32x8::ZERO; 9];
            image.iter_mut().zip(&tangent).for_each(|(entry, row)| *entry = dot(row, change));
            let (row, after) = remaining_rows.split_at_mut(gradients.len() - m);
            for (gradient, sum) in gradients[m..].iter().zip(row) {
                *sum += dot(gradient, &image);
            }
            remaining_rows = after;
        }
    }
}

/// Rounds each lane.
fn round_lanes(lanes: Lanes) -> f32x8 {
    f32x8::from(lanes.to_array().map(|lane| lane as f32))
}

/// Σ a b
#[inline(always)]
fn dot(a: &Tensor, b: &Tensor) -> f32x8 {
    // Fused, unlike the products of the residual: they only steer the iteration, and the build asks for FMA, so that
    // they round alike wherever it runs.
    let sum = |from: usize| a[from + 2].mul_add(b[from + 2], a[from + 1].mul_add(b[from + 1], a[from] * b[from]));
    sum(0) + sum(3) + sum(6)
}

/// ∂P/∂F times `weight` (J), a row of nine for each entry of P:
/// μ̂ δ_rc δ_kb + (μ̂ − λ ln J) G_rb G_ck + λ G_rk G_cb + 4 s″ (F − G)_rk (F − G)_cb + δ_rc H_kb.
#[inline(always)]
fn tangent_moduli(deformed: &Deformed, constants: &Constants, held_stress: &Symmetric, weight: f32x8) -> [Tensor; 9] {
    let [secant, curvature, geometric] = deformed.tangent_factors(constants);
    let [secant, curvature, geometric] = [secant, curvature, geometric].map(|factor| round_lanes(factor) * weight);
    let lambda = f32x8::splat(constants.lambda as f32) * weight;
    let (mut cofactor, mut difference) = ([f32x8::ZERO; 9], [f32x8::ZERO; 9]);
    for k in 0..9 {
        cofactor[k] = round_lanes(deformed.cofactor[k]);
        difference[k] = round_lanes(deformed.gradient[k] - deformed.cofactor[k]);
    }
    let [xx, yy, zz, yz, xz, xy] = held_stress.map(|entry| round_lanes(entry) * weight);
    let held_stress = [[xx + secant, xy, xz], [xy, yy + secant, yz], [xz, yz, zz + secant]];
    let mut moduli = [[f32x8::ZERO; 9]; 9];
    for (row, entries) in moduli.iter_mut().enumerate() {
        let (r, k) = (row % 3, row / 3);
        let (pressed, bent) = (lambda * cofactor[row], curvature * difference[row]);
        for (column, entry) in entries.iter_mut().enumerate() {
            let (c, b) = (column % 3, column / 3);
            *entry = bent.mul_add(difference[column], pressed * cofactor[column]);
            *entry = (geometric * cofactor[at(r, b)]).mul_add(cofactor[at(c, k)], *entry);
            if r == c {
                *entry += held_stress[k][b];
            }
        }
    }
    moduli
}

/// Zeros for a triangle of `r` rows.
pub(crate) fn zero_triangle(r: usize) -> Vec<f32x8> {
    vec![f32x8::ZERO; r * (r + 1) / 2]
}

/// Sum of the lanes of each.
pub(crate) fn lane_sums(triangle: &[f32x8]) -> impl Iterator<Item = f64> {
    triangle.iter().map(|lanes| lanes.to_array().iter().map(|lane| f64::from(*lane)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, gather, per_lane, splat};
    use crate::law::Tensor as Double;

    #[test]
    fn the_stiffness_is_that_of_double_precision_rounded() {
        let wave = |by: f64, k: usize| per_lane(|i| (by + 1.3 * k as f64 + 0.7 * i as f64).sin());
        let of = |point: usize, m: usize, k: usize| (1.0 + point as f64 + 2.1 * m as f64 + 0.3 * k as f64).sin();
        let gradients = Blocks::new(LANES, 4, of);
        let constants = Constants { mu: 7e4, lambda: 9e5, stiffening: [-1e3, 400.0] };
        let change: Double = std::array::from_fn(|k| splat(0.1) * wave(0.0, k));
        let here = Deformed::new(&change, &constants);
        let held: Symmetric = std::array::from_fn(|k| splat(2e4) * wave(5.0, k));
        let mut found = zero_triangle(4);
        let single = SingleGradients::new(&gradients, &[splat(2e-6)]);
        single.add_tangent(0, &here, (&constants, &held), &mut found);
        let unit = |m: usize| gather(gradients.block(0), &[0, 1, 2, 3].map(|n| f64::from(u8::from(m == n))));
        let product = |a: &Double, b: &Double| (0..9).map(|k| (a[k] * b[k]).sum()).sum::<f64>();
        let exact = |(m, n)| 2e-6 * product(&unit(n), &here.stress_change(&constants, &held, &unit(m)));
        let exact: Vec<f64> = (0..4).flat_map(|m| (m..4).map(move |n| (m, n))).map(exact).collect();
        let most = exact.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        for (found, exact) in lane_sums(&found).zip(&exact) {
            assert!((found - exact).abs() < 1e-6 * most, "{found} {exact}");
        }
    }
}
