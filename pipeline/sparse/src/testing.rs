//! Grids of 8-node cells for the tests of this crate.

use crate::node_graph::NodeGraph;
use si::Point3;

/// A box of cells, nodes along z fastest.
pub(crate) struct Grid {
    /// m.
    pub nodes: Vec<Point3>,
    pub elements: Vec<[u32; 8]>,
}

impl Grid {
    /// `cells` of unit size along each axis.
    pub fn new(cells: [u32; 3]) -> Self {
        let [nx, ny, nz] = cells.map(|count| count + 1);
        let position = |n: u32| [n / (ny * nz), n / nz % ny, n % nz].map(f64::from);
        let corner = |[x, y, z]: [u32; 3], k: u32| (x + k / 4) * ny * nz + (y + k / 2 % 2) * nz + z + k % 2;
        let cell = |n: u32| [n / (cells[1] * cells[2]), n / cells[2] % cells[1], n % cells[2]];
        let elements = (0..cells.iter().product()).map(|n| std::array::from_fn(|k| corner(cell(n), k as u32)));
        Self { nodes: (0..nx * ny * nz).map(position).collect(), elements: elements.collect() }
    }

    pub fn graph(&self) -> NodeGraph {
        NodeGraph::new(self.nodes.len(), self.elements.as_flattened(), 8)
    }

    /// The axes of each node when the nodes at x = 0 are constrained.
    pub fn first_layer_constrained(&self) -> Vec<[bool; 3]> {
        self.nodes.iter().map(|position| [position[0] == 0.0; 3]).collect()
    }
}
