//! Quadratic elements: every edge has a node in its middle.

use crate::{QuadraticFace, Skin, TetMesh};
use si::Point3;
use std::collections::HashMap;

/// Elements of second order, of one kind.
#[derive(Debug, Clone, PartialEq)]
pub enum QuadraticElements {
    /// Four corners, then the middles of 01, 12, 02, 03, 13, 23 (VTK's order).
    Tetrahedra(Vec<[u32; 10]>),
    /// Eight corners, then the middles of 01, 12, 23, 30, 45, 56, 67, 74, 04, 15, 26, 37 (VTK's order). A wedge names its corners 2 and 6 twice,
    /// as 3 and 7, and as the middles of 23 and 67; the middle of 37 is that of 26.
    Hexahedra(Vec<[u32; 20]>),
}

impl QuadraticElements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Self::Tetrahedra(tets) => tets.len(),
            Self::Hexahedra(hexahedra) => hexahedra.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The 10 or 20 nodes of an element.
    pub fn nodes(&self, element: usize) -> &[u32] {
        match self {
            Self::Tetrahedra(tets) => &tets[element],
            Self::Hexahedra(hexahedra) => &hexahedra[element],
        }
    }

    /// The nodes of every element.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        (0..self.len()).map(|element| self.nodes(element))
    }

    /// From the nodes of each element, all 10 or all 20; none of other numbers.
    pub fn from_rows(rows: &[Vec<u32>]) -> Option<Self> {
        let tets: Option<Vec<[u32; 10]>> = rows.iter().map(|row| row.as_slice().try_into().ok()).collect();
        let hexahedra = || rows.iter().map(|row| row.as_slice().try_into().ok()).collect::<Option<Vec<[u32; 20]>>>();
        tets.map(Self::Tetrahedra).or_else(|| hexahedra().map(Self::Hexahedra))
    }

    /// The sides of an element, normals outwards, as faces of a skin.
    pub fn sides(&self, element: usize) -> Vec<QuadraticFace> {
        match self {
            Self::Tetrahedra(tets) => {
                SIDES.iter().map(|side| QuadraticFace::triangle(side.map(|n| tets[element][n]), Skin::Outer)).collect()
            }
            Self::Hexahedra(hexahedra) => {
                let sides = HEX_SIDES.iter().map(|side| side.map(|n| hexahedra[element][n]));
                sides.filter_map(|side| QuadraticFace::of_side(side, Skin::Outer)).collect()
            }
        }
    }

    /// Which they are, in the plural.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tetrahedra(_) => "tetrahedra",
            Self::Hexahedra(_) => "hexahedra",
        }
    }
}

/// Elements of second order with regions and a skin.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadraticMesh {
    /// Node positions, m.
    pub nodes: Vec<Point3>,
    /// Ten or twenty nodes an element.
    pub elements: QuadraticElements,
    /// Region of each element.
    pub regions: Vec<u16>,
    /// The closed boundary of the solid, normals outwards.
    pub skin: Vec<QuadraticFace>,
    /// Whether only z ≥ 0 is meshed.
    pub half: bool,
}

impl QuadraticMesh {
    /// The nodes of every face of the skin: 6 of tetrahedra, 8 of hexahedra as `QuadraticFace::as_side`.
    pub fn skin_rows(&self) -> Vec<Vec<u32>> {
        let row = |face: &QuadraticFace| match self.elements {
            QuadraticElements::Tetrahedra(_) => face.nodes().to_vec(),
            QuadraticElements::Hexahedra(_) => face.as_side().to_vec(),
        };
        self.skin.iter().map(row).collect()
    }

