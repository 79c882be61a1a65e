//! Embedding: a point of the skin becomes a material point, a weighted sum of nodes.

use crate::distance::Nearest;
use crate::quadratic_face::{shape_functions, triangle_functions};
use crate::{QuadraticFace, QuadraticMesh, Skin, TetMesh};
use si::{Metre, Point2, Point3};

/// A material point: Σ weight · node, in the reference configuration and in every other.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Node and weight; the weights add up to 1.
    pub weights: Vec<(u32, f64)>,
}

impl Spot {
    /// Position of the point for given node positions, in their unit.
    pub fn at(&self, nodes: &[Point3]) -> Point3 {
        let sum = |k: usize| self.weights.iter().map(|&(n, w)| w * nodes[n as usize][k]).sum();
        [sum(0), sum(1), sum(2)]
    }
}

/// The point of the outer skin nearest to `point` (m), and how far away it is (m).
///
/// The nearest point is searched on the plane triangles of the corners, or between all nodes of a quadrilateral; the weights are the shape
/// functions of the face there, which follow it when it curves. Faces of cavities and of the plane of symmetry are not searched.
/// In a half model the mirror image stands for a point below the plane of symmetry: x and y of both move alike.
/// A mesh without outer skin gives an empty spot at infinite distance.
pub fn embed(mesh: &QuadraticMesh, point: Point3) -> (Spot, Metre) {
    let outer = mesh.skin.iter().filter(|face| face.on == Skin::Outer);
    let parts: Vec<_> = outer.flat_map(|face| plane_parts(face).into_iter().map(move |part| (face, part))).collect();
    let corners = parts.iter().map(|(_, (part, _))| part.map(|node| mesh.nodes[node as usize])).collect();
    match Nearest::new(corners).find(in_upper_half(point, mesh.half)) {
        None => (Spot { weights: Vec::new() }, f64::INFINITY),
        Some(hit) => {
            let (face, (_, places)) = &parts[hit.face];
            let local = [0, 1].map(|k| (0..3).map(|n| hit.shares[n] * places[n][k]).sum());
            let functions = match face.corners().len() {
                3 => triangle_functions(hit.shares).to_vec(),
                _ => shape_functions(8, local),
            };
            let weights = face.nodes().iter().copied().zip(functions);
            (Spot { weights: weights.filter(|w| w.1 != 0.0).collect() }, hit.distance)
        }
    }
}

/// The plane triangles on which the nearest point of a face is searched, with the places of their corners on the reference face.
fn plane_parts(face: &QuadraticFace) -> Vec<([u32; 3], [Point2; 3])> {
    match *face.corners() {
        [a, b, c] => vec![([a, b, c], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])],
        _ => face.parts(),
    }
}

/// The same on a mesh of four-node elements, whose weights are the shares of a face's corners.
pub(crate) fn embed_linear(mesh: &TetMesh, at: Point3) -> (Spot, Metre) {
    let outer: Vec<_> = mesh.skin.iter().filter(|face| face.on == Skin::Outer).collect();
    let corners = outer.iter().map(|face| face.nodes.map(|node| mesh.nodes[node as usize])).collect();
    match Nearest::new(corners).find(in_upper_half(at, mesh.half)) {
        None => (Spot { weights: Vec::new() }, f64::INFINITY),
        Some(hit) => {
            let weights = outer[hit.face].nodes.into_iter().zip(hit.shares);
            (Spot { weights: weights.filter(|w| w.1 != 0.0).collect() }, hit.distance)
        }
    }
}

/// A point, or its mirror image in the half that is meshed.
fn in_upper_half([x, y, z]: Point3, half: bool) -> Point3 {
    [x, y, if half { z.abs() } else { z }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SkinFace, quadratic};

    #[test]
    fn a_point_above_a_face_is_projected_and_its_weights_add_up_to_one() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let skin = vec![SkinFace { nodes: [0, 1, 2], on: Skin::Outer }];
        let mesh = quadratic(&TetMesh { nodes, tets: vec![[0, 2, 1, 3]], regions: vec![0], skin, half: false });
        let (spot, distance) = embed(&mesh, [0.2, 0.3, 0.05]);
        assert!((distance - 0.05).abs() < 1e-15);
        assert!((spot.weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-14);
        let at = spot.at(&mesh.nodes);
        assert!((at[0] - 0.2).abs() < 1e-14 && (at[1] - 0.3).abs() < 1e-14 && at[2] == 0.0);
    }
}
