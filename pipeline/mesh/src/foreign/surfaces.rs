//! Named surfaces: faces that a file names or numbers, by which a clamp or a load can select nodes.

use std::collections::{BTreeMap, BTreeSet};

use super::hexahedral_chambers;
use super::raw_mesh::{MeshFileError, RawMesh};
use crate::quadratic::EDGES;

/// A surface as the file has it: a physical surface of gmsh, the triangles of one reference of MEDIT.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedSurface {
    /// The file's tag.
    pub tag: i64,
    /// The file's name for it.
    pub name: Option<String>,
    /// The corners of its triangles in rising order; of a quadrilateral, all four triangles between its corners. A corner is counted among the
    /// corners of elements alone, so that the number holds for elements of either order.
    triangles: BTreeSet<[u32; 3]>,
}

/// Corners of the faces of a tetrahedron.
const FACES: [&[usize]; 4] = [&[0, 1, 2], &[0, 1, 3], &[0, 2, 3], &[1, 2, 3]];

/// Of an element: how many corners it has, the corners of its faces, and those of the edges whose middles follow its corners.
fn topology(nodes: usize) -> (usize, Vec<&'static [usize]>, &'static [[usize; 2]]) {
    match nodes {
        8 | 20 => {
            (8, hexahedral_chambers::SIDES.iter().map(|side| side.as_slice()).collect(), &hexahedral_chambers::EDGES)
        }
        _ => (4, FACES.to_vec(), &EDGES),
    }
}

impl NamedSurface {
    /// The nodes of a mesh that lie on it, mid-edge nodes among them, in rising order; `elements` have 4, 10, 8 or 20 nodes.
    pub fn nodes<'a>(&self, elements: impl Iterator<Item = &'a [u32]> + Clone) -> Vec<u32> {
        let corners: Vec<u32> = corner_nodes(elements.clone()).into_iter().collect();
        let count = |node: u32| corners.binary_search(&node).map_or(u32::MAX, |number| number as u32);
        let mut members = BTreeSet::new();
        for nodes in elements {
            let (corner_count, faces, edges) = topology(nodes.len());
            let triangle = |face: &[usize]| [0, 1, 2].map(|corner| count(nodes[face[corner]]));
            for face in faces.into_iter().filter(|face| self.triangles.contains(&in_rising_order(triangle(face)))) {
                members.extend(face.iter().map(|corner| nodes[*corner]));
                let edges_with_middles = edges.iter().zip(&nodes[corner_count..]);
                let within = edges_with_middles.filter(|(edge, _)| edge.iter().all(|end| face.contains(end)));
                members.extend(within.map(|(_, middle)| *middle));
            }
        }
        members.into_iter().collect()
    }

    /// Its triangles by node numbers of the mesh, each in rising order; `elements` have 4 or 10 nodes.
    pub fn triangles<'a>(&self, elements: impl Iterator<Item = &'a [u32]>) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = corner_nodes(elements).into_iter().collect();
        let by_number =
            |face: &[u32; 3]| face.map(|counted| corners.get(counted as usize).copied().unwrap_or(u32::MAX));
        self.triangles.iter().map(by_number).collect()
    }

    /// It as the file calls it.
    fn name_in_file(&self) -> String {
        match &self.name {
            Some(name) => format!("`{name}` ({})", self.tag),
            None => self.tag.to_string(),
        }
    }
}

/// The surface with a name or tag.
///
/// # Errors
/// [`MeshFileError`] with the names that there are.
pub fn surface<'a>(surfaces: &'a [NamedSurface], word: &str) -> Result<&'a NamedSurface, MeshFileError> {
    let called = |s: &&NamedSurface| s.name.as_deref() == Some(word) || s.tag.to_string() == word;
    surfaces.iter().find(called).ok_or_else(|| {
        let names: Vec<String> = surfaces.iter().map(NamedSurface::name_in_file).collect();
        let why = match names.is_empty() {
            true => "it names no surface; files of gmsh (.msh) and MEDIT (.mesh) can".to_owned(),
            false => format!("its surfaces are {}", names.join(", ")),
        };
        let action = "name one of them, or make the clamped faces a physical surface in the mesher and save again";
        MeshFileError::new(format!("the mesh has no surface `{word}`"), why, action)
    })
}

impl RawMesh {
    /// The surfaces of the file, in rising order of their tags; triangles with a node that no element has as a corner are none of the body's.
    pub(super) fn named_surfaces(&self) -> Vec<NamedSurface> {
        let corners: Vec<u32> = corner_nodes(self.corners.chunks_exact(self.each.max(1))).into_iter().collect();
        let mut triangles_by_tag: BTreeMap<i64, BTreeSet<[u32; 3]>> = BTreeMap::new();
        for (nodes, tag) in &self.triangles {
            let counted = nodes.map(|node| corners.binary_search(&node).map_or(u32::MAX, |number| number as u32));
            let triangles = triangles_by_tag.entry(*tag).or_default();
            triangles.extend((!counted.contains(&u32::MAX)).then(|| in_rising_order(counted)));
        }
        let named = |(tag, triangles)| NamedSurface { tag, name: self.surface_names.get(&tag).cloned(), triangles };
        triangles_by_tag.into_iter().map(named).collect()
    }
}

fn corner_nodes<'a>(elements: impl Iterator<Item = &'a [u32]>) -> BTreeSet<u32> {
    elements.flat_map(|nodes| &nodes[..topology(nodes.len()).0]).copied().collect()
}

fn in_rising_order(mut nodes: [u32; 3]) -> [u32; 3] {
    nodes.sort_unstable();
    nodes
}
