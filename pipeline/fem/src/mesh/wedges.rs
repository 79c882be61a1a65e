//! Hexahedra cut into wedges, for tests of elements.

use crate::mesh::{Chamber, Elements, Faces, Mesh};
use si::Point3;
use std::collections::BTreeMap;

/// Middles of the diagonals of quadrilaterals, by their ends.
struct Diagonals {
    nodes: Vec<Point3>,
    middles: BTreeMap<[u32; 2], u32>,
}

impl Diagonals {
    fn diagonal_middle(&mut self, from: u32, to: u32) -> u32 {
        let nodes = &mut self.nodes;
        *self.middles.entry([from.min(to), from.max(to)]).or_insert_with(|| {
            let ends = [nodes[from as usize], nodes[to as usize]];
            nodes.push(std::array::from_fn(|axis| 0.5 * (ends[0][axis] + ends[1][axis])));
            nodes.len() as u32 - 1
        })
    }

    /// The triangles 012 and 023 of an 8-node quadrilateral, as faces of 8 nodes.
    fn two_triangles(&mut self, [a, b, c, d, ab, bc, cd, da]: [u32; 8]) -> [[u32; 8]; 2] {
        let ac = self.diagonal_middle(a, c);
        [[a, b, c, c, ab, bc, c, ac], [a, c, d, d, ac, cd, d, da]]
    }
}

/// The mesh of 20-node hexahedra with each cut in two along the diagonals 02 and 46 of its lower and upper side, which are straight: wedges. The
/// walls of chambers that are such sides are cut as well.
///
/// # Panics
/// When the mesh has other elements.
pub fn split(mesh: &Mesh) -> Mesh {
    let Elements::QuadraticHexahedra(hexahedra) = &mesh.elements else { panic!("20-node hexahedra") };
    let mut diagonals = Diagonals { nodes: mesh.nodes.clone(), middles: BTreeMap::new() };
    let mut wedges = Vec::new();
    for nodes in hexahedra {
        let [lower, upper] =
            [[0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]].map(|side| side.map(|n| nodes[n]));
        let sides = [16, 17, 18, 19].map(|n| nodes[n]);
        let triangles = diagonals.two_triangles(lower).into_iter().zip(diagonals.two_triangles(upper));
        wedges.extend(triangles.zip([[0, 1, 2, 2], [0, 2, 3, 3]]).map(|((lower, upper), corners)| {
            let lateral_middles = corners.map(|n| sides[n]);
            let parts: Vec<u32> = [&lower[..4], &upper[..4], &lower[4..], &upper[4..], &lateral_middles].concat();
            std::array::from_fn(|n| parts[n])
        }));
    }
    let chamber = |chamber: &Chamber| {
        let Faces::QuadraticQuadrilaterals(faces) = &chamber.faces else { panic!("8-node faces") };
        let faces = faces.iter().flat_map(|face| cut_face(face, &diagonals)).collect();
        Chamber { faces: Faces::QuadraticQuadrilaterals(faces) }
    };
    let chambers = mesh.chambers.iter().map(chamber).collect();
    let regions = mesh.regions.iter().flat_map(|&region| [region; 2]).collect();
    Mesh { nodes: diagonals.nodes, elements: Elements::QuadraticHexahedra(wedges), regions, chambers, ..*mesh }
}

/// A face as it is, or its two triangles where one of its diagonals cuts elements.
fn cut_face(face: &[u32; 8], diagonals: &Diagonals) -> Vec<[u32; 8]> {
    let turned = |shift: usize| std::array::from_fn(|n| face[4 * (n / 4) + (n + shift) % 4]);
    for [a, b, c, d, ab, bc, cd, da] in [turned(0), turned(1)] {
        if let Some(&ac) = diagonals.middles.get(&[a.min(c), a.max(c)]) {
            return vec![[a, b, c, c, ab, bc, c, ac], [a, c, d, d, ac, cd, d, da]];
        }
    }
    vec![*face]
}
