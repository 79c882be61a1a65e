//! Kinds of element tangent: the exact second derivative, its positive semi-definite part, and the
//! mixed-integration-point (MIP) tangent \[magisano2017\].
//!
//! The exact tangent uses the stress of the current iterate. After a long linear step that stress is spoilt by its own
//! quadratic terms, which a stiff thin sheet in large rotation makes huge. The MIP tangent uses the stress that the
//! linear step predicted: Newton's method with full steps then takes 4 to 12 iterations per load step, where an energy
//! line search cuts every step.

use crate::material::{Material, Moduli, Tangent};
use nalgebra::{Matrix3, SVector, SymmetricEigen};

/// The tangent that is assembled.
#[derive(Debug, Clone, Copy)]
pub enum TangentKind<'a> {
    /// ∂²Ψ/∂u².
    Exact,
    /// The tangent of each quadrature point without its negative eigenvalues.
    Convex,
    /// Mixed integration points: the geometric part uses the stress predicted by the linear step from this
    /// displacement.
    MixedPoint(&'a [f64]),
    /// The geometric part uses the second Piola–Kirchhoff stress at this displacement, an equilibrium nearby, and all of it the volume there: those
    /// of a shape interpolated between equilibria are spoilt where a stiff sheet rotates.
    FormerStress(&'a [f64]),
}

/// A point at which a tangent is taken.
#[derive(Debug, Clone, Copy)]
#[allow(non_snake_case)]
pub struct PointState<'a> {
    /// The law.
    pub material: &'static dyn Material,
    /// Its moduli, with what damping and relaxation add.
    pub moduli: Moduli,
    /// The deformation gradient.
    pub F: &'a Matrix3<f64>,
    /// H, the second Piola–Kirchhoff stress that relaxation holds, Pa.
    pub held: Option<&'a Matrix3<f64>>,
}

#[allow(non_snake_case)]
impl TangentKind<'_> {
    /// The tangent at `at`; `previous` gives the deformation gradient at a displacement (3 per node, m).
    // H is the same before and after a linear step, so that it changes no predicted stress.
    pub fn tangent(&self, at: &PointState, previous: impl Fn(&[f64]) -> Matrix3<f64>) -> Tangent {
        let PointState { material, moduli, F, held } = *at;
        let mut tangent = match self {
            Self::Exact | Self::Convex => material.constitutive_response(F, moduli).tangent,
            Self::MixedPoint(from) => mixed_point(material, moduli, &previous(from), F),
            Self::FormerStress(from) => former_stress(material, moduli, &previous(from), F),
        };
        held.iter().for_each(|held| add_geometric(&mut tangent, held));
        if matches!(self, Self::Convex) { positive_part(tangent) } else { tangent }
    }
}

/// ∂P/∂F at `now`, its stress S replaced by the one that a linear step from `before` predicts.
///
/// ∂P : δF = δF S + F (C : sym Fᵀ δF), and S is taken as S₀ + F₀⁻¹ (∂P₀ : ΔF − ΔF S₀), ΔF = F − F₀.      [magisano2017]
#[allow(non_snake_case)]
fn mixed_point(material: &'static dyn Material, moduli: Moduli, before: &Matrix3<f64>, now: &Matrix3<f64>) -> Tangent {
    let (then, here) = (material.constitutive_response(before, moduli), material.constitutive_response(now, moduli));
    let (Some(then_inverse), Some(inverse)) = (before.try_inverse(), now.try_inverse()) else {
        // A singular F has no second Piola–Kirchhoff stress; the exact tangent is as good as any there.
        return here.tangent;
    };
    let step = now - before;
    let dP = then.tangent * SVector::<f64, 9>::from_column_slice(step.as_slice());
    let dP = Matrix3::from_column_slice(dP.as_slice());
    let S0 = then_inverse * then.stress;
    let predicted = S0 + then_inverse * (dP - step * S0);
    let change = predicted - inverse * here.stress;
    let change = (change + change.transpose()) * 0.5;
    let mut tangent = here.tangent;
    add_geometric(&mut tangent, &change);
    tangent
}

/// ∂P/∂F at `now`, its stress S and its volume replaced by those at `before`.
// Interpolated shapes are also too large or too small by some per cent at single points, and a nearly incompressible law has no stiffness in shear
// left where it is dilated by 3 %. Of the first tangents on the paths of a thin tail of hexahedra 71 % were indefinite with the volume at `now`,
// 16 % with that at `before`; its 14 levels took 182 s and then 102 s. The whole material tangent at `before`, turned into `now`, is hardly ever
// indefinite (3 %), but predicts less: 224 s.
#[allow(non_snake_case)]
fn former_stress(
    material: &'static dyn Material,
    moduli: Moduli,
    before: &Matrix3<f64>,
    now: &Matrix3<f64>,
) -> Tangent {
    let now = with_volume_of(before, now);
    let (then, here) = (material.constitutive_response(before, moduli), material.constitutive_response(&now, moduli));
    let (Some(then_inverse), Some(inverse)) = (before.try_inverse(), now.try_inverse()) else { return here.tangent };
    let change = then_inverse * then.stress - inverse * here.stress;
    let mut tangent = here.tangent;
    add_geometric(&mut tangent, &((change + change.transpose()) * 0.5));
    tangent
}

