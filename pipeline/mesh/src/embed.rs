//! Embedding: a point of the skin becomes a material point, a weighted sum of nodes.

use std::collections::BTreeMap;

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
    OuterSkin::quadratic(mesh).nearest_spot(point)
}

/// The mean over a disc of `diameter` (m) that is seen round along z and lies on the outer skin about `centre` (m), and the distance of its centre
/// from the skin (m): where a camera sees a painted mark, which is its centroid.
///
/// Over the ribs of a thin wall the skin moves unevenly within a mark of some millimetres: beside the clamp of a tail with walls of 1.55 mm the
/// centroid of a mark moves a tenth less than the material point at its centre. Where the disc overhangs the skin, the nearest skin stands for it.
/// Without a diameter it is the nearest point, as [`embed`] finds it.
pub fn embed_mark(mesh: &QuadraticMesh, centre: Point3, diameter: Option<Metre>) -> (Spot, Metre) {
    OuterSkin::quadratic(mesh).mark_spot(centre, diameter)
}

/// The same on a mesh of four-node elements, whose weights are the shares of a face's corners.
pub(crate) fn embed_linear(mesh: &TetMesh, centre: Point3, diameter: Option<Metre>) -> (Spot, Metre) {
    OuterSkin::linear(mesh).mark_spot(centre, diameter)
}

/// Rings of a disc with equal areas, and points on each: their mean is that of the disc to a part in 10⁵ for a field of the sixth degree.
const RINGS: usize = 3;
const POINTS_A_RING: usize = 12;
/// Steps along z to the skin; each reduces the distance to sin² of the slope, a tenth at 20°.
const STEPS_TO_SKIN: usize = 3;

/// The outer skin, prepared to be searched.
struct OuterSkin<'a> {
    faces: SkinFaces<'a>,
    nodes: &'a [Point3],
    half: bool,
    triangles: Nearest,
}

