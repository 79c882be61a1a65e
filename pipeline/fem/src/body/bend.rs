//! Bends: in what an assembled tangent departs from the second derivative of the energy, so that Newton gets on.
//!
//! Stands on: `material`, `nalgebra`. Never knows: an element, a matrix.

use crate::material::{Lame, Material, Tangent};
use nalgebra::{Matrix3, SVector, SymmetricEigen};

/// In what the assembled tangent departs from K.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bend<'a> {
    /// In nothing.
    Straight,
    /// Each point's tangent loses its negative eigenvalues.
    Convex,
    /// The stress that acts on turning edges is the one foreseen by the linear step that led here from this displacement.
    Foreseen(&'a [f64]),
}

#[allow(non_snake_case)]
impl Bend<'_> {
    /// The tangent at `F`; `before` gives the deformation gradient at a displacement (3 a node, m).
    pub fn tangent(
        &self,
        material: &'static dyn Material,
        lame: Lame,
        F: &Matrix3<f64>,
        before: impl Fn(&[f64]) -> Matrix3<f64>,
    ) -> Tangent {
        match self {
            Self::Straight => material.response(F, lame).tangent,
            Self::Convex => without_negative_part(material.response(F, lame).tangent),
            Self::Foreseen(from) => with_foreseen_stress(material, lame, &before(from), F),
        }
    }
}

/// ∂P/∂F at `now`, its stress S replaced by the one that a linear step from `before` foresees.
///
/// ∂P : δF = δF S + F (C : sym Fᵀ δF), and S is taken as S₀ + F₀⁻¹ (∂P₀ : ΔF − ΔF S₀), ΔF = F − F₀: the stress at the
/// end of a long step is spoilt by its own square terms, which a stiff thin sheet makes huge.      [magisano2017]
#[allow(non_snake_case)]
fn with_foreseen_stress(
    material: &'static dyn Material,
    lame: Lame,
    before: &Matrix3<f64>,
    now: &Matrix3<f64>,
) -> Tangent {
    let (then, here) = (material.response(before, lame), material.response(now, lame));
    let (Some(then_inverse), Some(inverse)) = (before.try_inverse(), now.try_inverse()) else {
        return here.tangent;
    };
    let step = now - before;
    let dP = then.tangent * SVector::<f64, 9>::from_column_slice(step.as_slice());
    let dP = Matrix3::from_column_slice(dP.as_slice());
    let S0 = then_inverse * then.stress;
    let foreseen = S0 + then_inverse * (dP - step * S0);
    let change = foreseen - inverse * here.stress;
    let change = (change + change.transpose()) * 0.5;
    let mut tangent = here.tangent;
    for J in 0..3 {
        for L in 0..3 {
            (0..3).for_each(|i| tangent[(i + 3 * J, i + 3 * L)] += change[(J, L)]);
        }
    }
    tangent
}

/// The nearest tangent without negative eigenvalues: Newton's direction then always descends.     [teran2005]
fn without_negative_part(tangent: Tangent) -> Tangent {
    if !tangent.iter().all(|entry| entry.is_finite()) {
        return tangent;
    }
    let eigen = SymmetricEigen::new(tangent);
    if eigen.eigenvalues.min() >= 0.0 {
        return tangent;
    }
    let kept = eigen.eigenvalues.map(|value| value.max(0.0));
    eigen.eigenvectors * Tangent::from_diagonal(&kept) * eigen.eigenvectors.transpose()
}
