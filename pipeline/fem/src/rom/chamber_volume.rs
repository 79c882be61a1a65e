//! Chamber volume of a reduced model: a cubic polynomial of its coordinates.
//!
//! V(q) = V₀ + a·q + ½ B q q + ⅙ C q q q. The volume is cubic in the node positions, so its gradient is quadratic and
//! follows exactly from its values at rest, along each coordinate, and along each pair of them.

use nalgebra::{DMatrix, DVector};

use crate::loads::{ChamberPressure, Load};
use si::CubicMetre;

/// V₀, a, B, C.
#[derive(Debug)]
pub(super) struct CubicVolume {
    at_rest: CubicMetre,
    linear: DVector<f64>,
    quadratic: DMatrix<f64>,
    /// r × (pairs i ≤ j): C(·, i, j).
    cubic: DMatrix<f64>,
}

impl CubicVolume {
    /// Of `chamber` under `modes` ((3 per node) × r), sampled at distance `size` from rest.
    pub fn of(chamber: &ChamberPressure, modes: &DMatrix<f64>, size: f64) -> Self {
        let r = modes.ncols();
        let gradient = |displacement: &DVector<f64>| {
            let mut gradient = vec![0.0; modes.nrows()];
            chamber.add_gradient(displacement.as_slice(), -1.0, &mut gradient);
            modes.tr_mul(&DVector::from_vec(gradient))
        };
        // At the size of the snapshots and not at a small step: differences of a quadratic are exact at any, and
        // rounding is least there.
        let mode_step = |i: usize| modes.column(i) * size;
        let linear = gradient(&DVector::zeros(modes.nrows()));
        let forward: Vec<_> = (0..r).map(|i| gradient(&mode_step(i))).collect();
        let backward: Vec<_> = (0..r).map(|i| gradient(&-mode_step(i))).collect();
        let quadratic =
            DMatrix::from_columns(&(0..r).map(|i| (&forward[i] - &backward[i]) / (2.0 * size)).collect::<Vec<_>>());
        let cubic = |(i, j): (usize, usize)| {
            let more = if i == j {
                &forward[i] + &backward[i] - &linear * 2.0
            } else {
                gradient(&(mode_step(i) + mode_step(j))) - &forward[i] - &forward[j] + &linear
            };
            more / (size * size)
        };
        let cubic = DMatrix::from_columns(&index_pairs(r).map(cubic).collect::<Vec<_>>());
        Self { at_rest: chamber.at_rest, linear, quadratic, cubic }
    }

    /// V₀, and a, B and C, column after column.
    pub(super) fn arrays(&self) -> (CubicMetre, [&[f64]; 3]) {
        (self.at_rest, [self.linear.as_slice(), self.quadratic.as_slice(), self.cubic.as_slice()])
    }

    /// V(q), m³.
    pub(crate) fn volume_at(&self, q: &DVector<f64>) -> CubicMetre {
        self.at_rest + self.linear.dot(q) + 0.5 * q.dot(&(&self.quadratic * q)) + self.contracted(q).dot(q) / 6.0
    }

    /// Adds `scale` ∂V/∂q.
    pub(crate) fn add_gradient(&self, q: &DVector<f64>, scale: f64, gradient: &mut DVector<f64>) {
        *gradient += (&self.linear + &self.quadratic * q + self.contracted(q) * 0.5) * scale;
    }

    /// Adds `scale` ∂²V/∂q².
    pub(crate) fn add_hessian(&self, q: &DVector<f64>, scale: f64, hessian: &mut DMatrix<f64>) {
        *hessian += &self.quadratic * scale;
        for ((i, j), cubic) in index_pairs(q.len()).zip(self.cubic.column_iter()) {
            hessian.column_mut(i).axpy(scale * q[j], &cubic, 1.0);
            if i != j {
                hessian.column_mut(j).axpy(scale * q[i], &cubic, 1.0);
            }
        }
    }

    /// C(·, q, q)
    fn contracted(&self, q: &DVector<f64>) -> DVector<f64> {
        let weight = |(i, j): (usize, usize)| if i == j { q[i] * q[i] } else { 2.0 * q[i] * q[j] };
        &self.cubic * DVector::from_iterator(self.cubic.ncols(), index_pairs(q.len()).map(weight))
    }
}

/// Pairs i ≤ j below `r`.
fn index_pairs(r: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..r).flat_map(move |i| (i..r).map(move |j| (i, j)))
}
