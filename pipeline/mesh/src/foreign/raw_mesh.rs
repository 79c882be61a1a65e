//! Raw meshes: the content of a file of tetrahedra or hexahedra, before any check.

use si::Point3;
use std::collections::BTreeMap;
use std::error::Error;

/// A file that violates its format.
#[derive(Debug, thiserror::Error)]
#[error("{place}{what}\n  why: {why}\n  do:  {action}")]
pub struct MeshFileError {
    /// Where in the file, followed by a colon and a space; empty for the whole file.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What was expected.
    pub why: String,
    /// What to do.
    pub action: String,
    /// The parser's error, where there was one.
    #[source]
    pub source: Option<Box<dyn Error + Send + Sync>>,
}

impl MeshFileError {
    pub(super) fn new(what: impl Into<String>, why: impl Into<String>, action: impl Into<String>) -> Self {
        let (what, why, action) = (what.into(), why.into(), action.into());
        Self { place: String::new(), what, why, action, source: None }
    }

    pub(super) fn caused_by(self, source: impl Error + Send + Sync + 'static) -> Self {
        Self { source: Some(Box::new(source)), ..self }
    }

    pub(super) fn at_place(mut self, place: impl Into<String>) -> Self {
        self.place = place.into();
        self
    }
}

/// Nodes and tetrahedra as a file gives them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawMesh {
    /// Node positions, in the file's unit.
    pub nodes: Vec<Point3>,
    /// The file's own number of each node.
    pub node_labels: Vec<u64>,
    /// Nodes of all tetrahedra, one tetrahedron after the other, mid-edge nodes in the order of this module.
    pub corners: Vec<u32>,
    /// Nodes an element: 4 or 10 of a tetrahedron, 8 or 20 of a hexahedron; 0 before the first.
    pub each: usize,
    /// The file's own number of each tetrahedron.
    pub labels: Vec<u64>,
    /// The tag of each tetrahedron: physical group, cell data, reference or attribute; 0 where the file has none.
    pub tags: Vec<i64>,
    /// The file's name of a tag.
    pub names: BTreeMap<i64, String>,
    /// The corners of the triangles of surfaces, four of a quadrilateral, and the tag of each.
    pub triangles: Vec<([u32; 3], i64)>,
    /// The file's name of a surface's tag.
    pub surface_names: BTreeMap<i64, String>,
    /// Number of points, lines and faces, which are no part of the solid.
    pub ignored: usize,
}

impl RawMesh {
    /// Tetrahedra that were made here, each with its region as tag.
    pub(crate) fn of_tetrahedra(nodes: Vec<Point3>, tets: &[[u32; 4]], regions: &[u16]) -> Self {
        Self {
            node_labels: (1..=nodes.len() as u64).collect(),
            nodes,
            corners: tets.concat(),
            each: 4,
            labels: (1..=tets.len() as u64).collect(),
            tags: regions.iter().map(|region| i64::from(*region)).collect(),
            ..Self::default()
        }
    }

    /// Adds a node.
    pub(super) fn add_node(&mut self, label: u64, point: Point3) {
        self.nodes.push(point);
        self.node_labels.push(label);
    }

    /// Adds a tetrahedron of 4 or 10 nodes, or a hexahedron of 8, 20 or 27, of which 20 are kept: those in the middles of sides and elements
    /// are no part of the solid.
    ///
    /// # Errors
    /// [`MeshFileError`] when those before it have another number of nodes, or a node is not there.
    pub(super) fn add_tetrahedron(&mut self, label: u64, nodes: &[u32], tag: i64) -> Result<(), MeshFileError> {
        let nodes = if nodes.len() == 27 { &nodes[..20] } else { nodes };
        if self.each != 0 && self.each != nodes.len() {
            let message = format!("element {label} has {} nodes where those before it have {}", nodes.len(), self.each);
            return Err(MeshFileError::new(
                message,
                "a mesh has elements of one kind and order",
                "save it with tetrahedra of 4 or of 10 nodes, or with hexahedra of 8 or of 20, alone",
            ));
        }
        self.check_nodes(nodes, &|| format!("element {label}"))?;
        self.each = nodes.len();
        self.corners.extend(nodes);
        self.labels.push(label);
        self.tags.push(tag);
        Ok(())
    }

    /// Adds a triangle of a surface, of which the first three nodes are the corners, or a quadrilateral of 4, 8 or 9 nodes, as the four
    /// triangles between its corners: any one of them then shows that a side of a hexahedron is on the surface.
    ///
    /// # Errors
    /// [`MeshFileError`] when a node is not there.
    pub(super) fn add_surface_face(&mut self, nodes: &[u32], tag: i64) -> Result<(), MeshFileError> {
        self.check_nodes(nodes, &|| format!("face {} of a surface", self.triangles.len() + 1))?;
        match (nodes.len(), nodes) {
            (4 | 8 | 9, &[a, b, c, d, ..]) => {
                self.triangles.extend([[a, b, c], [a, b, d], [a, c, d], [b, c, d]].map(|triangle| (triangle, tag)));
            }
            (_, &[a, b, c, ..]) => self.triangles.push(([a, b, c], tag)),
            _ => {}
        }
        Ok(())
    }

    fn check_nodes(&self, nodes: &[u32], element: &dyn Fn() -> String) -> Result<(), MeshFileError> {
        let Some(node) = nodes.iter().find(|&&node| node as usize >= self.nodes.len()) else { return Ok(()) };
        let message = format!("{} names the node at place {node}", element());
        let why = format!("the file has {} nodes, counted here from 0", self.nodes.len());
        Err(MeshFileError::new(message, why, "save the mesh again; the file was cut or edited"))
    }

    /// Number of tetrahedra.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there are no tetrahedra.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// Nodes of one tetrahedron.
    pub fn element(&self, element: usize) -> &[u32] {
        &self.corners[element * self.each..(element + 1) * self.each]
    }
}

/// The error of a solid element that is neither.
pub(super) fn other_solid(name: &str) -> MeshFileError {
    let message = format!("the file has {name}");
    MeshFileError::new(
        message,
        "tetrahedra of 4 or 10 nodes are simulated, and hexahedra of 8, 20 or 27",
        "mesh the solid with one of these alone, of order 1 or 2",
    )
}

/// The places in gmsh's files of the 20 nodes of a hexahedron in the order of VTK.
const HEXAHEDRON_PLACES: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15];

/// The nodes of an element of gmsh in the order of this module, where they are 20 or 27.
pub(super) fn hexahedron_of_gmsh(nodes: &[u32]) -> Vec<u32> {
    let is_quadratic = [20, 27].contains(&nodes.len());
    if is_quadratic { HEXAHEDRON_PLACES.iter().map(|&place| nodes[place]).collect() } else { nodes.to_vec() }
}

/// Ten nodes in the order of this module: the file's places of corners and of the middles of 01, 12, 02, 03, 13, 23.
pub(super) fn reorder_nodes(nodes: &[u32], places: &[usize; 10]) -> Vec<u32> {
    if nodes.len() == 10 { places.iter().map(|&place| nodes[place]).collect() } else { nodes.to_vec() }
}
