//! Compressible neo-Hookean law: rubber elasticity with a logarithmic barrier against inversion.

use crate::material::{Material, Moduli, Response, Tangent};
use nalgebra::Matrix3;

/// ψ = μ/2 (I₁ − 3) − μ ln J + λ/2 ln²J with I₁ = F : F, J = det F        [bonet2008], equation 6.27
#[derive(Debug)]
pub struct NeoHookean;

/// ψ, P, ln J and G = F⁻ᵀ; none where J ≤ 0.
#[allow(non_snake_case)]
fn terms(F: &Matrix3<f64>, Moduli { mu, lambda, .. }: Moduli) -> Option<(f64, Matrix3<f64>, f64, Matrix3<f64>)> {
    let J = F.determinant();
    if J.is_nan() || J <= 0.0 {
        return None;
    }
    let G = F.try_inverse()?.transpose();
    let ln_J = J.ln();
    let energy = 0.5 * mu * (F.norm_squared() - 3.0) - mu * ln_J + 0.5 * lambda * ln_J * ln_J;
    Some((energy, (F - G) * mu + G * (lambda * ln_J), ln_J, G))
}

#[allow(non_snake_case)]
impl Material for NeoHookean {
    fn name(&self) -> &'static str {
        "neo_hookean"
    }

    fn stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>) {
        match terms(F, moduli) {
            Some((energy, stress, _, _)) => (energy, stress),
            None => (f64::INFINITY, Matrix3::zeros()),
        }
    }

    /// ∂P_iJ/∂F_kL = μ δ_ik δ_JL + (μ − λ ln J) G_iL G_kJ + λ G_iJ G_kL
    fn response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        let Some((energy, stress, ln_J, G)) = terms(F, moduli) else {
            return Response { energy: f64::INFINITY, stress: Matrix3::zeros(), tangent: Tangent::zeros() };
        };
        let geometric = moduli.mu - moduli.lambda * ln_J;
        let mut tangent = Tangent::zeros();
        for L in 0..3 {
            for k in 0..3 {
                for J in 0..3 {
                    for i in 0..3 {
                        tangent[(i + 3 * J, k + 3 * L)] =
                            geometric * G[(i, L)] * G[(k, J)] + moduli.lambda * G[(i, J)] * G[(k, L)];
                    }
                }
            }
        }
        for entry in 0..9 {
            tangent[(entry, entry)] += moduli.mu;
        }
        Response { energy, stress, tangent }
    }
}
