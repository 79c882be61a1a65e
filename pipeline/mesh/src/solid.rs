//! Solids: a mesh of linear or quadratic elements.

use crate::embed::{Spot, embed, embed_linear, embed_mark};
use crate::{QuadraticElements, QuadraticFace, QuadraticMesh, Skin, SkinFace, TetMesh, quadratic};
use si::{Metre, Point3};

/// Tetrahedra of four or of ten nodes.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// Four nodes an element.
    Linear(TetMesh),
    /// Ten or twenty nodes an element.
    Quadratic(QuadraticMesh),
}

impl Solid {
    /// Node positions, m.
    pub fn nodes(&self) -> &[Point3] {
        match self {
            Self::Linear(mesh) => &mesh.nodes,
            Self::Quadratic(mesh) => &mesh.nodes,
        }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.regions().len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The 4, 10 or 20 nodes of an element.
    pub fn element(&self, element: usize) -> &[u32] {
        match self {
            Self::Linear(mesh) => &mesh.tets[element],
            Self::Quadratic(mesh) => mesh.elements.nodes(element),
        }
    }

    /// Whether its elements are hexahedra.
    pub fn is_hexahedral(&self) -> bool {
        matches!(self, Self::Quadratic(QuadraticMesh { elements: QuadraticElements::Hexahedra(_), .. }))
    }

    /// Region of each element.
    pub fn regions(&self) -> &[u16] {
        match self {
            Self::Linear(mesh) => &mesh.regions,
            Self::Quadratic(mesh) => &mesh.regions,
        }
    }

    /// Whether only z ≥ 0 is meshed.
    pub fn half(&self) -> bool {
        match self {
            Self::Linear(mesh) => mesh.half,
            Self::Quadratic(mesh) => mesh.half,
        }
    }

    /// The skin: 3, 6 or 8 nodes a face, and what it touches.
    pub fn faces(&self) -> Vec<(&[u32], Skin)> {
        match self {
            Self::Linear(mesh) => mesh.skin.iter().map(|face| (face.nodes.as_slice(), face.on)).collect(),
            Self::Quadratic(mesh) => mesh.skin.iter().map(|face| (face.nodes(), face.on)).collect(),
        }
    }

    /// The same solid of second order; new nodes lie in the middles of straight edges.
    pub fn to_quadratic(self) -> QuadraticMesh {
        match self {
            Self::Linear(mesh) => quadratic(&mesh),
            Self::Quadratic(mesh) => mesh,
        }
    }

    /// The same solid as tetrahedra of four nodes; curved edges become straight, hexahedra are cut.
    pub fn to_linear(self) -> TetMesh {
        match self {
            Self::Linear(mesh) => mesh,
            Self::Quadratic(mesh) => mesh.into_corners(),
        }
    }

    /// The point of the outer skin nearest to `at` (m), and how far away it is (m), as [`crate::embed`] finds it.
    pub fn embed(&self, at: Point3) -> (Spot, Metre) {
        match self {
            Self::Linear(mesh) => embed_linear(mesh, at, None),
            Self::Quadratic(mesh) => embed(mesh, at),
        }
    }

    /// The mean over a disc about `centre` (m) on the outer skin, as [`crate::embed_mark`] finds it; without a diameter (m) the nearest point.
    pub fn embed_mark(&self, centre: Point3, diameter: Option<Metre>) -> (Spot, Metre) {
        match self {
            Self::Linear(mesh) => embed_linear(mesh, centre, diameter),
            Self::Quadratic(mesh) => embed_mark(mesh, centre, diameter),
        }
    }
}

impl QuadraticMesh {
    /// Straight tetrahedra between the corners; of hexahedra, their parts.
    pub fn into_corners(self) -> TetMesh {
        match &self.elements {
            QuadraticElements::Tetrahedra(tets) => corners_only(&self, tets),
            QuadraticElements::Hexahedra(_) => {
                self.cut_hexahedra().unwrap_or_else(|| unreachable!("they are hexahedra"))
            }
        }
    }
}

fn corners_only(mesh: &QuadraticMesh, tets: &[[u32; 10]]) -> TetMesh {
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    tets.iter().flat_map(|tet| &tet[..4]).for_each(|&node| number[node as usize] = 0);
    let mut nodes = Vec::new();
    for (node, number) in number.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
        *number = nodes.len() as u32;
        nodes.push(mesh.nodes[node]);
    }
    let corner_number = |node: u32| number[node as usize];
    let face =
        |face: &QuadraticFace| SkinFace { nodes: [0, 1, 2].map(|k| corner_number(face.nodes()[k])), on: face.on };
    TetMesh {
        nodes,
        tets: tets.iter().map(|tet| [0, 1, 2, 3].map(|k| corner_number(tet[k]))).collect(),
        regions: mesh.regions.clone(),
        skin: mesh.skin.iter().map(face).collect(),
        half: mesh.half,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn to_linear_is_the_inverse_of_to_quadratic() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let skin = vec![SkinFace { nodes: [1, 2, 3], on: Skin::Outer }];
        let mesh = TetMesh { nodes, tets: vec![[0, 1, 2, 3]], regions: vec![0], skin, half: false };
        let to_quadratic = Solid::Quadratic(Solid::Linear(mesh.clone()).to_quadratic());
        assert_eq!(to_quadratic.nodes().len(), 10);
        assert_eq!(to_quadratic.to_linear(), mesh);
    }
}