/// `now`, dilated to the volume at `before`; as it is where either has none.
fn with_volume_of(before: &Matrix3<f64>, now: &Matrix3<f64>) -> Matrix3<f64> {
    let ratio = before.determinant() / now.determinant();
    if ratio.is_finite() && ratio > 0.0 { now * ratio.cbrt() } else { *now }
}

/// Adds δ_ik S_JL, the tangent of F S at a constant S.
#[allow(non_snake_case)]
fn add_geometric(tangent: &mut Tangent, S: &Matrix3<f64>) {
    for J in 0..3 {
        for L in 0..3 {
            (0..3).for_each(|i| tangent[(i + 3 * J, i + 3 * L)] += S[(J, L)]);
        }
    }
}

/// The nearest positive semi-definite tangent: Newton's direction is then always one of descent.     [teran2005]
fn positive_part(tangent: Tangent) -> Tangent {
    if !tangent.iter().all(|entry| entry.is_finite()) {
        return tangent;
    }
    if is_clearly_positive(&tangent) {
        return tangent;
    }
    let eigen = SymmetricEigen::new(tangent);
    if eigen.eigenvalues.min() >= 0.0 {
        return tangent;
    }
    let positive = eigen.eigenvalues.map(|value| value.max(0.0));
    eigen.eigenvectors * Tangent::from_diagonal(&positive) * eigen.eigenvectors.transpose()
}

/// Whether all eigenvalues lie above the rounding of the largest: a factorisation says so for less than eigenvectors cost.
fn is_clearly_positive(tangent: &Tangent) -> bool {
    let margin = 1e-12 * tangent.trace();
    margin > 0.0 && (tangent - Tangent::identity() * margin).cholesky().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::by_name;

    /// The tangent at `now` with the stress at `before`.
    fn with_stress_of(before: &Matrix3<f64>, now: &Matrix3<f64>) -> Tangent {
        let material = by_name("neo_hookean").expect("a law of this name");
        let at = PointState { material, moduli: Moduli::of(1e6, 0.3), F: now, held: None };
        TangentKind::FormerStress(&[]).tangent(&at, |_| *before)
    }

    fn exact(at: &Matrix3<f64>) -> Tangent {
        with_stress_of(at, at)
    }

    #[test]
    #[allow(non_snake_case)]
    fn the_former_stress_is_that_of_the_equilibrium_nearby_in_the_present_shape() {
        let (cos, sin) = (0.4_f64.cos(), 0.4_f64.sin());
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        // a sheet that turns by 0.4 rad along the straight line between two shapes is compressed on its way
        let (before, after) = (Matrix3::from_diagonal_element(1.0), turn);
        let between = (before + after) * 0.5;
        let squeezed = exact(&between);
        let relaxed = with_stress_of(&before, &between);
        let least = |tangent: &Tangent| SymmetricEigen::new((tangent + tangent.transpose()) * 0.5).eigenvalues.min();
        assert!(least(&squeezed) < -1e3, "the spurious stress makes it indefinite: {}", least(&squeezed));
        // unstressed, a tangent is zero for turns and positive else
        assert!(least(&relaxed) > -1e-3, "{}", least(&relaxed));
        // a turn needs no force without stress
        let skew = Matrix3::new(0.0, -1.0, 0.5, 1.0, 0.0, 0.2, -0.5, -0.2, 0.0);
        let moved = skew * between;
        let force = relaxed * SVector::<f64, 9>::from_column_slice(moved.as_slice());
        assert!(force.amax() < 1e-6 * 1e6, "{}", force.amax());
    }

    #[test]
    fn a_shape_that_is_dilated_at_a_point_keeps_its_stiffness_in_shear() {
        // ν = 0.487: λ is 37 μ, and at 4 % of dilatation μ − λ ln J is negative
        let material = by_name("neo_hookean").expect("a law of this name");
        let (equilibrium, dilated) = (Matrix3::identity(), Matrix3::from_diagonal_element(1.04_f64.cbrt()));
        let at = PointState { material, moduli: Moduli::of(2.5e5, 0.487), F: &dilated, held: None };
        let shear = SVector::<f64, 9>::from_column_slice(&[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let stiffness = |kind: TangentKind| shear.dot(&(kind.tangent(&at, |_| equilibrium) * shear));
        let moved = stiffness(TangentKind::FormerStress(&[]));
        // 4 μ of a symmetric shear by one each way
        assert!((moved / (4.0 * at.moduli.mu) - 1.0).abs() < 0.05, "{moved}");
    }
}
