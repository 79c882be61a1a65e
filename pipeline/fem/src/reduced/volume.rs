//! The volume of a chamber as a function of a few coordinates: a cubic, kept by its derivatives at rest.
//!
//! V(q) = V₀ + a·q + ½ B q q + ⅙ C q q q. Volume is cubic in the nodes' places, so its gradient is quadratic and known exactly
//! from its values at rest, along each coordinate, and between each two.
//!
//! Stands on: `loads` (the chamber), `nalgebra`. Never knows: a material, a pressure.

use nalgebra::{DMatrix, DVector};

use crate::load::Load;
use crate::loads::ChamberPressure;
use si::CubicMetre;

/// V₀, a, B, C.
#[derive(Debug)]
pub(super) struct CubicVolume {
    at_rest: CubicMetre,
    slope: DVector<f64>,
    bend: DMatrix<f64>,
    /// r × (pairs i ≤ j): C(·, i, j).
    twist: DMatrix<f64>,
}

impl CubicVolume {
    /// Of `chamber` moved by `modes` ((3 a node) × r), sampled `size` away from rest.
    pub fn of(chamber: &ChamberPressure, modes: &DMatrix<f64>, size: f64) -> Self {
        let r = modes.ncols();
        let gradient = |moved: &DVector<f64>| {
            let mut slope = vec![0.0; modes.nrows()];
            chamber.add_gradient(moved.as_slice(), -1.0, &mut slope);
            modes.tr_mul(&DVector::from_vec(slope))
        };
        let along = |i: usize| modes.column(i) * size;
        let slope = gradient(&DVector::zeros(modes.nrows()));
        let ahead: Vec<_> = (0..r).map(|i| gradient(&along(i))).collect();
        let behind: Vec<_> = (0..r).map(|i| gradient(&-along(i))).collect();
        let bend = DMatrix::from_columns(&(0..r).map(|i| (&ahead[i] - &behind[i]) / (2.0 * size)).collect::<Vec<_>>());
        let twist = |(i, j): (usize, usize)| {
            let more = if i == j {
                &ahead[i] + &behind[i] - &slope * 2.0
            } else {
                gradient(&(along(i) + along(j))) - &ahead[i] - &ahead[j] + &slope
            };
            more / (size * size)
        };
        let twist = DMatrix::from_columns(&pairs(r).map(twist).collect::<Vec<_>>());
        Self { at_rest: chamber.at_rest, slope, bend, twist }
    }

    /// V(q), m³.
    pub fn at(&self, q: &DVector<f64>) -> CubicMetre {
        self.at_rest + self.slope.dot(q) + 0.5 * q.dot(&(&self.bend * q)) + self.turned(q).dot(q) / 6.0
    }

    /// Adds `by` ∂V/∂q.
    pub fn add_gradient(&self, q: &DVector<f64>, by: f64, gradient: &mut DVector<f64>) {
        *gradient += (&self.slope + &self.bend * q + self.turned(q) * 0.5) * by;
    }

    /// Adds `by` ∂²V/∂q².
    pub fn add_hessian(&self, q: &DVector<f64>, by: f64, hessian: &mut DMatrix<f64>) {
        *hessian += &self.bend * by;
        for ((i, j), twist) in pairs(q.len()).zip(self.twist.column_iter()) {
            hessian.column_mut(i).axpy(by * q[j], &twist, 1.0);
            if i != j {
                hessian.column_mut(j).axpy(by * q[i], &twist, 1.0);
            }
        }
    }

    /// C(·, q, q)
    fn turned(&self, q: &DVector<f64>) -> DVector<f64> {
        let weight = |(i, j): (usize, usize)| if i == j { q[i] * q[i] } else { 2.0 * q[i] * q[j] };
        &self.twist * DVector::from_iterator(self.twist.ncols(), pairs(q.len()).map(weight))
    }
}

/// i ≤ j below `r`.
fn pairs(r: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..r).flat_map(move |i| (i..r).map(move |j| (i, j)))
}
