//! Elastic forces of a reduced body, summed over the chosen quadrature points of one region.
//!
//! F = I + G q at each point, with G (9 × r) kept; f = Σ w Gᵀ P(F), K = Σ w Gᵀ (∂P/∂F) G.
//!
//! Stands on: `material`, `bend`, `nalgebra`. Never knows: how points were chosen.

use nalgebra::{DMatrix, DVector, Matrix3, OMatrix};

use crate::body::assembly::Elastic;
use crate::body::bend::Bend;
use crate::material::Lame;

/// 9 × r: how F changes with each coordinate, columns of F one below the other.
pub(super) type Slopes = OMatrix<f64, nalgebra::U9, nalgebra::Dyn>;

/// Which stress acts on turning edges in a tangent (see `bend`).
#[derive(Debug, Clone, Copy)]
pub(super) enum Stress<'a> {
    /// The present one: the exact tangent.
    #[cfg(test)]
    Present,
    /// The one that a linear step from these coordinates foresees.
    ForeseenFrom(&'a DVector<f64>),
    /// The present one, each point's tangent without its negative part.
    Convex,
}

/// The chosen points of one region.
#[derive(Debug)]
pub(super) struct Points {
    /// Its law and constants.
    elastic: Elastic,
    /// points, m³.
    weights: Vec<f64>,
    /// (points × 9) × r: G of each point below the other.
    slopes: DMatrix<f64>,
    /// The same turned.
    turned: DMatrix<f64>,
}

impl Points {
    /// Of a region with the weight (m³) and G of each of its points; `r` coordinates.
    pub fn new(elastic: Elastic, at: &[(f64, Slopes)], r: usize) -> Self {
        let mut slopes = DMatrix::zeros(9 * at.len(), r);
        for (point, (_, of_point)) in at.iter().enumerate() {
            slopes.rows_mut(9 * point, 9).copy_from(of_point);
        }
        let weights = at.iter().map(|(weight, _)| *weight).collect();
        Self { elastic, weights, turned: slopes.transpose(), slopes }
    }

    pub fn count(&self) -> usize {
        self.weights.len()
    }

    fn lame(&self, scale: f64) -> Lame {
        Lame { mu: scale * self.elastic.lame.mu, lambda: scale * self.elastic.lame.lambda }
    }

    /// Adds f, J.
    pub fn add_forces(&self, q: &DVector<f64>, scale: f64, forces: &mut DVector<f64>) {
        let lame = self.lame(scale);
        let mut works = &self.slopes * q;
        let (points, _) = works.as_mut_slice().as_chunks_mut::<9>();
        for (weight, point) in self.weights.iter().zip(points) {
            let (_, stress) = self.elastic.material.stress(&gradient(point), lame);
            point.iter_mut().zip(stress.as_slice()).for_each(|(work, p)| *work = weight * p);
        }
        forces.gemv(1.0, &self.turned, &works, 1.0);
    }

    /// Adds K, J.
    pub fn add_stiffness(&self, q: &DVector<f64>, stress: Stress, scale: f64, stiffness: &mut DMatrix<f64>) {
        let (bend, before) = match stress {
            #[cfg(test)]
            Stress::Present => (Bend::Straight, q),
            Stress::Convex => (Bend::Convex, q),
            Stress::ForeseenFrom(before) => (Bend::Foreseen(&[]), before),
        };
        let lame = self.lame(scale);
        let (now, then) = (&self.slopes * q, &self.slopes * before);
        let mut image = DMatrix::zeros(self.slopes.nrows(), self.slopes.ncols());
        for (point, weight) in self.weights.iter().enumerate() {
            let at = |all: &DVector<f64>| gradient(&std::array::from_fn(|k| all[9 * point + k]));
            let tangent = bend.tangent(self.elastic.material, lame, &at(&now), |_| at(&then)) * *weight;
            for (mut to, from) in image.column_iter_mut().zip(self.slopes.column_iter()) {
                let product = tangent * from.fixed_rows::<9>(9 * point);
                to.fixed_rows_mut::<9>(9 * point).copy_from(&product);
            }
        }
        stiffness.gemm(1.0, &self.turned, &image, 1.0);
    }
}

/// F from G q at one point.
fn gradient(change: &[f64; 9]) -> Matrix3<f64> {
    Matrix3::from_column_slice(change) + Matrix3::identity()
}

/// F = I + G q
#[allow(non_snake_case)]
pub(super) fn deformation(G: &Slopes, q: &DVector<f64>) -> Matrix3<f64> {
    Matrix3::from_column_slice((G * q).as_slice()) + Matrix3::identity()
}
