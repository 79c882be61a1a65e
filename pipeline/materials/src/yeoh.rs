//! Yeoh's law: rubber that softens at moderate strain and stiffens at large strain.

use crate::material::{Material, Moduli, Response};
use crate::stretch;
use nalgebra::Matrix3;

/// ψ = C₁₀ x + C₂₀ x² + C₃₀ x³ + λ/2 ln²J with x = I₁ − 3 − 2 ln J and C₁₀ = μ/2        [yeoh1993]
///
/// For incompressible rubber x is Yeoh's I₁ − 3. The logarithm makes x of second order in every small strain, a change
/// of volume included: the law has no stress at rest, its linear limit is exact, and its first term is the compressible
/// neo-Hookean law.
#[derive(Debug)]
pub struct Yeoh;

/// C₂₀ x² + C₃₀ x³ with its first and second derivative.
fn stiffening_series([c20, c30]: [f64; 2], x: f64) -> [f64; 3] {
    [(c20 + c30 * x) * x * x, (2.0 * c20 + 3.0 * c30 * x) * x, 2.0 * c20 + 6.0 * c30 * x]
}

#[allow(non_snake_case)]
impl Material for Yeoh {
    fn name(&self) -> &'static str {
        "yeoh"
    }

    fn is_stiffening(&self) -> bool {
        true
    }

    fn energy_and_stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>) {
        stretch::energy_and_stress(F, moduli, stiffening_series)
    }

    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        stretch::constitutive_response(F, moduli, stiffening_series)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// σ₁₁ − σ₂₂ = 2 (λ² − 1/λ) ∂W/∂I₁ in uniaxial tension of an incompressible solid.
    #[test]
    fn uniaxial_tension_is_that_of_yeohs_series() {
        let (mu, c20, c30, along) = (7e4, -3e3, 900.0, 2.2_f64);
        let across = along.powf(-0.5);
        let gradient = Matrix3::from_diagonal(&Vector3::new(along, across, across));
        let stress = Yeoh.energy_and_stress(&gradient, Moduli { mu, lambda: 0.0, stiffening: [c20, c30] }).1;
        let cauchy = stress * gradient.transpose();
        let x = along * along + 2.0 / along - 3.0;
        let slope = 0.5 * mu + 2.0 * c20 * x + 3.0 * c30 * x * x;
        let expected = 2.0 * (along * along - 1.0 / along) * slope;
        assert!(((cauchy[(0, 0)] - cauchy[(1, 1)]) / expected - 1.0).abs() < 1e-12);
    }
}
