//! Hexahedra of 20 nodes, wedges among them, cut into tetrahedra.

use crate::quadratic::HEX_SIDES;
use crate::{QuadraticElements, QuadraticMesh, SkinFace, TetMesh};
use si::Point3;
use std::collections::BTreeMap;

impl QuadraticMesh {
    /// Straight tetrahedra in place of curved hexahedra, for volumes and distances: each is cut into eight parts, and those into
    /// tetrahedra. Nodes of the mesh keep their numbers, middles of sides and elements follow. None of a mesh of tetrahedra.
    pub(crate) fn cut_hexahedra(&self) -> Option<TetMesh> {
        let QuadraticElements::Hexahedra(hexahedra) = &self.elements else { return None };
        let mut parts = Parts { nodes: self.nodes.clone(), middles: BTreeMap::new() };
        let (mut tets, mut regions) = (Vec::new(), Vec::new());
        for (nodes, region) in hexahedra.iter().zip(&self.regions) {
            let cut: Vec<[u32; 4]> = parts.parts_of(nodes).iter().flat_map(|prism| prism_tetrahedra(prism)).collect();
            regions.extend(vec![*region; cut.len()]);
            tets.extend(cut);
        }
        let mut skin = Vec::new();
        for face in &self.skin {
            let polygons = parts.of_face(&face.as_side());
            skin.extend(
                polygons.iter().flat_map(|polygon| fan_triangles(polygon)).map(|nodes| SkinFace { nodes, on: face.on }),
            );
        }
        Some(TetMesh { nodes: parts.nodes, tets, regions, skin, half: self.half })
    }
}

/// The parts of elements that are cut in the middles of their edges.
struct Parts {
    nodes: Vec<Point3>,
    /// Middles of sides, by their least and greatest corner and the two between.
    middles: BTreeMap<[u32; 4], u32>,
}

impl Parts {
    /// The middle of an 8-node side: −¼ of each corner, ½ of each middle.
    fn side_middle(&mut self, side: &[u32; 8]) -> u32 {
        let mut key = [side[0], side[1], side[2], side[3]];
        key.sort_unstable();
        let nodes = &mut self.nodes;
        *self.middles.entry(key).or_insert_with(|| {
            let weighted = |n: usize, k: usize| if n < 4 { -0.25 } else { 0.5 } * nodes[side[n] as usize][k];
            nodes.push([0, 1, 2].map(|k| (0..8).map(|n| weighted(n, k)).sum()));
            nodes.len() as u32 - 1
        })
    }

    /// The quarters of a face.
    fn of_face(&mut self, face: &[u32; 8]) -> Vec<Vec<u32>> {
        let middle = if face[2] == face[3] { face[2] } else { self.side_middle(face) };
        side_quarters(face, middle)
    }

    /// The eight parts of an element: lower corners, counterclockwise, then the upper ones.
    fn parts_of(&mut self, nodes: &[u32; 20]) -> Vec<Vec<u32>> {
        let sides = HEX_SIDES.map(|side| side.map(|n| nodes[n]));
        let layer = |corners: usize, middles: usize| -> [u32; 8] {
            std::array::from_fn(|n| if n < 4 { nodes[corners + n] } else { nodes[middles + n - 4] })
        };
        let [low, high] = [layer(0, 8), layer(4, 12)];
        let wedge = low[2] == low[3];
        let mut middle_layer = [0; 8];
        middle_layer[..4].copy_from_slice(&nodes[16..]);
        for (n, side) in [2, 3, 4, 5].into_iter().enumerate() {
            middle_layer[4 + n] = if wedge && n == 2 { middle_layer[2] } else { self.side_middle(&sides[side]) };
        }
        let layers = [low, middle_layer, high];
        let centres = if wedge {
            [0; 3]
        } else {
            [self.side_middle(&sides[0]), self.element_centre(nodes), self.side_middle(&sides[1])]
        };
        let cut = |n: usize| side_quarters(&layers[n], centres[n]);
        let [low, middle_layer, high] = [cut(0), cut(1), cut(2)];
        let stacked = |lower: Vec<Vec<u32>>, upper: Vec<Vec<u32>>| {
            lower.into_iter().zip(upper).map(|(lower, upper)| [lower, upper].concat())
        };
        stacked(low, middle_layer.clone()).chain(stacked(middle_layer, high)).collect()
    }

    /// The middle of an element: −¼ of each corner, ¼ of each middle.
    fn element_centre(&mut self, nodes: &[u32; 20]) -> u32 {
        let weighted = |n: usize, k: usize| if n < 8 { -0.25 } else { 0.25 } * self.nodes[nodes[n] as usize][k];
        let centre = [0, 1, 2].map(|k| (0..20).map(|n| weighted(n, k)).sum());
        self.nodes.push(centre);
        self.nodes.len() as u32 - 1
    }
}

