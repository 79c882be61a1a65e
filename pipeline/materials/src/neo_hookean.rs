//! Compressible neo-Hookean law: rubber elasticity with a logarithmic barrier against inversion.

use crate::material::{Material, Moduli, Response, Tangent};
use nalgebra::Matrix3;

/// ψ = μ/2 (I₁ − 3) − μ ln J + λ/2 ln²J with I₁ = F : F, J = det F        [bonet2008], equation 6.27
#[derive(Debug)]
pub struct NeoHookean;

/// Where J ≤ 0.
pub(crate) fn inverted_response() -> Response {
    Response { energy: f64::INFINITY, stress: Matrix3::zeros(), tangent: Tangent::zeros() }
}

/// ln J and G = F⁻ᵀ.
#[derive(Debug, Clone, Copy)]
#[allow(non_snake_case)]
pub(crate) struct Volume {
    pub ln_J: f64,
    pub G: Matrix3<f64>,
}

#[allow(non_snake_case)]
impl Volume {
    /// None where J ≤ 0.
    pub fn of(F: &Matrix3<f64>) -> Option<Self> {
        let J = F.determinant();
        if J.is_nan() || J <= 0.0 {
            return None;
        }
        Some(Self { ln_J: J.ln(), G: F.try_inverse()?.transpose() })
    }

    /// ψ and P.
    pub fn energy_and_stress(&self, F: &Matrix3<f64>, Moduli { mu, lambda, .. }: Moduli) -> (f64, Matrix3<f64>) {
        let Self { ln_J, G } = *self;
        let energy = 0.5 * mu * (F.norm_squared() - 3.0) - mu * ln_J + 0.5 * lambda * ln_J * ln_J;
        (energy, (F - G) * mu + G * (lambda * ln_J))
    }

    /// ∂P_iJ/∂F_kL = μ δ_ik δ_JL + (μ − λ ln J) G_iL G_kJ + λ G_iJ G_kL
    pub fn tangent(&self, Moduli { mu, lambda, .. }: Moduli) -> Tangent {
        let Self { ln_J, G } = *self;
        let geometric = mu - lambda * ln_J;
        let mut tangent = Tangent::zeros();
        for L in 0..3 {
            for k in 0..3 {
                for J in 0..3 {
                    for i in 0..3 {
                        tangent[(i + 3 * J, k + 3 * L)] =
                            geometric * G[(i, L)] * G[(k, J)] + lambda * G[(i, J)] * G[(k, L)];
                    }
                }
            }
        }
        (0..9).for_each(|entry| tangent[(entry, entry)] += mu);
        tangent
    }
}

#[allow(non_snake_case)]
impl Material for NeoHookean {
    fn name(&self) -> &'static str {
        "neo_hookean"
    }

    fn energy_and_stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>) {
        Volume::of(F).map_or((f64::INFINITY, Matrix3::zeros()), |volume| volume.energy_and_stress(F, moduli))
    }

    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        let Some(volume) = Volume::of(F) else { return inverted_response() };
        let (energy, stress) = volume.energy_and_stress(F, moduli);
        Response { energy, stress, tangent: volume.tangent(moduli) }
    }
}
