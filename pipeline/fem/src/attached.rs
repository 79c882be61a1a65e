//! Attached masses: weights, sensors and magnets that hang on nodes and move with them.
//!
//! Stands on: `mesh`, `si`. Never knows: a density, a matrix.

use crate::body::rest::triangle_overlaps;
use crate::mesh::Mesh;
use std::collections::BTreeMap;

/// Mass on nodes beside the body's own, kg.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Masses {
    by_node: BTreeMap<u32, f64>,
}

impl Masses {
    /// Nothing attached.
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds `mass` (kg) at `node`.
    pub fn on_node(mut self, node: u32, mass: f64) -> Self {
        *self.by_node.entry(node).or_insert(0.0) += mass;
        self
    }

    /// Adds a layer of `per_area` (kg/m²) on a side of an element, 3 or 6 nodes of `mesh`; each node takes a positive
    /// share (the diagonal of the layer's own mass matrix, as in a lumped element).
    ///
    /// # Panics
    /// When a node does not exist.
    pub fn on_face(mut self, mesh: &Mesh, face: &[u32], per_area: f64) -> Self {
        let overlaps = triangle_overlaps(mesh, face);
        let count = face.len();
        let area: f64 = overlaps.iter().sum();
        let trace: f64 = (0..count).map(|a| overlaps[a * count + a]).sum();
        for (a, &node) in face.iter().enumerate() {
            self = self.on_node(node, per_area * area * overlaps[a * count + a] / trace);
        }
        self
    }

    /// Nodes that carry something, in rising order, each with its mass in kg.
    pub fn iter(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.by_node.iter().map(|(&node, &mass)| (node, mass))
    }
}
