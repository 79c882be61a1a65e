//! Jacobian determinants of tetrahedra of four and ten nodes.

use crate::cavities::GAUSS;
use si::vec3::{add, cross, dot, scale};
use si::{CubicMetre, Point3};

const REFERENCE_CORNERS: [Point3; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

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
    (volume, REFERENCE_CORNERS.into_iter().map(|corner| jacobian_determinant(corners, corner)).fold(least, f64::min))
}

/// The least Bézier coefficient of the determinant of an element of ten nodes, m³: it is nowhere smaller.
pub(crate) fn least_determinant(nodes: &[Point3; 10]) -> f64 {
    // ∂x/∂ξ is linear in ξ: its values at the corners give it everywhere, and each coefficient is the mean of the
    // determinants that take their columns from three corners in all orders
    let at_corners = REFERENCE_CORNERS.map(|corner| derivatives(nodes, corner));
    let mixed = |[i, j, k]: [usize; 3]| triple_product([at_corners[i][0], at_corners[j][1], at_corners[k][2]]);
    let coefficient = |i: usize, j: usize, k: usize| {
        [[i, j, k], [j, k, i], [k, i, j], [j, i, k], [i, k, j], [k, j, i]].map(mixed).iter().sum::<f64>() / 6.0
    };
    let triples = (0..4).flat_map(|i| (i..4).flat_map(move |j| (j..4).map(move |k| (i, j, k))));
    triples.map(|(i, j, k)| coefficient(i, j, k)).fold(f64::INFINITY, f64::min)
}

/// det ∂x/∂ξ at ξ of the reference tetrahedron.
fn jacobian_determinant(corners: &[Point3], point: Point3) -> f64 {
    triple_product(derivatives(corners, point))
}

fn triple_product([a, b, c]: [Point3; 3]) -> f64 {
    dot(cross(a, b), c)
}

/// ∂x/∂ξ, by the three coordinates of the reference tetrahedron.
fn derivatives(corners: &[Point3], point: Point3) -> [Point3; 3] {
    let shape_gradients = shape_gradients(corners.len(), point);
    [0, 1, 2].map(|k| {
        shape_gradients.iter().zip(corners).fold([0.0; 3], |sum, (gradient, x)| add(sum, scale(*x, gradient[k])))
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadratic::EDGES;

    /// The reference element, with its middles moved by what a number of their own says.
    fn element(strength: f64) -> [Point3; 10] {
        let middle = |[a, b]: [usize; 2]| scale(add(REFERENCE_CORNERS[a], REFERENCE_CORNERS[b]), 0.5);
        let offset = |edge: usize| [0, 1, 2].map(|k| strength * ((7 * edge + 3 * k + 1) as f64).sin());
        std::array::from_fn(|n| if n < 4 { REFERENCE_CORNERS[n] } else { add(middle(EDGES[n - 4]), offset(n)) })
    }

    #[test]
    fn the_least_coefficient_is_below_every_sample_and_near_the_least() {
        assert!((least_determinant(&element(0.0)) - 1.0).abs() < 1e-15);
        for strength in [0.02, 0.05, 0.1] {
            let nodes = element(strength);
            let places =
                (0..=20).flat_map(|i| (0..=20 - i).flat_map(move |j| (0..=20 - i - j).map(move |k| [i, j, k])));
            let samples = places.map(|p| jacobian_determinant(&nodes, p.map(|i| f64::from(i) / 20.0)));
            let (bound, least) = (least_determinant(&nodes), samples.fold(f64::INFINITY, f64::min));
            assert!(bound <= least + 1e-12 && least - bound < 4.0 * strength, "{strength}: {bound} {least}");
        }
    }
}
