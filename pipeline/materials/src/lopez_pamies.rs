//! Lopez-Pamies' law: rubber whose energy is a sum of powers of the first invariant.

use crate::material::{Material, Moduli, Response};
use crate::stretch;
use nalgebra::Matrix3;

/// ψ = C₁₀ x + C₂₀ [h₄(x) − x] + C₃₀ [h½(x) − x] + λ/2 ln²J with hₐ(x) = 3^(1−a)/a [(3 + x)^a − 3^a], C₁₀ = μ/2     [lopezpamies2010]
///
/// x is that of Yeoh's law, to which this one is not equal at any coefficients: the power 4 stiffens a strip at large strain, the power ½
/// softens it at moderate strain. What is linear in x belongs to C₁₀, so that μ is the modulus of small strains.
#[derive(Debug)]
pub struct LopezPamies;

/// Both powers hₐ(x) − x, weighted by C₂₀ and C₃₀, with their first and second derivative.
// By products and a square root, which cost less than a function of any power.
fn stiffening_series([stiff, soft]: [f64; 2], x: f64) -> [f64; 3] {
    let ratio = 1.0 + x / 3.0;
    let (square, root) = (ratio * ratio, ratio.sqrt());
    let fourth = [0.75 * (square * square - 1.0) - x, square * ratio - 1.0, square];
    let half = [6.0 * (root - 1.0) - x, 1.0 / root - 1.0, -1.0 / (6.0 * ratio * root)];
    std::array::from_fn(|k| stiff * fourth[k] + soft * half[k])
}

#[allow(non_snake_case)]
impl Material for LopezPamies {
    fn name(&self) -> &'static str {
        "lopez_pamies"
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
    fn uniaxial_tension_is_that_of_the_powers() {
        let (mu, c20, c30, along) = (7e4, 2e3, 9e3, 2.2_f64);
        let across = along.powf(-0.5);
        let gradient = Matrix3::from_diagonal(&Vector3::new(along, across, across));
        let stress = LopezPamies.energy_and_stress(&gradient, Moduli { mu, lambda: 0.0, stiffening: [c20, c30] }).1;
        let cauchy = stress * gradient.transpose();
        let first = along * along + 2.0 / along;
        let slope = 0.5 * mu + c20 * ((first / 3.0).powi(3) - 1.0) + c30 * ((first / 3.0).powf(-0.5) - 1.0);
        let expected = 2.0 * (along * along - 1.0 / along) * slope;
        assert!(((cauchy[(0, 0)] - cauchy[(1, 1)]) / expected - 1.0).abs() < 1e-12);
    }
}