/// The faces to which the triangles belong.
enum SkinFaces<'a> {
    /// A face, and the places of the triangle's corners on the reference face.
    Quadratic(Vec<(&'a QuadraticFace, [Point2; 3])>),
    Linear(Vec<[u32; 3]>),
}

impl<'a> OuterSkin<'a> {
    fn quadratic(mesh: &'a QuadraticMesh) -> Self {
        let outer = mesh.skin.iter().filter(|face| face.on == Skin::Outer);
        let parts = outer.flat_map(|face| plane_parts(face).into_iter().map(move |part| (face, part)));
        let (corners, faces) =
            parts.map(|(face, (part, places))| (part.map(|node| mesh.nodes[node as usize]), (face, places))).unzip();
        let faces = SkinFaces::Quadratic(faces);
        Self { faces, nodes: &mesh.nodes, half: mesh.half, triangles: Nearest::new(corners) }
    }

    fn linear(mesh: &'a TetMesh) -> Self {
        let faces: Vec<[u32; 3]> = mesh.skin.iter().filter(|f| f.on == Skin::Outer).map(|face| face.nodes).collect();
        let corners = faces.iter().map(|nodes| nodes.map(|node| mesh.nodes[node as usize])).collect();
        let faces = SkinFaces::Linear(faces);
        Self { faces, nodes: &mesh.nodes, half: mesh.half, triangles: Nearest::new(corners) }
    }

    /// The material point of the skin nearest to a point, and its distance, m.
    fn nearest_spot(&self, point: Point3) -> (Spot, Metre) {
        let Some(hit) = self.triangles.find(in_upper_half(point, self.half)) else {
            return (Spot { weights: Vec::new() }, f64::INFINITY);
        };
        let weights: Vec<(u32, f64)> = match &self.faces {
            SkinFaces::Linear(faces) => faces[hit.face].into_iter().zip(hit.shares).collect(),
            SkinFaces::Quadratic(faces) => {
                let (face, places) = &faces[hit.face];
                let local = [0, 1].map(|k| (0..3).map(|n| hit.shares[n] * places[n][k]).sum());
                let functions = match face.corners().len() {
                    3 => triangle_functions(hit.shares).to_vec(),
                    _ => shape_functions(8, local),
                };
                face.nodes().iter().copied().zip(functions).collect()
            }
        };
        (Spot { weights: weights.into_iter().filter(|w| w.1 != 0.0).collect() }, hit.distance)
    }

    /// The mean over a disc about a point, or the point where it has no diameter, and the distance of its centre, m.
    fn mark_spot(&self, centre: Point3, diameter: Option<Metre>) -> (Spot, Metre) {
        let (middle, distance) = self.nearest_spot(centre);
        let Some(diameter) = diameter.filter(|_| !middle.weights.is_empty()) else { return (middle, distance) };
        let above = middle.at(self.nodes);
        let mut weights = BTreeMap::new();
        let share = 1.0 / (RINGS * POINTS_A_RING) as f64;
        for [x, y] in disc_points(0.5 * diameter) {
            let spot = self.spot_along_z([above[0] + x, above[1] + y, above[2]]);
            spot.weights.into_iter().for_each(|(node, weight)| *weights.entry(node).or_insert(0.0) += share * weight);
        }
        (Spot { weights: weights.into_iter().collect() }, distance)
    }

    /// The material point above or below a point, by steps along z to the height of the nearest skin.
    fn spot_along_z(&self, mut point: Point3) -> Spot {
        for _ in 0..STEPS_TO_SKIN {
            point[2] = self.nearest_spot(point).0.at(self.nodes)[2];
        }
        self.nearest_spot(point).0
    }
}

/// Points of a disc about the origin, rings of equal areas in turn, each turned by half a step against the one before.
fn disc_points(radius: Metre) -> impl Iterator<Item = Point2> {
    (0..RINGS * POINTS_A_RING).map(move |i| {
        let (ring, k) = (i / POINTS_A_RING, i % POINTS_A_RING);
        let distance = radius * ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        let angle = std::f64::consts::TAU * (k as f64 + 0.5 * (ring % 2) as f64) / POINTS_A_RING as f64;
        [distance * angle.cos(), distance * angle.sin()]
    })
}

/// The plane triangles on which the nearest point of a face is searched, with the places of their corners on the reference face.
fn plane_parts(face: &QuadraticFace) -> Vec<([u32; 3], [Point2; 3])> {
    match *face.corners() {
        [a, b, c] => vec![([a, b, c], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])],
        _ => face.parts(),
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

    /// A plane skin: the mean of a plane field over a disc is its value at the centre, that of x² is larger by a quarter of the squared radius.
    #[test]
    fn the_mean_over_a_disc_is_that_of_the_field() {
        let points: Vec<Point2> = disc_points(0.02).collect();
        let mean = |field: &dyn Fn(Point2) -> f64| points.iter().map(|p| field(*p)).sum::<f64>() / points.len() as f64;
        assert!(mean(&|[x, y]| x + 2.0 * y).abs() < 1e-17);
        assert!((mean(&|[x, _]| x * x) / (0.25 * 0.02 * 0.02) - 1.0).abs() < 1e-12);
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let skin = vec![SkinFace { nodes: [0, 1, 2], on: Skin::Outer }];
        let mesh = TetMesh { nodes, tets: vec![[0, 2, 1, 3]], regions: vec![0], skin, half: false };
        let curved = quadratic(&mesh);
        for (spot, distance) in
            [embed_mark(&curved, [0.3, 0.3, 0.01], Some(0.2)), embed_linear(&mesh, [0.3, 0.3, 0.01], Some(0.2))]
        {
            let place = spot.at(&curved.nodes);
            assert!((distance - 0.01).abs() < 1e-15 && (0..2).all(|k| (place[k] - 0.3).abs() < 1e-12), "{place:?}");
            assert!((spot.weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let squares: Vec<Point3> = curved.nodes.iter().map(|[x, y, z]| [x * x, y * y, *z]).collect();
        let [x, ..] = embed_mark(&curved, [0.3, 0.3, 0.0], Some(0.2)).0.at(&squares);
        assert!((x - (0.09 + 0.25 * 0.01)).abs() < 1e-12, "{x}");
    }

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
