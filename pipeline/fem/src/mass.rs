//! The consistent mass matrix: M_ab = ∫ ρ N_a N_b dV, the same along each axis.
//!
//! Stands on: `rest`, `sparse`. Never knows: a motion, a time step.

use crate::mesh::Mesh;
use crate::rest::{overlap_rule, overlaps};
use crate::sparse::{HELD, Pattern};
use nalgebra::Matrix3;

/// Mass between free nodes, kg; held nodes carry theirs to the clamp.
#[derive(Debug)]
pub(crate) struct Mass {
    /// Lower triangle in the pattern of the stiffness matrix.
    values: Vec<f64>,
}

impl Mass {
    /// From the density of each region, kg/m³.
    pub fn new(mesh: &Mesh, pattern: &Pattern, places: &[u32], densities: &[f64]) -> Self {
        let rule = overlap_rule(mesh.elements.nodes_each());
        let mut values = vec![0.0; pattern.entries()];
        let mut place = places.iter();
        for element in 0..mesh.elements.len() {
            let nodes = mesh.elements.nodes(element);
            let density = densities[mesh.regions[element] as usize];
            let overlap = overlaps(mesh, element, &rule);
            for a in 0..nodes.len() {
                for b in 0..=a {
                    let block = Matrix3::identity() * (density * overlap[a * nodes.len() + b]);
                    let place = *place.next().unwrap_or(&HELD);
                    pattern.add(&mut values, place, (nodes[a], nodes[b]), &block);
                }
            }
        }
        Self { values }
    }

    /// y = M x, both in elimination order.
    pub fn multiply(&self, pattern: &Pattern, x: &[f64], y: &mut [f64]) {
        pattern.multiply(&self.values, x, y);
    }

    /// Adds `scale` M to a matrix of the same pattern.
    pub fn add_to(&self, scale: f64, values: &mut [f64]) {
        values.iter_mut().zip(&self.values).for_each(|(value, mass)| *value += scale * mass);
    }
}
