//! Jacobian determinants of tetrahedra of four and ten nodes.

use crate::cavities::GAUSS;
use si::vec3::{add, cross, dot, scale};
use si::{CubicMetre, Point3};

/// Volume of an element, m³, and the least determinant (6 × volume when it is constant) at its points, m³.
pub(super) fn volume_and_least(corners: &[Point3]) -> (CubicMetre, f64) {
    if corners.len() == 4 {
        let det = jacobian_determinant(corners, [0.25; 3]);
        return (det / 6.0, det);
    }
    let (mut volume, mut least) = (0.0, f64::INFINITY);
    for (x, a) in GAUSS {
        for (v, b) in GAUSS {
            for (w, c) in GAUSS {
                let (y, z) = (v * (1.0 - x), w * (1.0 - x) * (1.0 - v));
                let det = jacobian_determinant(corners, [x, y, z]);
                volume += a * b * c * (1.0 - x) * (1.0 - x) * (1.0 - v) * det;
                least = least.min(det);
            }
        }
    }
    let corners_of = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    (volume, corners_of.into_iter().map(|at| jacobian_determinant(corners, at)).fold(least, f64::min))
}

/// det ∂x/∂ξ at ξ of the reference tetrahedron.
fn jacobian_determinant(corners: &[Point3], point: Point3) -> f64 {
    let shape_gradients = shape_gradients(corners.len(), point);
    let derivative_by = |k: usize| {
        shape_gradients.iter().zip(corners).fold([0.0; 3], |sum, (gradient, x)| add(sum, scale(*x, gradient[k])))
    };
    dot(cross(derivative_by(0), derivative_by(1)), derivative_by(2))
}

/// ∂N/∂ξ of each node: corners, then the middles of 01, 12, 02, 03, 13, 23.
fn shape_gradients(nodes: usize, [x, y, z]: Point3) -> Vec<Point3> {
    let share = [1.0 - x - y - z, x, y, z];
    let share_gradients: [Point3; 4] = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if nodes == 4 {
        return share_gradients.to_vec();
    }
    let corner = |k: usize| scale(share_gradients[k], 4.0 * share[k] - 1.0);
    let middle =
        |[a, b]: [usize; 2]| add(scale(share_gradients[a], 4.0 * share[b]), scale(share_gradients[b], 4.0 * share[a]));
    (0..4).map(corner).chain(crate::quadratic::EDGES.into_iter().map(middle)).collect()
}
