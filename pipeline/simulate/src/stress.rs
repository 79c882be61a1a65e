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
pub(super) fn stress(solid: &Solid, displacement: &[f64], properties: &[RegionProperties]) -> Vec<Stress> {
    (0..solid.len()).map(|element| one(solid, element, displacement, properties)).collect()
}

#[allow(non_snake_case)]
fn one(solid: &Solid, element: usize, displacement: &[f64], properties: &[RegionProperties]) -> Stress {
    let region = &properties[usize::from(solid.regions()[element])];
    let moduli = region.moduli();
    let F = deformation_gradient(solid, element, displacement);
    let (energy_density, P) = region.material.stress(&F, moduli);
    let sigma = P * F.transpose() / F.determinant();
    let deviator = sigma - Matrix3::identity() * (sigma.trace() / 3.0);
    Stress { von_mises: (1.5 * deviator.norm_squared()).sqrt(), energy_density }
}

/// F = I + ∂u/∂X at the centroid.
fn deformation_gradient(solid: &Solid, element: usize, displacement: &[f64]) -> Matrix3<f64> {
    let (mut rest, mut moved) = (Matrix3::zeros(), Matrix3::zeros());
    let nodes = solid.element(element);
    for (&node, slope) in nodes.iter().zip(slopes(nodes.len())) {
        let node = node as usize;
        rest += Vector3::from(solid.nodes()[node]) * slope.transpose();
        moved += Vector3::from_column_slice(&displacement[3 * node..3 * node + 3]) * slope.transpose();
    }
    let back = rest.try_inverse().unwrap_or_else(Matrix3::zeros);
    Matrix3::identity() + moved * back
}

/// ∂N/∂ξ of each node at the centroid, where every share is ¼: corners add nothing to an element of ten nodes.
fn slopes(nodes: usize) -> Vec<Vector3<f64>> {
    let by = [Vector3::repeat(-1.0), Vector3::x(), Vector3::y(), Vector3::z()];
    if nodes == 4 {
        return by.to_vec();
    }
    let middles = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]].map(|[a, b]| by[a] + by[b]);
    [Vector3::zeros(); 4].into_iter().chain(middles).collect()
}
