//! Clamps: which nodes are held at rest, and along which axes.
//!
//! Stands on: `mesh`. Never knows: a load, a matrix.

use crate::mesh::Mesh;
use si::Metre;
use std::collections::BTreeMap;

/// Nodes × axes that do not move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clamps {
    held: BTreeMap<u32, [bool; 3]>,
}

impl Clamps {
    /// Nothing held.
    pub fn none() -> Self {
        Self::default()
    }

    /// Every node with x ≤ `limit` (m), held along all axes.
    pub fn below_x(mesh: &Mesh, limit: Metre) -> Self {
        Self::where_nodes(mesh, [true; 3], |at| at[0] <= limit)
    }

    /// Every node whose rest position satisfies `chosen`, held along the `axes` that are true.
    pub fn where_nodes(mesh: &Mesh, axes: [bool; 3], chosen: impl Fn(si::Point3) -> bool) -> Self {
        let mut clamps = Self::none();
        for (node, &at) in mesh.nodes.iter().enumerate() {
            if chosen(at) {
                clamps.hold(node as u32, axes);
            }
        }
        clamps
    }

    /// Holds `node` along the `axes` that are true, beside what held it before.
    pub fn hold(&mut self, node: u32, axes: [bool; 3]) {
        let held = self.held.entry(node).or_default();
        for axis in 0..3 {
            held[axis] |= axes[axis];
        }
    }

    /// These clamps and `other`'s together.
    pub fn and(mut self, other: &Clamps) -> Self {
        for (&node, &axes) in &other.held {
            self.hold(node, axes);
        }
        self
    }

    /// Nodes held along at least one axis, in rising order, with their axes.
    pub fn iter(&self) -> impl Iterator<Item = (u32, [bool; 3])> + '_ {
        self.held.iter().map(|(&node, &axes)| (node, axes))
    }

    /// How many nodes are held along at least one axis.
    pub fn len(&self) -> usize {
        self.held.len()
    }

    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// Adds z of every node on the plane z = 0 when `mesh` is a half model.
    pub(crate) fn with_symmetry(mut self, mesh: &Mesh) -> Self {
        if mesh.symmetry_plane_z {
            let size = mesh.size();
            for node in (0..mesh.nodes.len()).filter(|&node| mesh.on_symmetry_plane(node, size)) {
                self.hold(node as u32, [false, false, true]);
            }
        }
        self
    }
}

impl From<&[u32]> for Clamps {
    fn from(nodes: &[u32]) -> Self {
        Self { held: nodes.iter().map(|&node| (node, [true; 3])).collect() }
    }
}

impl From<&Vec<u32>> for Clamps {
    fn from(nodes: &Vec<u32>) -> Self {
        nodes.as_slice().into()
    }
}

impl From<&Clamps> for Clamps {
    fn from(clamps: &Clamps) -> Self {
        clamps.clone()
    }
}
