//! Turns: how far the body around each node has turned since a factor was made, so that the factor can turn with it.
//!
//! A body that has bent since has another stiffness matrix, but near each node it is the old one, turned: K ≈ R K₀ Rᵀ
//! with R the turns of the nodes, block by block. R K₀⁻¹ Rᵀ is then a far better inverse than K₀⁻¹ alone. In a stiff
//! sheet inside silicone, where an error of the angle counts by its square times the ratio of the moduli, it lets one
//! factor serve many time steps.
//!
//! Stands on: `assembly`, `materials` (polar decomposition). Never knows: why the body has bent.

use crate::algebra::sparse::HELD;
use crate::body::assembly::{Body, Elastic};
use crate::materials::turn_of;
use nalgebra::Matrix3;

/// One turn for each node, acting on its freedoms.
#[derive(Debug, Clone)]
pub(crate) struct Turn {
    nodes: Vec<Matrix3<f64>>,
}

impl Turn {
    /// The turns between the displacements `from` and `to` (3 a node, m).
    ///
    /// F at a node is the mean over its elements, each counting by its volume and shear modulus: at a face between
    /// sheet and silicone, the sheet decides.
    pub fn between(body: &Body, elastic: &[Elastic], from: &[f64], to: &[f64]) -> Self {
        let (then, now) = (node_gradients(body, elastic, from), node_gradients(body, elastic, to));
        let nodes = then.iter().zip(&now).zip(&body.pattern.freedom).map(|((then, now), freedom)| {
            match (turn_of(then), turn_of(now)) {
                (Some(then), Some(now)) => allowed(now * then.transpose(), freedom),
                _ => Matrix3::identity(),
            }
        });
        Self { nodes: nodes.collect() }
    }

    /// x ← R x, or Rᵀ x when `back`; x in elimination order.
    pub fn apply(&self, freedom: &[[u32; 3]], back: bool, x: &mut [f64]) {
        for (turn, freedom) in self.nodes.iter().zip(freedom) {
            let mut turned = [0.0; 3];
            for (i, turned) in turned.iter_mut().enumerate() {
                for (k, &at) in freedom.iter().enumerate().filter(|(_, at)| **at != HELD) {
                    *turned += if back { turn[(k, i)] } else { turn[(i, k)] } * x[at as usize];
                }
            }
            for (&at, turned) in freedom.iter().zip(turned).filter(|(at, _)| **at != HELD) {
                x[at as usize] = turned;
            }
        }
    }
}

/// Σ w μ F / Σ w μ over the quadrature points of each node's elements, up to its size.
fn node_gradients(body: &Body, elastic: &[Elastic], u: &[f64]) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); body.mesh.nodes.len()];
    body.each_gradient(elastic, u, &mut |nodes, mean| {
        nodes.iter().for_each(|&node| sums[node as usize] += mean);
    });
    sums
}

/// The part of a turn that keeps held freedoms at rest: all of it, a turn about the one held axis, or nothing.
fn allowed(turn: Matrix3<f64>, freedom: &[u32; 3]) -> Matrix3<f64> {
    match freedom.map(|at| at == HELD) {
        [false, false, false] => turn,
        [false, false, true] => about(turn, 0, 1),
        [true, false, false] => about(turn, 1, 2),
        [false, true, false] => about(turn, 2, 0),
        _ => Matrix3::identity(),
    }
}

/// The turn in the plane of axes i and k that is nearest to `turn`.
fn about(turn: Matrix3<f64>, i: usize, k: usize) -> Matrix3<f64> {
    let (cosine, sine) = (turn[(i, i)] + turn[(k, k)], turn[(k, i)] - turn[(i, k)]);
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
    fn a_turn_in_a_plane_is_kept_when_its_axis_is_held() {
        let turn = Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), 0.7).into_inner();
        assert!((allowed(turn, &[4, 5, HELD]) - turn).norm() < 1e-15);
        assert_eq!(allowed(turn, &[4, HELD, HELD]), Matrix3::identity());
    }

    #[test]
    fn a_turn_and_its_way_back_leave_a_vector_as_it_was() {
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let all = Turn { nodes: vec![turn, about(turn, 0, 1)] };
        let freedom = [[2, 3, 4], [0, 1, HELD]];
        let start = [1.0, -2.0, 0.5, 3.0, -0.2];
        let mut x = start;
        all.apply(&freedom, false, &mut x);
        assert!(x.iter().zip(start).any(|(x, start)| (x - start).abs() > 0.1));
        all.apply(&freedom, true, &mut x);
        assert!(x.iter().zip(start).all(|(x, start)| (x - start).abs() < 1e-14));
    }
}
