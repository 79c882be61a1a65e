//! Clamps: the nodes and axes with zero displacement (Dirichlet conditions).

use crate::mesh::Mesh;
use si::Metre;
use std::collections::BTreeMap;

/// Constrained nodes and axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clamps {
    axes: BTreeMap<u32, [bool; 3]>,
}

impl Clamps {
    /// No constraint.
    pub fn none() -> Self {
        Self::default()
    }

    /// Every node with x ≤ `limit` (m), along all axes.
    pub fn below_x(mesh: &Mesh, limit: Metre) -> Self {
        Self::where_nodes(mesh, [true; 3], |at| at[0] <= limit)
    }

    /// Every node whose rest position satisfies `chosen`, along the `axes` that are true.
    pub fn where_nodes(mesh: &Mesh, axes: [bool; 3], chosen: impl Fn(si::Point3) -> bool) -> Self {
        let mut clamps = Self::none();
        for (node, &at) in mesh.nodes.iter().enumerate() {
            if chosen(at) {
                clamps.constrain(node as u32, axes);
            }
        }
        clamps
    }

    /// Constrains `node` along the `axes` that are true, in addition to its earlier constraints.
    pub fn constrain(&mut self, node: u32, axes: [bool; 3]) {
        let constrained = self.axes.entry(node).or_default();
        for axis in 0..3 {
            constrained[axis] |= axes[axis];
        }
    }

    /// The union with `other`.
    pub fn and(mut self, other: &Clamps) -> Self {
        for (&node, &axes) in &other.axes {
            self.constrain(node, axes);
        }
        self
    }

    /// Nodes constrained along at least one axis, in ascending order, with their axes.
    pub fn iter(&self) -> impl Iterator<Item = (u32, [bool; 3])> + '_ {
        self.axes.iter().map(|(&node, &axes)| (node, axes))
    }

    /// The constrained axes of each of `nodes` nodes.
    pub(crate) fn by_node(&self, nodes: usize) -> Vec<[bool; 3]> {
        let mut constrained = vec![[false; 3]; nodes];
        self.iter().for_each(|(node, axes)| constrained[node as usize] = axes);
        constrained
    }

    /// Number of nodes constrained along at least one axis.
    pub fn len(&self) -> usize {
        self.axes.len()
    }

    /// Whether no node is constrained.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// Constrains z of every node on the symmetry plane when `mesh` is a half model.
    pub(crate) fn with_symmetry(mut self, mesh: &Mesh) -> Self {
        if mesh.symmetry_plane_z {
            let size = mesh.size();
            for node in (0..mesh.nodes.len()).filter(|&node| mesh.on_symmetry_plane(node, size)) {
                self.constrain(node as u32, [false, false, true]);
            }
        }
        self
    }
}

impl From<&[u32]> for Clamps {
    fn from(nodes: &[u32]) -> Self {
        Self { axes: nodes.iter().map(|&node| (node, [true; 3])).collect() }
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
