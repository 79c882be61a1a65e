//! Mesh of a solid: nodes, tetrahedra or hexahedra with a region each, and the walls of its chambers.
//!
//! Plain arrays in SI units, so that any mesher can fill them. [`crate::System::new`] validates them.

pub mod box_mesh;
pub(crate) mod clamps;
pub mod wedges;

use crate::assembly::shape_functions::{element as shape_functions, is_wedge, wedge};
use crate::setup_error::SetupError;
use si::Point3;
use sparse::NodeGraph;

/// Elements of one kind, by node numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Elements {
    /// Four corners; corners 1, 2, 3 are counterclockwise as seen from corner 0's opposite side, so that the volume is
    /// positive.
    Linear(Vec<[u32; 4]>),
    /// Four corners, then the mid-edge nodes of 01, 12, 02, 03, 13, 23 (the order of VTK).
    Quadratic(Vec<[u32; 10]>),
    /// Trilinear hexahedra: four corners of one side, counterclockwise as seen from the inside, then those of the
    /// opposite side in the same order (the order of VTK).
    Hexahedra(Vec<[u32; 8]>),
    /// Hexahedra of second order (serendipity): eight corners as above, then the mid-edge nodes of 01, 12, 23, 30, 45, 56, 67, 74, 04, 15,
    /// 26, 37 (the order of VTK). One whose corners 2 and 3, 6 and 7, and the middles of 23, 67 and 37 with them, are one node is a wedge of 15
    /// nodes.
    QuadraticHexahedra(Vec<[u32; 20]>),
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Self::Linear(tets) => tets.len(),
            Self::Quadratic(tets) => tets.len(),
            Self::Hexahedra(hexahedra) => hexahedra.len(),
            Self::QuadraticHexahedra(hexahedra) => hexahedra.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of nodes of one element: 4, 10, 8 or 20.
    pub fn nodes_each(&self) -> usize {
        match self {
            Self::Linear(_) => 4,
            Self::Quadratic(_) => 10,
            Self::Hexahedra(_) => 8,
            Self::QuadraticHexahedra(_) => 20,
        }
    }

    /// Node numbers of all elements, one after the other.
    fn connectivity(&self) -> &[u32] {
        match self {
            Self::Linear(tets) => tets.as_flattened(),
            Self::Quadratic(tets) => tets.as_flattened(),
            Self::Hexahedra(hexahedra) => hexahedra.as_flattened(),
            Self::QuadraticHexahedra(hexahedra) => hexahedra.as_flattened(),
        }
    }

    /// The elements as lists of `N` nodes, `N` = [`Elements::nodes_each`].
    pub(crate) fn of_order<const N: usize>(&self) -> &[[u32; N]] {
        self.connectivity().as_chunks::<N>().0
    }

    /// The shape functions of `element` at a place of the reference tetrahedron, wedge or cube, whose coordinates go from 0 to 1, one a node: values
    /// and derivatives by the place.
    pub fn shape_functions(&self, element: usize, place: Point3) -> Vec<(f64, Point3)> {
        match self.nodes(element) {
            _ if self.is_wedge(element) => wedge(place),
            nodes => shape_functions(nodes.len(), place),
        }
    }

    /// Whether `element` is a wedge among hexahedra.
    pub fn is_wedge(&self, element: usize) -> bool {
        matches!(self, Self::QuadraticHexahedra(hexahedra) if is_wedge(&hexahedra[element]))
    }

    /// Node numbers of `element`: 4, 10, 8 or 20 of them.
    pub fn nodes(&self, element: usize) -> &[u32] {
        match self {
            Self::Linear(tets) => &tets[element],
            Self::Quadratic(tets) => &tets[element],
            Self::Hexahedra(hexahedra) => &hexahedra[element],
            Self::QuadraticHexahedra(hexahedra) => &hexahedra[element],
        }
    }
}

/// Faces of one kind, by node numbers; the normal of (0, 1, 2) points out of the solid.
#[derive(Debug, Clone, PartialEq)]
pub enum Faces {
    /// Three corners.
    Linear(Vec<[u32; 3]>),
    /// Three corners, then the mid-edge nodes of 01, 12, 20.
    Quadratic(Vec<[u32; 6]>),
    /// Sides of hexahedra of second order: four corners, then the mid-edge nodes of 01, 12, 23, 30. One whose corners 2 and 3, and the middle
    /// of 23, are one node is a triangle.
    QuadraticQuadrilaterals(Vec<[u32; 8]>),
}

