//! Laws of one stretch: ψ = μ/2 x + s(x) + λ/2 ln²J with x = I₁ − 3 − 2 ln J, and s of second order in x.

use crate::material::{Moduli, Response};
use crate::neo_hookean::{Volume, inverted_response};
use nalgebra::{Matrix3, SVector};

/// x.
#[allow(non_snake_case)]
fn stretch(F: &Matrix3<f64>, volume: &Volume) -> f64 {
    F.norm_squared() - 3.0 - 2.0 * volume.ln_J
}

/// The neo-Hookean moduli of the same stress: the slope of s adds to C₁₀.
fn secant_moduli(moduli: Moduli, slope: f64) -> Moduli {
    Moduli { mu: moduli.mu + 2.0 * slope, ..moduli }
}

/// ψ and P.
#[allow(non_snake_case)]
///
/// `series`: s with its first and second derivative, from C₂₀ and C₃₀ (Pa) and x.
pub(crate) fn energy_and_stress(
    F: &Matrix3<f64>,
    moduli: Moduli,
    series: impl Fn([f64; 2], f64) -> [f64; 3],
) -> (f64, Matrix3<f64>) {
    let Some(volume) = Volume::of(F) else { return (f64::INFINITY, Matrix3::zeros()) };
    let x = stretch(F, &volume);
    let [added, slope, _] = series(moduli.stiffening, x);
    let (energy, stress) = volume.energy_and_stress(F, secant_moduli(moduli, slope));
    (energy - slope * x + added, stress)
}

/// ψ, P and ∂P/∂F: that of the neo-Hookean law of the same stress, and s″ X ⊗ X with X = ∂x/∂F = 2 (F − F⁻ᵀ).
#[allow(non_snake_case)]
pub(crate) fn constitutive_response(
    F: &Matrix3<f64>,
    moduli: Moduli,
    series: impl Fn([f64; 2], f64) -> [f64; 3],
) -> Response {
    let Some(volume) = Volume::of(F) else { return inverted_response() };
    let x = stretch(F, &volume);
    let [added, slope, curvature] = series(moduli.stiffening, x);
    let secant = secant_moduli(moduli, slope);
    let ((energy, stress), mut tangent) = (volume.energy_and_stress(F, secant), volume.tangent(secant));
    let X = (F - volume.G) * 2.0;
    let X = SVector::<f64, 9>::from_column_slice(X.as_slice());
    tangent += X * X.transpose() * curvature;
    Response { energy: energy - slope * x + added, stress, tangent }
}
