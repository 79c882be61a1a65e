//! Linear elasticity: the small-strain limit of every other law, for tests and closed forms.

use crate::material::{Material, Moduli, Response, Tangent};
use nalgebra::Matrix3;

/// ψ = μ ε : ε + λ/2 tr²ε with ε = ½ (F + Fᵀ) − I.
#[derive(Debug)]
pub struct Linear;

#[allow(non_snake_case)]
impl Material for Linear {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn is_objective(&self) -> bool {
        false
    }

    fn energy_and_stress(&self, F: &Matrix3<f64>, Moduli { mu, lambda, .. }: Moduli) -> (f64, Matrix3<f64>) {
        let strain = (F + F.transpose()) * 0.5 - Matrix3::identity();
        let volumetric = strain.trace();
        let energy = mu * strain.norm_squared() + 0.5 * lambda * volumetric * volumetric;
        (energy, strain * (2.0 * mu) + Matrix3::identity() * (lambda * volumetric))
    }

    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        let (energy, stress) = self.energy_and_stress(F, moduli);
        let mut tangent = Tangent::zeros();
        for i in 0..3 {
            for j in 0..3 {
                tangent[(i + 3 * j, i + 3 * j)] += moduli.mu;
                tangent[(i + 3 * j, j + 3 * i)] += moduli.mu;
                tangent[(4 * i, 4 * j)] += moduli.lambda;
            }
        }
        Response { energy, stress, tangent }
    }
}
