//! Corotated elasticity, the law that the paper identifies: linear in the stretch that is left when the turn is taken out.
//!
//! Stands on: `material`. Never knows: a mesh.

use crate::material::{Lame, Material, Response, Tangent};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// ψ = μ ‖S − I‖² + λ/2 tr²(S − I) with F = R S        paper, equation 1
#[derive(Debug)]
pub(crate) struct Corotated;

/// Newton steps of the polar decomposition before it is given up: a matrix of condition 10⁶ needs 12.
const POLAR_STEPS: usize = 60;
/// Steps longer than this are scaled; near the turn, Newton's own are as quick.
const FAR: f64 = 0.3;

/// The turn R in F = R S by the scaled Newton iteration R ← ½ (γ R + R⁻ᵀ/γ), γ = √(‖R⁻¹‖/‖R‖)     [higham1986], 3.4
///
/// R⁻ᵀ is the matrix of cofactors over the determinant. R is a reflection where det F < 0, and `None` where F is
/// singular to rounding.
#[allow(non_snake_case)]
pub(crate) fn turn_of(F: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let mut R = *F;
    let mut change = f64::INFINITY;
    for _ in 0..POLAR_STEPS {
        let (cofactors, determinant) = cofactors(&R);
        let mut inverse = 1.0 / determinant;
        if !inverse.is_finite() {
            return None;
        }
        if change > FAR {
            let gamma = (cofactors.norm_squared().sqrt() * inverse.abs() / R.norm_squared().sqrt()).sqrt();
            R *= gamma;
            inverse /= gamma;
        }
        let next = (R + cofactors * inverse) * 0.5;
        let before = change;
        change = (next - R).norm_squared().sqrt();
        R = next;
        // quadratic convergence: the step after one of 1e-8 is rounding
        if change < 1e-8 && before < 1.0 {
            return Some(R);
        }
    }
    None
}

/// The matrix of cofactors and the determinant.
fn cofactors(of: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let [a, b, c]: [Vector3<f64>; 3] = [0, 1, 2].map(|k| of.column(k).into());
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    let determinant = a.dot(&bc);
    (Matrix3::from_columns(&[bc, ca, ab]), determinant)
}

/// What energy, stress and tangent have in common.
#[allow(non_snake_case)]
struct Parts {
    energy: f64,
    stress: Matrix3<f64>,
    R: Matrix3<f64>,
    S: Matrix3<f64>,
}

/// Nothing where F is singular or turned inside out.
#[allow(non_snake_case)]
fn parts(F: &Matrix3<f64>, lame: Lame) -> Option<Parts> {
    if F.determinant() <= 0.0 {
        return None;
    }
    let R = turn_of(F)?;
    let S = R.transpose() * F;
    let swell = S.trace() - 3.0;
    let energy = lame.mu * (F - R).norm_squared() + 0.5 * lame.lambda * swell * swell;
    let stress = (F - R) * (2.0 * lame.mu) + R * (lame.lambda * swell);
    Some(Parts { energy, stress, R, S })
}

#[allow(non_snake_case)]
impl Material for Corotated {
    fn name(&self) -> &'static str {
        "corotated"
    }

    /// A mirrored tetrahedron would cost nothing by the formula alone; here it costs an infinite energy.
    fn stress(&self, F: &Matrix3<f64>, lame: Lame) -> (f64, Matrix3<f64>) {
        match parts(F, lame) {
            Some(parts) => (parts.energy, parts.stress),
            None => (f64::INFINITY, Matrix3::zeros()),
        }
    }

    /// dP = 2μ dF + λ (R : dF) R + (λ tr(S − I) − 2μ) dR,  dR = Σ_kl Q_k (tr(S) I − S)⁻¹_kl (Q_l : dF),  Q_k = R [e_k]×
    fn response(&self, F: &Matrix3<f64>, lame: Lame) -> Response {
        let broken = Response { energy: f64::INFINITY, stress: Matrix3::zeros(), tangent: Tangent::zeros() };
        let Some(Parts { energy, stress, R, S }) = parts(F, lame) else {
            return broken;
        };
        let Some(pliancy) = (Matrix3::identity() * S.trace() - S).try_inverse() else {
            return broken;
        };
        let mut Q = SMatrix::<f64, 9, 3>::zeros();
        for k in 0..3 {
            let (before, after) = ((k + 1) % 3, (k + 2) % 3);
            for i in 0..3 {
                // R [e_k]× : column `before` is R's column `after`, column `after` is minus R's column `before`
                Q[(i + 3 * before, k)] = R[(i, after)];
                Q[(i + 3 * after, k)] = -R[(i, before)];
            }
        }
        let turn = lame.lambda * (S.trace() - 3.0) - 2.0 * lame.mu;
        let r = SMatrix::<f64, 9, 1>::from_column_slice(R.as_slice());
        let mut tangent = Q * (pliancy * turn) * Q.transpose() + r * r.transpose() * lame.lambda;
        for entry in 0..9 {
            tangent[(entry, entry)] += 2.0 * lame.mu;
        }
        Response { energy, stress, tangent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn the_turn_of_a_stretched_and_turned_matrix_is_its_rotation() {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.4, -2.0, 1.1)).into_inner();
        let stretch = Matrix3::new(3.0, 0.2, 0.0, 0.2, 0.01, 0.0, 0.0, 0.0, 1.0);
        let stretch = stretch + Matrix3::identity() * 0.1;
        assert!((turn_of(&(turn * stretch)).unwrap() - turn).norm() < 1e-13);
    }

    #[test]
    fn a_mirrored_tetrahedron_costs_an_infinite_energy() {
        let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
        assert!(Corotated.stress(&mirror, Lame { mu: 1.0, lambda: 1.0 }).0.is_infinite());
    }
}
