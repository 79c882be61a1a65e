//! Hexahedra of 20 nodes with regions, wedges among them, and a skin of 8-node faces.

use crate::{Skin, SkinFace, TetMesh};
use si::Point3;

/// A face of eight nodes: four corners, then the middles of 01, 12, 23, 30. A triangle names its third corner twice, and once more as the
/// middle of 23.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HexFace {
    /// Corners, then middles.
    pub nodes: [u32; 8],
    /// What is on the other side.
    pub on: Skin,
}

impl HexFace {
    /// Whether it is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.nodes[2] == self.nodes[3]
    }
}

/// Hexahedra of second order: eight corners, then the middles of 01, 12, 23, 30, 45, 56, 67, 74, 04, 15, 26, 37 (VTK's order).
///
/// A wedge names its corners 2 and 6 twice, as 3 and 7, and as the middles of 23 and 67; the middle of 37 is that of 26.
#[derive(Debug, Clone, PartialEq)]
pub struct HexMesh {
    /// Node positions, m.
    pub nodes: Vec<Point3>,
    /// Twenty nodes an element.
    pub hexahedra: Vec<[u32; 20]>,
    /// Region of each element: [`crate::BODY`] or [`crate::SPINE`].
    pub regions: Vec<u16>,
    /// The closed boundary of the solid, normals outwards.
    pub skin: Vec<HexFace>,
    /// Whether only z ≥ 0 is meshed.
    pub half: bool,
}

/// The sides of a hexahedron, normals outwards: corners, then the middles between them.
pub(crate) const HEX_SIDES: [[usize; 8]; 6] = [
    [0, 3, 2, 1, 11, 10, 9, 8],
    [4, 5, 6, 7, 12, 13, 14, 15],
    [0, 1, 5, 4, 8, 17, 12, 16],
    [1, 2, 6, 5, 9, 18, 13, 17],
    [2, 3, 7, 6, 10, 19, 14, 18],
    [3, 0, 4, 7, 11, 16, 15, 19],
];

impl HexMesh {
    /// Straight tetrahedra between the corners of the elements, on the same nodes, of which those in the middles of edges belong to none: for
    /// volumes and distances. A quadrilateral is cut from its corner of the lowest number, so that neighbours match [dompierre1999].
    pub fn to_tetrahedra(&self) -> TetMesh {
        let (mut tets, mut regions) = (Vec::new(), Vec::new());
        for (nodes, region) in self.hexahedra.iter().zip(&self.regions) {
            let cut = tetrahedra(&corners(nodes));
            regions.extend(vec![*region; cut.len()]);
            tets.extend(cut);
        }
        let skin = self.skin.iter().flat_map(|face| {
            let corners = &face.nodes[..if face.is_triangle() { 3 } else { 4 }];
            fan(corners).into_iter().map(|nodes| SkinFace { nodes, on: face.on })
        });
        TetMesh { nodes: self.nodes.clone(), tets, regions, skin: skin.collect(), half: self.half }
    }
}

/// The sides of an element as polygons of its corners, normals outwards.
fn corners(nodes: &[u32; 20]) -> Vec<Vec<u32>> {
    let side = |side: &[usize; 8]| {
        let mut polygon: Vec<u32> = side[..4].iter().map(|&n| nodes[n]).collect();
        polygon.dedup();
        if polygon.first() == polygon.last() {
            polygon.pop();
        }
        polygon
    };
    HEX_SIDES.iter().map(side).filter(|polygon| polygon.len() > 2).collect()
}

/// Triangles of a polygon around its corner of the lowest number.
fn fan(polygon: &[u32]) -> Vec<[u32; 3]> {
    let first = (0..polygon.len()).min_by_key(|&n| polygon[n]).unwrap_or(0);
    let at = |n: usize| polygon[(first + n) % polygon.len()];
    (1..polygon.len() - 1).map(|n| [at(0), at(n), at(n + 1)]).collect()
}

/// Tetrahedra between the corner of the lowest number and the triangles of the sides that do not hold it.
fn tetrahedra(sides: &[Vec<u32>]) -> Vec<[u32; 4]> {
    let Some(&apex) = sides.iter().flatten().min() else { return Vec::new() };
    let opposite = sides.iter().filter(|side| !side.contains(&apex));
    // seen from the apex a side turns the other way
    opposite.flat_map(|side| fan(side)).map(|[a, b, c]| [a, c, b, apex]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::dihedral_range;

    /// A cube of side 2 on the nodes of a grid of half cells, its side x = 2 pushed out.
    fn cube() -> HexMesh {
        let corner = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
        let edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
        let middle = |&(a, b): &(usize, usize)| [0, 1, 2].map(|k| (corner[a][k] + corner[b][k]) / 2);
        let nodes: Vec<Point3> =
            corner.into_iter().chain(edges.iter().map(middle)).map(|at| at.map(f64::from)).collect();
        let element: [u32; 20] = std::array::from_fn(|n| n as u32);
        let skin = HEX_SIDES.map(|side| HexFace { nodes: side.map(|n| element[n]), on: Skin::Outer });
        HexMesh { nodes, hexahedra: vec![element], regions: vec![0], skin: skin.to_vec(), half: false }
    }

    #[test]
    fn a_cube_is_cut_into_tetrahedra_of_its_volume_whose_skin_is_closed() {
        let tets = cube().to_tetrahedra();
        assert!((tets.region_volume(0) - 8.0).abs() < 1e-12 && (0..tets.tets.len()).all(|tet| tets.volume(tet) > 0.0));
        assert_eq!((tets.nonconformity(), tets.skin.len()), (None, 12));
        assert!(dihedral_range(&tets).0 > 20.0);
    }

    #[test]
    fn a_wedge_is_cut_into_three_tetrahedra() {
        let mut wedge = cube();
        let nodes = &mut wedge.hexahedra[0];
        for (node, own) in [(3, 2), (10, 2), (7, 6), (14, 6), (19, 18)] {
            nodes[node] = nodes[own];
        }
        wedge.skin = Vec::new();
        let tets = wedge.to_tetrahedra();
        assert!((tets.region_volume(0) - 4.0).abs() < 1e-12 && tets.tets.len() == 3);
    }
}
