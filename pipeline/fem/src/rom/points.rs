//! Quadrature points of the full model as a reduced one samples them.

use crate::system_data::SystemData;
use nalgebra::DMatrix;

use super::elastic_forces::ModeGradient;

/// The shares of the μ and λ parts of the energy that a quadrature point of the full model integrates.
pub(super) fn point_shares(system: &SystemData, point: u32) -> [f64; 2] {
    system.reference.shares[point as usize % system.reference.points]
}

/// Every quadrature point of a region by its number in the full model.
pub(super) fn points_of_region(system: &SystemData, region: usize) -> Vec<u32> {
    let inside = (0..system.mesh.elements.len()).filter(|e| system.mesh.regions[*e] as usize == region);
    inside
        .flat_map(|e| e * system.reference.points..(e + 1) * system.reference.points)
        .map(|point| point as u32)
        .collect()
}

/// G of a quadrature point: column m holds Σ_a V_a,m ⊗ ∇N_a.
pub(super) fn mode_gradient(system: &SystemData, point: u32, modes: &DMatrix<f64>) -> ModeGradient {
    let (point, element) = (point as usize, point as usize / system.reference.points);
    let nodes = system.mesh.elements.nodes(element);
    let gradients = &system.reference.gradients[point * nodes.len()..(point + 1) * nodes.len()];
    let mut mode_gradient = ModeGradient::zeros(modes.ncols());
    for (node, gradient) in nodes.iter().zip(gradients) {
        let rows = modes.rows(3 * *node as usize, 3);
        for (axis, derivative) in gradient.iter().enumerate() {
            let mut part = mode_gradient.rows_mut(3 * axis, 3);
            part += rows * *derivative;
        }
    }
    mode_gradient
}
