//! Lopez-Pamies' law with a steep power: rubber whose modulus changes at small strain, stays, and rises at large strain.

use crate::material::{Material, Moduli, Response};
use crate::stretch;
use nalgebra::Matrix3;

/// ψ = C₁₀ x + C₂₀ [h₂(x) − x] + C₃₀ [h_b(x) − x] + λ/2 ln²J with hₐ(x) = 3^(1−a)/a [(3 + x)^a − 3^a], C₁₀ = μ/2     [lopezpamies2010]
///
/// The power 2 is Yeoh's term of a strip that stiffens. A power b far below zero acts up to x of about 3/(1 − b) and saturates: the modulus goes
/// from μ at rest to μ − 2 C₃₀. The members of the family differ in b alone: a fit tries each, so that the energy stays linear in all moduli.
#[derive(Debug)]
pub(crate) struct PowerPair {
    /// On a card.
    pub name: &'static str,
    /// b.
    pub soft: f64,
}

/// Up to x = 0.5: strains of 40 %.
pub(crate) const MODERATE: PowerPair = PowerPair { name: "lopez_pamies_m5", soft: -5.0 };
/// Up to x = 0.2: strains of 25 %.
pub(crate) const STEEP: PowerPair = PowerPair { name: "lopez_pamies_m15", soft: -15.0 };
/// Up to x = 0.05: strains of 13 %.
pub(crate) const STEEPEST: PowerPair = PowerPair { name: "lopez_pamies_m60", soft: -60.0 };

impl PowerPair {
    /// Both powers hₐ(x) − x, weighted by C₂₀ and C₃₀, with their first and second derivative.
    fn stiffening_series(&self, [stiff, soft]: [f64; 2], x: f64) -> [f64; 3] {
        let (b, ratio) = (self.soft, 1.0 + x / 3.0);
        let power = ratio.powf(b - 2.0);
        let steep = [3.0 / b * (power * ratio * ratio - 1.0) - x, power * ratio - 1.0, (b - 1.0) / 3.0 * power];
        let square = [x * x / 6.0, x / 3.0, 1.0 / 3.0];
        std::array::from_fn(|k| stiff * square[k] + soft * steep[k])
    }
}

#[allow(non_snake_case)]
impl Material for PowerPair {
    fn name(&self) -> &'static str {
        self.name
    }

    fn is_stiffening(&self) -> bool {
        true
    }

    fn energy_and_stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>) {
        stretch::energy_and_stress(F, moduli, |stiffening, x| self.stiffening_series(stiffening, x))
    }

    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        stretch::constitutive_response(F, moduli, |stiffening, x| self.stiffening_series(stiffening, x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// σ₁₁ − σ₂₂ = 2 (λ² − 1/λ) ∂W/∂I₁ in uniaxial tension of an incompressible solid.
    #[test]
    fn uniaxial_tension_is_that_of_the_powers() {
        let (mu, c20, c30) = (7e4, 6e3, 9e3);
        for (law, along) in [(&MODERATE, 1.3_f64), (&STEEP, 1.3), (&STEEPEST, 1.05), (&STEEPEST, 2.4)] {
            let across = along.powf(-0.5);
            let gradient = Matrix3::from_diagonal(&Vector3::new(along, across, across));
            let stress = law.energy_and_stress(&gradient, Moduli { mu, lambda: 0.0, stiffening: [c20, c30] }).1;
            let cauchy = stress * gradient.transpose();
            let first = along * along + 2.0 / along;
            let slope = 0.5 * mu + c20 * (first / 3.0 - 1.0) + c30 * ((first / 3.0).powf(law.soft - 1.0) - 1.0);
            let expected = 2.0 * (along * along - 1.0 / along) * slope;
            assert!(((cauchy[(0, 0)] - cauchy[(1, 1)]) / expected - 1.0).abs() < 1e-10, "{}", law.name);
        }
    }

    #[test]
    fn the_modulus_saturates_where_the_name_says() {
        for (law, end) in [(&MODERATE, 0.5), (&STEEP, 0.2), (&STEEPEST, 0.05)] {
            let [_, slope, _] = law.stiffening_series([0.0, 1.0], end);
            assert!((-0.75..-0.55).contains(&slope), "{}: {slope}", law.name);
            assert!(law.stiffening_series([0.0, 1.0], 10.0 * end)[1] < -0.95, "{}", law.name);
        }
    }
}
