//! Stress of each element at its centroid.
//!
//! σ = P Fᵀ / det F; von Mises' stress is √(3/2 s : s) of its deviator s. A region with mean dilatation is read at its
//! centroid like any other: that changes its mean stress, on which von Mises' stress does not depend.

use fem::RegionProperties;
use mesh::Solid;
use nalgebra::{Matrix3, Vector3};
use si::Pascal;

/// Stress and energy density of one element.
pub(super) struct Stress {
    /// Pa.
    pub von_mises: Pascal,
    /// ψ, J per rest volume, m³.
    pub energy_density: f64,
}

/// By element, at `displacement` (3 a node, m).
pub(super) fn element_stresses(solid: &Solid, displacement: &[f64], properties: &[RegionProperties]) -> Vec<Stress> {
    (0..solid.len()).map(|element| element_stress(solid, element, displacement, properties)).collect()
}

#[allow(non_snake_case)]
fn element_stress(solid: &Solid, element: usize, displacement: &[f64], properties: &[RegionProperties]) -> Stress {
    let region = &properties[usize::from(solid.regions()[element])];
    let moduli = region.moduli();
    let F = deformation_gradient(solid, element, displacement);
    let (energy_density, P) = region.material.energy_and_stress(&F, moduli);
    let sigma = P * F.transpose() / F.determinant();
    let deviator = sigma - Matrix3::identity() * (sigma.trace() / 3.0);
    Stress { von_mises: (1.5 * deviator.norm_squared()).sqrt(), energy_density }
}

/// F = I + ∂u/∂X at the centroid.
fn deformation_gradient(solid: &Solid, element: usize, displacement: &[f64]) -> Matrix3<f64> {
    let (mut rest, mut moved) = (Matrix3::zeros(), Matrix3::zeros());
    let nodes = solid.element(element);
    for (&node, slope) in nodes.iter().zip(shape_slopes(nodes)) {
        let node = node as usize;
        rest += Vector3::from(solid.nodes()[node]) * slope.transpose();
        moved += Vector3::from_column_slice(&displacement[3 * node..3 * node + 3]) * slope.transpose();
    }
    let back = rest.try_inverse().unwrap_or_else(Matrix3::zeros);
    Matrix3::identity() + moved * back
}

/// ∂N/∂ξ of each of the 4, 10 or 20 nodes of an element at the centroid of its reference element.
fn shape_slopes(nodes: &[u32]) -> Vec<Vector3<f64>> {
    match nodes.len() {
        20 if nodes[2] == nodes[3] => slopes_of_wedge(),
        20 => slopes_of_hexahedron(),
        count => slopes_of_tetrahedron(count),
    }
}

/// Where every share is ¼, corners add nothing to a tetrahedron of ten nodes.
fn slopes_of_tetrahedron(nodes: usize) -> Vec<Vector3<f64>> {
    let barycentric_slopes = [Vector3::repeat(-1.0), Vector3::x(), Vector3::y(), Vector3::z()];
    if nodes == 4 {
        return barycentric_slopes.to_vec();
    }
    let middles =
        [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]].map(|[a, b]| barycentric_slopes[a] + barycentric_slopes[b]);
    [Vector3::zeros(); 4].into_iter().chain(middles).collect()
}

/// Edges of a hexahedron in the order of their middles.
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// −¼ towards each corner; ½ towards the middle of each edge, across it.
fn slopes_of_hexahedron() -> Vec<Vector3<f64>> {
    let sign = |n: usize, on: &[usize]| if on.contains(&n) { 1.0 } else { -1.0 };
    let corner = |n: usize| Vector3::new(sign(n, &[1, 2, 5, 6]), sign(n, &[2, 3, 6, 7]), sign(n, &[4, 5, 6, 7]));
    let middles = EDGES.iter().map(|&[a, b]| 0.25 * (corner(a) + corner(b)));
    (0..8).map(|n| -0.25 * corner(n)).chain(middles).collect()
}

/// At a wedge's centroid; zero at the nodes that it names again.
fn slopes_of_wedge() -> Vec<Vector3<f64>> {
    let barycentric_slopes = [Vector3::new(-1.0, -1.0, 0.0), Vector3::x(), Vector3::y()];
    let mut slopes = vec![Vector3::zeros(); 20];
    for (end, side) in [(0, -1.0), (1, 1.0)] {
        for n in 0..3 {
            let next = (n + 1) % 3;
            slopes[4 * end + n] = -barycentric_slopes[n] / 3.0 - Vector3::z() * (side / 9.0);
            slopes[8 + 4 * end + [0, 1, 3][n]] =
                (barycentric_slopes[n] + barycentric_slopes[next]) * (2.0 / 3.0) + Vector3::z() * (4.0 * side / 9.0);
        }
    }
    (0..3).for_each(|n| slopes[16 + n] = barycentric_slopes[n]);
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_every_element_return_a_gradient_and_sum_to_zero() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let cube = |n: usize| Vector3::new(corners[n % 4][0], corners[n % 4][1], (n / 4) as f64);
        let flat = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]];
        let wedge = |n: usize| Vector3::new(flat[n % 4][0], flat[n % 4][1], (n / 4) as f64);
        let places = |corner: &dyn Fn(usize) -> Vector3<f64>| -> Vec<Vector3<f64>> {
            (0..8).map(corner).chain(EDGES.iter().map(|&[a, b]| 0.5 * (corner(a) + corner(b)))).collect()
        };
        for (slopes, places) in [(slopes_of_hexahedron(), places(&cube)), (slopes_of_wedge(), places(&wedge))] {
            let gradient = slopes.iter().zip(&places).map(|(slope, at)| at * slope.transpose()).sum::<Matrix3<f64>>();
            assert!((gradient - Matrix3::identity()).norm() < 1e-14, "{gradient}");
            // quadratic terms of a field: x² has the slope 2 x at the centroid
            let square = slopes.iter().zip(&places).map(|(slope, at)| slope * at.x * at.x).sum::<Vector3<f64>>();
            let middle = places.iter().zip(&slopes).filter(|(_, s)| s.norm() > 0.0).count();
            let x = if middle == 15 { 1.0 / 3.0 } else { 0.5 };
            assert!((square - Vector3::x() * (2.0 * x)).norm() < 1e-14, "{square}");
            assert!(slopes.iter().sum::<Vector3<f64>>().norm() < 1e-14);
        }
    }
}
