//! Boundary: the skin of the elements, and the chambers that it encloses.
//!
//! Every side with a solid on one side only is a face of the skin. Its faces, joined across edges, fall into shells; a shell
//! that the solid surrounds is a chamber. Chambers are numbered along x, then y, then z of their centroids.

use super::defect::MeshDefect;
use super::raw_mesh::RawMesh;
use crate::Skin;
use crate::cavities::moment_and_volume;
use crate::quadratic::EDGES;
use crate::surface::connected_components;
use crate::tetrahedra::FACES;
use si::vec3::{add, scale};
use si::{Metre, Point3};

/// A face of the skin: 3 or 6 nodes, normal out of the solid.
pub(super) type Face = (Vec<u32>, Skin);

/// The side of an element: its corners in rising order, the element, and which of its four sides.
type Side = ([u32; 3], u32, u8);

/// Centroids whose difference along an axis is below this fraction of the size count as equal along it.
const CENTROID_TOLERANCE: f64 = 1e-4;

/// The skin of a draft in metres, whose nodes on the plane of a half model have z = 0.
///
/// # Errors
/// [`MeshDefect::NonManifoldFace`] or [`MeshDefect::NonManifoldEdge`].
pub(super) fn find_skin(raw: &RawMesh, half: bool, size: Metre) -> Result<Vec<Face>, MeshDefect> {
    let free = free_sides(raw)?;
    let mut faces: Vec<Face> = free.iter().map(|side| (side_nodes(raw, side), Skin::Outer)).collect();
    let on_plane = |face: &Face| half && face.0.iter().all(|&node| raw.nodes[node as usize][2] == 0.0);
    faces.iter_mut().filter(|face| on_plane(face)).for_each(|face| face.1 = Skin::Symmetry);
    let shells = face_shells(raw, &faces, half)?;
    let chambers = chamber_shells(raw, &faces, &shells, size);
    for (face, shell) in faces.iter_mut().zip(shells).filter(|(face, _)| face.1 == Skin::Outer) {
        if let Some(number) = chambers.iter().position(|chamber| *chamber == shell) {
            face.1 = Skin::Chamber(number as u16);
        }
    }
    Ok(faces)
}

/// Sides that belong to one element alone, in the elements' order.
fn free_sides(raw: &RawMesh) -> Result<Vec<Side>, MeshDefect> {
    let mut sides: Vec<Side> = Vec::new();
    for element in 0..raw.len() {
        for side in 0..4 {
            let mut corners = side_corners(raw, element, side);
            corners.sort_unstable();
            sides.push((corners, element as u32, side as u8));
        }
    }
    sides.sort_unstable();
    let mut free = Vec::new();
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [one] => free.push(*one),
            // Both elements of an inner face see it in opposite senses; in the same sense they lie on one side of it
            // and overlap.
            [one, other] if is_even(raw, one) != is_even(raw, other) => {}
            _ => return Err(nonmanifold_face(raw, group)),
        }
    }
    free.sort_unstable_by_key(|side| (side.1, side.2));
    Ok(free)
}

fn nonmanifold_face(raw: &RawMesh, group: &[Side]) -> MeshDefect {
    let label = |side: &Side| raw.labels[side.1 as usize];
    let face = group[0].0.map(|node| raw.node_labels[node as usize]);
    MeshDefect::NonManifoldFace { face, count: group.len(), first: label(&group[0]), second: label(&group[1]) }
}

fn side_corners(raw: &RawMesh, element: usize, side: usize) -> [u32; 3] {
    let nodes = raw.element(element);
    FACES[side].map(|place| nodes[place])
}

/// Whether the corners of a side, in its own order, are an even permutation of the rising order.
fn is_even(raw: &RawMesh, side: &Side) -> bool {
    let [a, b, c] = side_corners(raw, side.1 as usize, side.2.into());
    (a < b) ^ (b < c) ^ (a < c)
}

/// Corners of a side, and the middles of its edges when there are some.
fn side_nodes(raw: &RawMesh, side: &Side) -> Vec<u32> {
    let nodes = raw.element(side.1 as usize);
    let [a, b, c] = FACES[usize::from(side.2)];
    let middle =
        |p: usize, q: usize| EDGES.iter().position(|edge| *edge == [p.min(q), p.max(q)]).map(|place| nodes[4 + place]);
    let corners = [nodes[a], nodes[b], nodes[c]];
    let middles = if raw.each == 10 { [middle(a, b), middle(b, c), middle(c, a)] } else { [None; 3] };
    corners.into_iter().chain(middles.into_iter().flatten()).collect()
}

/// The shell of each face; faces on the plane of a half model are shells of their own.
fn face_shells(raw: &RawMesh, faces: &[Face], half: bool) -> Result<Vec<u32>, MeshDefect> {
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for (number, (nodes, _)) in faces.iter().enumerate().filter(|(_, face)| face.1 == Skin::Outer) {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            edges.push(([nodes[a].min(nodes[b]), nodes[a].max(nodes[b])], number as u32));
        }
    }
    edges.sort_unstable();
    let mut links = Vec::new();
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        let cut = half && group[0].0.iter().all(|&node| raw.nodes[node as usize][2] == 0.0);
        match group {
            [one, other] => links.push([one.1, other.1]),
            [_] if cut => {}
            _ => {
                let edge = group[0].0.map(|node| raw.node_labels[node as usize]);
                return Err(MeshDefect::NonManifoldEdge { edge, count: group.len() });
            }
        }
    }
    Ok(connected_components(faces.len(), links.into_iter()).0)
}

/// Shells that the solid surrounds, in the order of their chamber numbers.
fn chamber_shells(raw: &RawMesh, faces: &[Face], shells: &[u32], size: Metre) -> Vec<u32> {
    let count = shells.iter().max().map_or(0, |last| *last as usize + 1);
    let mut sums = vec![([0.0; 3], 0.0); count];
    for ((nodes, _), &shell) in faces.iter().zip(shells).filter(|(face, _)| face.1 == Skin::Outer) {
        let corners: Vec<Point3> = nodes.iter().map(|&node| raw.nodes[node as usize]).collect();
        let (moment, volume) = moment_and_volume(&corners);
        let sum = &mut sums[shell as usize];
        *sum = (add(sum.0, moment), sum.1 + volume);
    }
    let rounded_centroid = |(moment, volume): ([f64; 3], f64)| {
        // Rounded: chambers that mirror each other have one x up to rounding, and their numbers would depend on its
        // last digits.
        scale(moment, 1.0 / volume).map(|x| (x / (CENTROID_TOLERANCE * size)).round() as i64)
    };
    let mut chambers: Vec<([i64; 3], u32)> = sums
        .into_iter()
        .zip(0..)
        .filter(|(sum, _)| sum.1 > 0.0)
        .map(|(sum, shell)| (rounded_centroid(sum), shell))
        .collect();
    chambers.sort_unstable();
    chambers.into_iter().map(|(_, shell)| shell).collect()
}
