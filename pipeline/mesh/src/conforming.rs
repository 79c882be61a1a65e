//! Conformity: inner faces are shared by two tetrahedra, the skin is closed, oriented outwards and bounds the solid.

use std::collections::BTreeMap;

use si::vec3::{cross, dot};

use crate::TetMesh;
use crate::tetrahedra::FACES;

/// Largest relative difference between the volume inside of the skin and that of the elements: round-off only.
const VOLUME_TOLERANCE: f64 = 1e-9;

impl TetMesh {
    /// The first violation of conformity; none for a conforming mesh.
    pub fn nonconformity(&self) -> Option<String> {
        let faces = self.faces_by_count();
        if let Some((face, count)) = faces.iter().find(|(_, count)| **count > 2) {
            return Some(format!("the face {face:?} belongs to {count} elements"));
        }
        let outer = faces.values().filter(|&&count| count == 1).count();
        if outer != self.skin.len() {
            return Some(format!("{outer} faces have one element, the skin has {}", self.skin.len()));
        }
        if self.has_open_skin() {
            return Some("the skin is open".into());
        }
        let enclosed: f64 = self.skin.iter().map(|face| self.cone_volume(face)).sum();
        let solid: f64 = (0..self.tets.len()).map(|t| self.volume(t)).sum();
        let differs = (enclosed - solid).abs() >= VOLUME_TOLERANCE * solid;
        differs.then(|| format!("the skin encloses {enclosed} m³, the elements have {solid} m³"))
    }

    /// Number of elements of each face; a face is named by its sorted nodes.
    fn faces_by_count(&self) -> BTreeMap<[u32; 3], usize> {
        let mut count = BTreeMap::new();
        for tet in &self.tets {
            for face in FACES {
                let mut key = face.map(|i| tet[i]);
                key.sort_unstable();
                *count.entry(key).or_default() += 1;
            }
        }
        count
    }

    /// Whether an edge of the skin is passed more often in one direction than in the other.
    fn has_open_skin(&self) -> bool {
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for face in &self.skin {
            let [a, b, c] = face.nodes;
            for (s, e) in [(a, b), (b, c), (c, a)] {
                *edges.entry([s.min(e), s.max(e)]).or_default() += if s < e { 1 } else { -1 };
            }
        }
        edges.values().any(|&sum| sum != 0)
    }

    /// Signed volume of the tetrahedron that a face of the skin spans with the origin, m³.
    pub(crate) fn cone_volume(&self, face: &crate::SkinFace) -> f64 {
        let [a, b, c] = face.nodes.map(|n| self.nodes[n as usize]);
        dot(a, cross(b, c)) / 6.0
    }
}

#[cfg(test)]
mod tests {
    use crate::{BODY, Skin, SkinFace, TetMesh};

    fn one_element() -> TetMesh {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let skin = crate::FACES.map(|f| SkinFace { nodes: f.map(|i| i as u32), on: Skin::Outer }).to_vec();
        TetMesh { nodes, tets: vec![[0, 1, 2, 3]], regions: vec![BODY], skin, half: false }
    }

    #[test]
    fn an_element_with_its_four_faces_is_conforming() {
        assert_eq!(one_element().nonconformity(), None);
    }

    #[test]
    fn a_missing_face_a_reversed_face_and_a_third_element_are_found() {
        let (mut missing, mut turned, mut third) = (one_element(), one_element(), one_element());
        missing.skin.pop();
        turned.skin[0].nodes.swap(0, 1);
        third.tets = vec![[0, 1, 2, 3]; 3];
        for bad in [missing, turned, third] {
            assert!(bad.nonconformity().is_some());
        }
    }
}