impl Faces {
    /// Number of faces.
    pub fn len(&self) -> usize {
        match self {
            Self::Linear(faces) => faces.len(),
            Self::Quadratic(faces) => faces.len(),
            Self::QuadraticQuadrilaterals(faces) => faces.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The faces with these `indices`, of nodes that `number` counts anew.
    pub(crate) fn renumbered(&self, indices: impl Iterator<Item = usize>, number: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Linear(faces) => Self::Linear(indices.map(|face| faces[face].map(&number)).collect()),
            Self::Quadratic(faces) => Self::Quadratic(indices.map(|face| faces[face].map(&number)).collect()),
            Self::QuadraticQuadrilaterals(faces) => {
                Self::QuadraticQuadrilaterals(indices.map(|face| faces[face].map(&number)).collect())
            }
        }
    }

    /// Number of nodes of one face: 3, 6 or 8.
    pub fn nodes_each(&self) -> usize {
        match self {
            Self::Linear(_) => 3,
            Self::Quadratic(_) => 6,
            Self::QuadraticQuadrilaterals(_) => 8,
        }
    }

    /// Node numbers of one face.
    pub fn nodes(&self, face: usize) -> &[u32] {
        match self {
            Self::Linear(faces) => &faces[face],
            Self::Quadratic(faces) => &faces[face],
            Self::QuadraticQuadrilaterals(faces) => &faces[face],
        }
    }
}

/// The wall of one cavity, as part of the surface of the solid: normals point into the cavity.
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
    /// Tetrahedra or hexahedra.
    pub elements: Elements,
    /// Region of each element: an index into the list of [`crate::RegionProperties`].
    pub regions: Vec<u16>,
    /// Cavities that can be pressurised.
    pub chambers: Vec<Chamber>,
    /// Whether this is the half z ≥ 0 of a body that is symmetric about z = 0: nodes on the plane then stay on it.
    pub symmetry_plane_z: bool,
}

impl Mesh {
    /// The corners (least, greatest) of the bounding box of all nodes, m.
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

    /// Largest side of the bounding box, m: the length that tolerances are relative to.
    pub fn size(&self) -> f64 {
        let (low, high) = self.bounds();
        (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
    }

    /// Whether a `part` (an edge, a face) has one of these numbers of nodes, all of which exist.
    pub(crate) fn check_side(
        &self,
        part: &'static str,
        nodes: &[u32],
        each: &'static [usize],
    ) -> Result<(), SetupError> {
        if !each.contains(&nodes.len()) {
            return Err(SetupError::Side { part, given: nodes.len(), each });
        }
        match nodes.iter().enumerate().find(|(_, node)| **node as usize >= self.nodes.len()) {
            Some((index, &node)) => Err(SetupError::NoSuchNode { part, index, node, nodes: self.nodes.len() }),
            None => Ok(()),
        }
    }

    /// Which nodes share an element.
    pub(crate) fn graph(&self) -> NodeGraph {
        NodeGraph::new(self.nodes.len(), self.elements.connectivity(), self.elements.nodes_each())
    }

    /// Whether `node` lies on the plane z = 0, to a ten-millionth of the size.
    pub(crate) fn on_symmetry_plane(&self, node: usize, size: f64) -> bool {
        self.nodes[node][2].abs() <= 1e-7 * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Clamps;

    #[test]
    fn a_box_has_elements_and_no_chamber_is_empty_only_without_faces() {
        let mesh = box_mesh::quadratic([0.1; 3], [1, 1, 1]);
        assert!(!mesh.elements.is_empty() && mesh.elements.len() == mesh.elements.connectivity().len() / 10);
        let (none, one) = (Faces::Linear(Vec::new()), Faces::Quadratic(vec![[0, 1, 2, 3, 4, 5]]));
        assert!(none.is_empty() && !one.is_empty());
        assert_eq!((one.len(), one.nodes(0)), (1, &[0, 1, 2, 3, 4, 5][..]));
        let clamps = Clamps::below_x(&mesh, 1e-9);
        // the nine nodes of a side of two triangles with midpoints
        assert!(!clamps.is_empty() && clamps.len() == 9 && Clamps::none().is_empty());
    }
}
