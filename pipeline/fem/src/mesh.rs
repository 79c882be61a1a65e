//! What a solid is made of: nodes, tetrahedra with a region each, and the walls of its chambers.
//!
//! Plain arrays in SI, so that any mesher can fill them. Nothing is checked here: [`crate::System::new`] does that.
//!
//! Stands on: `si`. Never knows: a file format, a mesher, a solve.

use si::Point3;

/// Tetrahedra of one order, as node numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Elements {
    /// Four corners; corners 1, 2, 3 turn anticlockwise seen from outside corner 0's opposite face (positive volume).
    Linear(Vec<[u32; 4]>),
    /// Four corners, then the middles of edges 01, 12, 02, 03, 13, 23 (the order of VTK).
    Quadratic(Vec<[u32; 10]>),
}

impl Elements {
    /// How many tetrahedra there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Linear(tets) => tets.len(),
            Self::Quadratic(tets) => tets.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Nodes of one tetrahedron: 4 or 10.
    pub fn nodes_each(&self) -> usize {
        match self {
            Self::Linear(_) => 4,
            Self::Quadratic(_) => 10,
        }
    }

    /// Node numbers of tetrahedron `element`, 4 or 10 of them.
    pub fn nodes(&self, element: usize) -> &[u32] {
        match self {
            Self::Linear(tets) => &tets[element],
            Self::Quadratic(tets) => &tets[element],
        }
    }
}

/// Triangles of one order, as node numbers; the normal of (0, 1, 2) points out of the solid.
#[derive(Debug, Clone, PartialEq)]
pub enum Faces {
    /// Three corners.
    Linear(Vec<[u32; 3]>),
    /// Three corners, then the middles of edges 01, 12, 20.
    Quadratic(Vec<[u32; 6]>),
}

impl Faces {
    /// How many triangles there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Linear(faces) => faces.len(),
            Self::Quadratic(faces) => faces.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Node numbers of triangle `face`, 3 or 6 of them.
    pub fn nodes(&self, face: usize) -> &[u32] {
        match self {
            Self::Linear(faces) => &faces[face],
            Self::Quadratic(faces) => &faces[face],
        }
    }
}

/// The wall of one cavity, seen from the solid: normals point into the cavity.
#[derive(Debug, Clone, PartialEq)]
pub struct Chamber {
    /// Closed, but for edges that lie on the symmetry plane of a half model.
    pub faces: Faces,
}

/// A solid at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Rest positions, m.
    pub nodes: Vec<Point3>,
    /// Tetrahedra between them.
    pub elements: Elements,
    /// Region of each element: an index into the list of [`crate::RegionProperties`].
    pub regions: Vec<u16>,
    /// Cavities that can hold a pressure.
    pub chambers: Vec<Chamber>,
    /// Whether this is the half z ≥ 0 of a body that is symmetric about z = 0: nodes on the plane then stay on it.
    pub symmetry_plane_z: bool,
}

impl Mesh {
    /// The corners (least, greatest) of the box around all nodes, m.
    pub fn bounds(&self) -> (Point3, Point3) {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for node in &self.nodes {
            for axis in 0..3 {
                low[axis] = low[axis].min(node[axis]);
                high[axis] = high[axis].max(node[axis]);
            }
        }
        (low, high)
    }

    /// Largest side of the box around all nodes, m: the length that tolerances are relative to.
    pub fn size(&self) -> f64 {
        let (low, high) = self.bounds();
        (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
    }

    /// Whether `node` lies on the plane z = 0, to a ten-millionth of the size.
    pub(crate) fn on_symmetry_plane(&self, node: usize, size: f64) -> bool {
        self.nodes[node][2].abs() <= 1e-7 * size
    }
}