    /// What is wrong with lists that were read from a file: another number of regions than elements, nodes that do not exist or lie nowhere.
    pub fn fault(&self) -> Option<String> {
        let (nodes, elements, regions) = (self.nodes.len(), self.elements.len(), self.regions.len());
        if elements != regions {
            return Some(format!("there are {elements} elements and {regions} regions"));
        }
        let exist = |list: &[u32]| list.iter().all(|node| (*node as usize) < nodes);
        if let Some(element) = self.elements.iter().position(|element| !exist(element)) {
            return Some(format!("element {element} has the nodes {:?}, of {nodes}", self.elements.nodes(element)));
        }
        if let Some(face) = self.skin.iter().position(|face| !exist(face.nodes())) {
            return Some(format!("face {face} of the skin has the nodes {:?}, of {nodes}", self.skin[face].nodes()));
        }
        let node = self.nodes.iter().position(|at| at.iter().any(|x| !x.is_finite()))?;
        Some(format!("node {node} lies at {:?}", self.nodes[node]))
    }
}

/// The sides of a tetrahedron, normals outwards: corners, then the middles between them.
const SIDES: [[usize; 6]; 4] = [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]];

/// The sides of a hexahedron, alike.
pub(crate) const HEX_SIDES: [[usize; 8]; 6] = [
    [0, 3, 2, 1, 11, 10, 9, 8],
    [4, 5, 6, 7, 12, 13, 14, 15],
    [0, 1, 5, 4, 8, 17, 12, 16],
    [1, 2, 6, 5, 9, 18, 13, 17],
    [2, 3, 7, 6, 10, 19, 14, 18],
    [3, 0, 4, 7, 11, 16, 15, 19],
];

/// The edges whose middles are nodes 4 to 9.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Mid-edge nodes, numbered in the order of first use.
struct Middles {
    nodes: Vec<Point3>,
    known: HashMap<[u32; 2], u32>,
}

impl Middles {
    fn middle_of(&mut self, a: u32, b: u32) -> u32 {
        let next = self.nodes.len() as u32;
        // The map is asked and never walked: its order differs from run to run, that of first use does not.
        let middle = *self.known.entry([a.min(b), a.max(b)]).or_insert(next);
        if middle == next {
            let (p, q) = (self.nodes[a as usize], self.nodes[b as usize]);
            self.nodes.push([0, 1, 2].map(|k| (p[k] + q[k]) / 2.0));
        }
        middle
    }
}

/// The same mesh with quadratic elements, edges straight.
pub fn quadratic(mesh: &TetMesh) -> QuadraticMesh {
    let mut middles = Middles { nodes: mesh.nodes.clone(), known: HashMap::new() };
    let tets = mesh.tets.iter().map(|t| {
        let m = EDGES.map(|[a, b]| middles.middle_of(t[a], t[b]));
        [t[0], t[1], t[2], t[3], m[0], m[1], m[2], m[3], m[4], m[5]]
    });
    let tets = tets.collect();
    let skin = mesh.skin.iter().map(|face| {
        let [a, b, c] = face.nodes;
        let nodes = [a, b, c, middles.middle_of(a, b), middles.middle_of(b, c), middles.middle_of(c, a)];
        QuadraticFace::triangle(nodes, face.on)
    });
    let skin = skin.collect();
    let elements = QuadraticElements::Tetrahedra(tets);
    QuadraticMesh { nodes: middles.nodes, elements, regions: mesh.regions.clone(), skin, half: mesh.half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SkinFace;

    #[test]
    fn a_single_element_gets_six_middles_that_its_faces_share() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let skin = vec![SkinFace { nodes: [1, 2, 3], on: Skin::Outer }];
        let mesh = TetMesh { nodes, tets: vec![[0, 1, 2, 3]], regions: vec![0], skin, half: false };
        let fine = quadratic(&mesh);
        assert_eq!(fine.nodes.len(), 10);
        assert_eq!(fine.nodes[fine.elements.nodes(0)[8] as usize], [0.5, 0.0, 0.5]);
        assert_eq!(fine.skin[0].nodes(), [1, 2, 3, 5, 9, 8]);
    }
}
