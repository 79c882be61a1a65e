//! Hyperelastic laws as energy densities: the contract of the family in `materials`.
//!
//! A law is an energy ψ(F) per reference volume, J/m³, with its first and second derivative. The deformation gradient F
//! (3 × 3, no unit) maps reference to current line elements; F = I is the undeformed state.
//!
//! To add a law: one file in `materials/` and its line in `ALL`; the conformance tests find it there.

use nalgebra::{Matrix3, SMatrix};
use si::Pascal;

/// ∂P/∂F, 9 × 9, Pa: row i + 3J and column k + 3L hold ∂P_iJ/∂F_kL (columns of F one below the other).
pub type Tangent = SMatrix<f64, 9, 9>;

/// The moduli in which every energy is linear, Pa.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moduli {
    /// Lamé's shear modulus μ.
    pub mu: Pascal,
    /// Lamé's λ; the bulk modulus is λ + 2μ/3.
    pub lambda: Pascal,
    /// C₂₀ and C₃₀ of (I₁ − 3)² and (I₁ − 3)³, for laws that stiffen.
    pub stiffening: [Pascal; 2],
}

impl Moduli {
    /// μ = E / 2(1+ν), λ = Eν / (1+ν)(1−2ν), from Young's modulus E (Pa) and Poisson's ratio ν.
    pub fn of(youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
        Self { mu, lambda, stiffening: [0.0; 2] }
    }

    /// ∂/∂E at E, ν; no unit.
    pub fn by_youngs_modulus(_youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        Self::of(1.0, poissons_ratio)
    }

    /// ∂/∂ν at E, ν; Pa.
    pub fn by_poissons_ratio(youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        let below = (1.0 + nu) * (1.0 - 2.0 * nu);
        let mu = -e / (2.0 * (1.0 + nu) * (1.0 + nu));
        Self { mu, lambda: e * (1.0 + 2.0 * nu * nu) / (below * below), stiffening: [0.0; 2] }
    }

    /// The same with C₂₀ and C₃₀ in these `ratios` to C₁₀ = μ/2.
    pub fn with_stiffening(self, ratios: [f64; 2]) -> Self {
        Self { stiffening: ratios.map(|ratio| 0.5 * ratio * self.mu), ..self }
    }

    /// The moduli of shape change, without λ.
    pub fn deviatoric(self) -> Self {
        Self { lambda: 0.0, ..self }
    }

    /// λ alone.
    pub fn volumetric(self) -> Self {
        Self { lambda: self.lambda, ..Self::default() }
    }

    /// A share of the moduli of shape change, and one of λ.
    pub fn shared(self, shear: f64, bulk: f64) -> Self {
        Self { lambda: bulk * self.lambda, ..self.scaled(shear) }
    }

    /// μ, λ, C₂₀, C₃₀.
    pub fn to_array(self) -> [Pascal; 4] {
        [self.mu, self.lambda, self.stiffening[0], self.stiffening[1]]
    }

    /// One of μ, λ, C₂₀, C₃₀ at 1, the others at 0.
    pub fn unit_modulus(which: usize) -> Self {
        let entry = |n: usize| f64::from(u8::from(n == which));
        Self { mu: entry(0), lambda: entry(1), stiffening: [entry(2), entry(3)] }
    }

    /// Every modulus multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self { mu: factor * self.mu, lambda: factor * self.lambda, stiffening: self.stiffening.map(|c| factor * c) }
    }
}

impl std::ops::Add for Moduli {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let [a, b] = [0, 1].map(|n| self.stiffening[n] + other.stiffening[n]);
        Self { mu: self.mu + other.mu, lambda: self.lambda + other.lambda, stiffening: [a, b] }
    }
}

/// Energy, stress and tangent at one quadrature point.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// ψ, J/m³.
    pub energy: f64,
    /// P = ∂ψ/∂F, Pa.
    pub stress: Matrix3<f64>,
    /// ∂P/∂F, Pa.
    pub tangent: Tangent,
}

/// A hyperelastic law: an energy density of the deformation gradient.
#[allow(non_snake_case)]
pub trait Material: std::fmt::Debug + Send + Sync {
    /// The name of the law on a card.
    fn name(&self) -> &'static str;

    /// Whether a rigid rotation of any size leaves the energy unchanged (false: infinitesimal rotations only).
    fn is_objective(&self) -> bool {
        true
    }

    /// ψ (J/m³) and P = ∂ψ/∂F (Pa); ψ is infinite where det F ≤ 0 and the law forbids inversion.
    fn energy_and_stress(&self, F: &Matrix3<f64>, moduli: Moduli) -> (f64, Matrix3<f64>);

    /// ψ, P and ∂P/∂F together.
    fn constitutive_response(&self, F: &Matrix3<f64>, moduli: Moduli) -> Response;

    /// Whether C₂₀ and C₃₀ act.
    fn is_stiffening(&self) -> bool {
        false
    }

    /// ∂P by μ, λ, C₂₀ and C₃₀, no unit: every law is linear in them, and P is the sum of each times its derivative.
    /// Parameter gradients, relaxation and mean dilatation rely on this.
    fn stress_by_moduli(&self, F: &Matrix3<f64>) -> [Matrix3<f64>; 4] {
        let count = if self.is_stiffening() { 4 } else { 2 };
        std::array::from_fn(|n| {
            if n < count { self.energy_and_stress(F, Moduli::unit_modulus(n)).1 } else { Matrix3::zeros() }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_add_entry_by_entry() {
        let of = |mu, lambda, stiffening| Moduli { mu, lambda, stiffening };
        assert_eq!(of(1.0, 2.0, [3.0, 4.0]) + of(0.5, 3.0, [-5.0, 7.0]), of(1.5, 5.0, [-2.0, 11.0]));
    }
}
