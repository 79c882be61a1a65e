//! Nodal rotations: how far the body around each node has rotated since a factorisation, so that the factor can be
//! rotated with it (corotated preconditioner).
//!
//! A bent body has another stiffness matrix, but near each node it is the old one, rotated: K ≈ R K₀ Rᵀ with the
//! block-diagonal R of nodal rotations. R K₀⁻¹ Rᵀ is then a far better preconditioner than K₀⁻¹ alone. In a stiff sheet
//! inside silicone, where an error of the angle enters by its square times the ratio of the moduli, it lets one factor
//! serve many time steps.

use crate::assembly::elastic::Body;
use materials::polar_rotation;
use nalgebra::Matrix3;
use sparse::CONSTRAINED;

/// One rotation per node, acting on its dofs.
#[derive(Debug, Clone)]
pub(crate) struct NodalRotations {
    nodes: Vec<Matrix3<f64>>,
}

impl NodalRotations {
    /// The rotations between the displacements `from` and `to` (3 per node, m), by polar decomposition.
    // F at a node is the mean over its elements, weighted by volume and shear modulus: at an interface between sheet
    // and silicone the rotation of the sheet counts, whose stiffness dominates the error of the preconditioner.
    pub fn between(body: &Body, from: &[f64], to: &[f64]) -> Self {
        let (then, now) = (nodal_gradients(body, from), nodal_gradients(body, to));
        let nodes = then.iter().zip(&now).zip(&body.pattern.dof).map(|((then, now), dof)| {
            // Where an inverted element leaves no rotation the factor is not turned: it preconditions worse, and the
            // solution is the same.
            match (polar_rotation(then), polar_rotation(now)) {
                (Some(then), Some(now)) => admissible_rotation(now * then.transpose(), dof),
                _ => Matrix3::identity(),
            }
        });
        Self { nodes: nodes.collect() }
    }

    /// x ← R x, or Rᵀ x when `transposed`; x in elimination order.
    pub fn apply(&self, dofs: &[[u32; 3]], transposed: bool, x: &mut [f64]) {
        for (rotation, dof) in self.nodes.iter().zip(dofs) {
            let mut rotated = [0.0; 3];
            for (i, rotated) in rotated.iter_mut().enumerate() {
                for (k, &at) in dof.iter().enumerate().filter(|(_, at)| **at != CONSTRAINED) {
                    *rotated += if transposed { rotation[(k, i)] } else { rotation[(i, k)] } * x[at as usize];
                }
            }
            for (&at, rotated) in dof.iter().zip(rotated).filter(|(at, _)| **at != CONSTRAINED) {
                x[at as usize] = rotated;
            }
        }
    }
}

/// Σ w μ F over the quadrature points of each node's elements; only its rotation is used.
fn nodal_gradients(body: &Body, u: &[f64]) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); body.mesh.nodes.len()];
    body.for_each_mean_gradient(u, &mut |nodes, mean| {
        nodes.iter().for_each(|&node| sums[node as usize] += mean);
    });
    sums
}

/// The part of a rotation that respects the constraints: all of it, a rotation about the one constrained axis, or none.
fn admissible_rotation(rotation: Matrix3<f64>, dof: &[u32; 3]) -> Matrix3<f64> {
    match dof.map(|at| at == CONSTRAINED) {
        [false, false, false] => rotation,
        [false, false, true] => about_axis(rotation, 0, 1),
        [true, false, false] => about_axis(rotation, 1, 2),
        [false, true, false] => about_axis(rotation, 2, 0),
        _ => Matrix3::identity(),
    }
}

/// The rotation in the plane of axes i and k that is nearest to `rotation`.
fn about_axis(rotation: Matrix3<f64>, i: usize, k: usize) -> Matrix3<f64> {
    let (cosine, sine) = (rotation[(i, i)] + rotation[(k, k)], rotation[(k, i)] - rotation[(i, k)]);
    let size = cosine.hypot(sine);
    let mut plane = Matrix3::identity();
    if size > 0.0 {
        (plane[(i, i)], plane[(k, k)]) = (cosine / size, cosine / size);
        (plane[(k, i)], plane[(i, k)]) = (sine / size, -sine / size);
    }
    plane
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn a_rotation_in_a_plane_is_admissible_when_its_axis_is_constrained() {
        let rotation = Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.7).into_inner();
        assert!((admissible_rotation(rotation, &[4, 5, CONSTRAINED]) - rotation).norm() < 1e-15);
        assert_eq!(admissible_rotation(rotation, &[4, CONSTRAINED, CONSTRAINED]), Matrix3::identity());
    }

    #[test]
    fn a_rotation_and_its_transpose_leave_a_vector_unchanged() {
        let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let all = NodalRotations { nodes: vec![rotation, about_axis(rotation, 0, 1)] };
        let dofs = [[2, 3, 4], [0, 1, CONSTRAINED]];
        let start = [1.0, -2.0, 0.5, 3.0, -0.2];
        let mut x = start;
        all.apply(&dofs, false, &mut x);
        assert!(x.iter().zip(start).any(|(x, start)| (x - start).abs() > 0.1));
        all.apply(&dofs, true, &mut x);
        assert!(x.iter().zip(start).all(|(x, start)| (x - start).abs() < 1e-14));
    }
}
