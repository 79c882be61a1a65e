//! Elastic forces of a reduced body, summed over the chosen quadrature points of one region.
//!
//! F = I + G q at each point, with G (9 × r) kept; f = Σ w Gᵀ P(F), K = Σ w Gᵀ (∂P/∂F) G.
//!
//! Stands on: `material`, `nalgebra`. Never knows: how points were chosen.

use nalgebra::{DMatrix, DVector, Matrix3, MatrixXx1, OMatrix};

use crate::body::assembly::Elastic;
use crate::material::{Lame, Tangent};

/// 9 × r: how F changes with each coordinate, columns of F one below the other.
pub(super) type Slopes = OMatrix<f64, nalgebra::U9, nalgebra::Dyn>;

/// The chosen points of one region.
#[derive(Debug)]
pub(super) struct Points {
    /// Its law and constants.
    pub elastic: Elastic,
    /// m³, and G.
    pub at: Vec<(f64, Slopes)>,
}

#[allow(non_snake_case)]
impl Points {
    pub fn count(&self) -> usize {
        self.at.len()
    }

    fn lame(&self, scale: f64) -> Lame {
        Lame { mu: scale * self.elastic.lame.mu, lambda: scale * self.elastic.lame.lambda }
    }

    /// Adds f, J.
    pub fn add_forces(&self, q: &DVector<f64>, scale: f64, forces: &mut DVector<f64>) {
        let lame = self.lame(scale);
        for (weight, G) in &self.at {
            let (_, P) = self.elastic.material.stress(&deformation(G, q), lame);
            forces.gemv_tr(*weight, G, &stacked(&P), 1.0);
        }
    }

    /// Adds K, J.
    pub fn add_stiffness(&self, q: &DVector<f64>, scale: f64, stiffness: &mut DMatrix<f64>) {
        let lame = self.lame(scale);
        for (weight, G) in &self.at {
            let C: Tangent = self.elastic.material.response(&deformation(G, q), lame).tangent;
            stiffness.gemm_tr(*weight, G, &(C * G), 1.0);
        }
    }
}

/// F = I + G q
#[allow(non_snake_case)]
pub(super) fn deformation(G: &Slopes, q: &DVector<f64>) -> Matrix3<f64> {
    Matrix3::from_column_slice((G * q).as_slice()) + Matrix3::identity()
}

/// A matrix as one column, its columns one below the other.
fn stacked(stress: &Matrix3<f64>) -> MatrixXx1<f64> {
    MatrixXx1::from_column_slice(stress.as_slice())
}
