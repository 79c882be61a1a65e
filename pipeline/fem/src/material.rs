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

/// Lamé's constants, Pa: the pair in which the energies are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lame {
    /// Shear modulus μ.
    pub mu: Pascal,
    /// λ; the bulk modulus is λ + 2μ/3.
    pub lambda: Pascal,
}

impl Lame {
    /// μ = E / 2(1+ν), λ = Eν / (1+ν)(1−2ν), from Young's modulus E (Pa) and Poisson's ratio ν.
    pub fn of(youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        Self { mu: e / (2.0 * (1.0 + nu)), lambda: e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) }
    }

    /// (∂μ, ∂λ)/∂E at E, ν; no unit.
    pub fn by_youngs_modulus(_youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        Self::of(1.0, poissons_ratio)
    }

    /// (∂μ, ∂λ)/∂ν at E, ν; Pa.
    pub(crate) fn by_poissons_ratio(youngs_modulus: Pascal, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        let below = (1.0 + nu) * (1.0 - 2.0 * nu);
        Self { mu: -e / (2.0 * (1.0 + nu) * (1.0 + nu)), lambda: e * (1.0 + 2.0 * nu * nu) / (below * below) }
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
    fn stress(&self, F: &Matrix3<f64>, lame: Lame) -> (f64, Matrix3<f64>);

    /// ψ, P and ∂P/∂F together.
    fn response(&self, F: &Matrix3<f64>, lame: Lame) -> Response;

    /// ∂P/∂μ and ∂P/∂λ, no unit: every law is linear in both, P = μ ∂P/∂μ + λ ∂P/∂λ. Parameter gradients
    /// and mean dilatation rely on this.
    fn stress_by_lame(&self, F: &Matrix3<f64>) -> [Matrix3<f64>; 2] {
        let by = |mu, lambda| self.stress(F, Lame { mu, lambda }).1;
        [by(1.0, 0.0), by(0.0, 1.0)]
    }
}
