//! Ogden's law with three terms of even powers.

use crate::material::{Material, Moduli, Response, Tangent};
use crate::neo_hookean::{Volume, inverted_response};
use nalgebra::{Matrix3, SVector};

/// ψ = C₁₀ x + C₂₀ [¼ (tr C² − 3) − ln J − x] + C₃₀ [tr C⁻¹ − 3 + 2 ln J − x] + λ/2 ln²J, x = tr C − 3 − 2 ln J, C₁₀ = μ/2    [ogden1972]
///
/// These are Ogden's terms Σ μ_k/α_k (λ₁^α + λ₂^α + λ₃^α − 3 − α ln J) with α of 2, 4 and −2, which need no principal stretches: the power 4
/// stiffens a strip, the power −2 is that of Mooney and Rivlin and distinguishes a sheet held at its width from a strip. From each, x is subtracted, so
/// that μ is the modulus of small strains whatever C₂₀ and C₃₀.
#[derive(Debug)]
pub struct Ogden;

/// The terms of power 4 and −2, less x each, with their derivatives.
#[allow(non_snake_case)]
struct Terms {
    energy: [f64; 2],
    stress: [Matrix3<f64>; 2],
    /// F⁻¹ and C⁻¹.
    inverse: Matrix3<f64>,
    C_inverse: Matrix3<f64>,
}

#[allow(non_snake_case)]
impl Terms {
    fn new(F: &Matrix3<f64>, volume: &Volume) -> Self {
        let (C, inverse) = (F.tr_mul(F), volume.G.transpose());
        let C_inverse = inverse * inverse.transpose();
        let x = C.trace() - 3.0 - 2.0 * volume.ln_J;
        let first = (F - volume.G) * 2.0;
        // both have the second derivative of x at rest
        let fourth = 0.25 * (C.norm_squared() - 3.0) - volume.ln_J;
        let minus = C_inverse.trace() - 3.0 + 2.0 * volume.ln_J;
        Self {
            energy: [fourth - x, minus - x],
            stress: [F * C - volume.G - first, (volume.G - volume.G * C_inverse) * 2.0 - first],
            inverse,
            C_inverse,
        }
    }

    /// Second derivatives, 9 × 9, by columns dP for each unit dF.
    fn tangent(&self, F: &Matrix3<f64>, weights: [f64; 2]) -> Tangent {
        let (C, G) = (F.tr_mul(F), self.inverse.transpose());
        let mut tangent = Tangent::zeros();
        for entry in 0..9 {
            let mut dF = Matrix3::zeros();
            dF[entry] = 1.0;
            let dG = -G * dF.transpose() * G;
            let dC = dF.tr_mul(F) + F.tr_mul(&dF);
            let dC_inverse = -self.C_inverse * dC * self.C_inverse;
            let first = (dF - dG) * 2.0;
            let fourth = dF * C + F * dC - dG - first;
            let minus = (dG - dG * self.C_inverse - G * dC_inverse) * 2.0 - first;
            let column = fourth * weights[0] + minus * weights[1];
            tangent.set_column(entry, &SVector::<f64, 9>::from_column_slice(column.as_slice()));
        }
        tangent
    }
}

#[allow(non_snake_case)]
impl Material for Ogden {
    fn name(&self) -> &'static str {
        "ogden"
    }

    fn is_stiffening(&self) -> bool {
        true
    }

    fn energy_and_stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>) {
        let Some(volume) = Volume::of(F) else { return (f64::INFINITY, Matrix3::zeros()) };
        let (energy, stress) = volume.energy_and_stress(F, moduli);
        let (terms, [c20, c30]) = (Terms::new(F, &volume), moduli.stiffening);
        (energy + c20 * terms.energy[0] + c30 * terms.energy[1], stress + terms.stress[0] * c20 + terms.stress[1] * c30)
    }

    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response {
        let Some(volume) = Volume::of(F) else { return inverted_response() };
        let (energy, stress) = self.energy_and_stress(F, moduli);
        let tangent = volume.tangent(moduli) + Terms::new(F, &volume).tangent(F, moduli.stiffening);
        Response { energy, stress, tangent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// σ₁ − σ₂ = Σ μ_k (λ₁^α − λ₂^α) of Ogden's law: in a strip that is pulled, and in a sheet that keeps its width.
    #[test]
    fn principal_stresses_are_those_of_the_powers() {
        let (mu, c20, c30, along) = (7e4, 2e3, 5e3, 1.8_f64);
        for [second, third] in [[along.powf(-0.5); 2], [1.0, 1.0 / along]] {
            let gradient = Matrix3::from_diagonal(&Vector3::new(along, second, third));
            let stress = Ogden.energy_and_stress(&gradient, Moduli { mu, lambda: 0.0, stiffening: [c20, c30] }).1;
            let cauchy = stress * gradient.transpose();
            let power = |alpha: f64| along.powf(alpha) - third.powf(alpha);
            let expected = (mu - 2.0 * c20 - 2.0 * c30) * power(2.0) + c20 * power(4.0) - 2.0 * c30 * power(-2.0);
            assert!(((cauchy[(0, 0)] - cauchy[(2, 2)]) / expected - 1.0).abs() < 1e-12);
        }
    }
}