/// The quarters of a quadrilateral with a centre, or of a triangle, in the sense of its corners.
fn side_quarters(&[a, b, c, d, ab, bc, cd, da]: &[u32; 8], centre: u32) -> Vec<Vec<u32>> {
    if c == d {
        return [[a, ab, da], [b, bc, ab], [c, da, bc], [ab, bc, da]].map(|part| part.to_vec()).to_vec();
    }
    [[a, ab, centre, da], [b, bc, centre, ab], [c, cd, centre, bc], [d, da, centre, cd]]
        .map(|part| part.to_vec())
        .to_vec()
}

/// Triangles of a polygon around its corner of the lowest number.
fn fan_triangles(polygon: &[u32]) -> Vec<[u32; 3]> {
    let first = (0..polygon.len()).min_by_key(|&n| polygon[n]).unwrap_or(0);
    let corner = |n: usize| polygon[(first + n) % polygon.len()];
    (1..polygon.len() - 1).map(|n| [corner(0), corner(n), corner(n + 1)]).collect()
}

/// Tetrahedra of a prism over a triangle or a quadrilateral, between its corner of the lowest number and the triangles of the sides that do
/// not hold it; sides are cut from their corner of the lowest number, so that neighbours match [dompierre1999].
fn prism_tetrahedra(prism: &[u32]) -> Vec<[u32; 4]> {
    let n = prism.len() / 2;
    let lower: Vec<u32> = prism[..n].iter().rev().copied().collect();
    let lateral_sides = (0..n).map(|k| vec![prism[k], prism[(k + 1) % n], prism[n + (k + 1) % n], prism[n + k]]);
    let sides: Vec<Vec<u32>> = [lower, prism[n..].to_vec()].into_iter().chain(lateral_sides).collect();
    let Some(&apex) = prism.iter().min() else { return Vec::new() };
    let opposite = sides.iter().filter(|side| !side.contains(&apex));
    // seen from the apex a side turns the other way
    opposite.flat_map(|side| fan_triangles(side)).map(|[a, b, c]| [a, c, b, apex]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::dihedral_range;
    use crate::{QuadraticFace, Skin};

    /// A cube of side 2 on the nodes of a grid of half cells, its side x = 2 pushed out.
    fn cube() -> QuadraticMesh {
        let corner = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
        let edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
        let middle = |&(a, b): &(usize, usize)| [0, 1, 2].map(|k| (corner[a][k] + corner[b][k]) / 2);
        let nodes: Vec<Point3> =
            corner.into_iter().chain(edges.iter().map(middle)).map(|at| at.map(f64::from)).collect();
        let element: [u32; 20] = std::array::from_fn(|n| n as u32);
        let skin = HEX_SIDES.map(|side| QuadraticFace::quadrilateral(side.map(|n| element[n]), Skin::Outer));
        QuadraticMesh {
            nodes,
            elements: QuadraticElements::Hexahedra(vec![element]),
            regions: vec![0],
            skin: skin.to_vec(),
            half: false,
        }
    }

    #[test]
    fn a_cube_is_cut_into_tetrahedra_of_its_volume_whose_skin_is_closed() {
        let tets = cube().cut_hexahedra().unwrap();
        assert!((tets.region_volume(0) - 8.0).abs() < 1e-12 && (0..tets.tets.len()).all(|tet| tets.volume(tet) > 0.0));
        assert_eq!((tets.nonconformity(), tets.skin.len()), (None, 48));
        assert!(dihedral_range(&tets).0 > 20.0 && tets.tets.len() >= 40);
    }

    #[test]
    fn a_wedge_is_cut_into_tetrahedra_of_its_volume() {
        let mut wedge = cube();
        let QuadraticElements::Hexahedra(elements) = &mut wedge.elements else { panic!("hexahedra") };
        let nodes = &mut elements[0];
        for (node, own) in [(3, 2), (10, 2), (7, 6), (14, 6), (19, 18)] {
            nodes[node] = nodes[own];
        }
        // the middles of its slanted side
        (wedge.nodes[11], wedge.nodes[15]) = ([1.0, 1.0, 0.0], [1.0, 1.0, 2.0]);
        wedge.skin = Vec::new();
        let tets = wedge.cut_hexahedra().unwrap();
        assert!((tets.region_volume(0) - 4.0).abs() < 1e-12 && tets.tets.len() == 24);
    }
}
