//! The walls of chambers as faces with samples: points at the middles of small triangles or quadrilaterals of equal area.

use super::boxes::Box3;
use super::hull::{Hull, Hulls};
use crate::assembly::shape_functions::{TRIANGLE_IN_FACE, face as shape_functions, is_triangle, triangle_in_face};
use crate::mesh::{Faces, Mesh};
use nalgebra::Vector3;
use si::{Metre, Point2, SquareMetre};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// Nodes of a face at most.
pub(crate) const NODES: usize = 8;

/// Values of the shape functions at every sample of a face; those of a face with fewer nodes end with zeros.
type Shapes = Arc<[[f64; NODES]]>;

/// The samples of one face as it is deformed.
pub(crate) struct Samples {
    /// m.
    pub(crate) positions: Vec<Vector3<f64>>,
    /// Around them.
    pub(crate) bounds: Box3,
}

/// The walls of all chambers.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    faces: Faces,
    /// Rest positions of all nodes of the mesh.
    rest: Arc<[Vector3<f64>]>,
    /// By face.
    shapes: Vec<Shapes>,
    /// By face, of one sample.
    areas: Vec<SquareMetre>,
}

impl Surface {
    /// Of the chambers of `mesh`, with samples at most `spacing` apart along edges.
    pub(crate) fn new(mesh: &Mesh, spacing: Metre) -> Self {
        let faces = all_faces(mesh);
        let rest_positions: Arc<[Vector3<f64>]> = mesh.nodes.iter().map(|&node| Vector3::from(node)).collect();
        let (mut tables, mut shapes, mut areas) = (BTreeMap::new(), Vec::new(), Vec::new());
        for face in 0..faces.len() {
            let nodes = faces.nodes(face);
            let corners: Vec<Vector3<f64>> =
                face_corners(nodes).iter().map(|&corner| rest_positions[corner as usize]).collect();
            let pieces = face_pieces(&corners, spacing);
            let table = tables.entry((pieces, corners.len()));
            shapes.push(Arc::clone(table.or_insert_with(|| sampled_shapes(nodes, pieces))));
            areas.push(corner_area(&corners) / (pieces[0] * pieces[1]) as f64);
        }
        Self { faces, rest: rest_positions, shapes, areas }
    }

    /// Some of its faces, and the nodes that they have; both are counted anew.
    pub(crate) fn with_faces(&self, faces: &BTreeSet<u32>) -> (Self, Vec<u32>) {
        let indices = || faces.iter().map(|&face| face as usize);
        let nodes: BTreeSet<u32> = indices().flat_map(|face| self.faces.nodes(face).iter().copied()).collect();
        let nodes: Vec<u32> = nodes.into_iter().collect();
        let number = |node: u32| nodes.partition_point(|other| *other < node) as u32;
        let part = Self {
            faces: self.faces.renumbered(indices(), number),
            rest: nodes.iter().map(|&node| self.rest[node as usize]).collect(),
            shapes: indices().map(|face| Arc::clone(&self.shapes[face])).collect(),
            areas: indices().map(|face| self.areas[face]).collect(),
        };
        (part, nodes)
    }

    /// The displacement of the mesh at rest.
    pub(crate) fn undisplaced(&self) -> Vec<f64> {
        vec![0.0; 3 * self.rest.len()]
    }

    /// Node numbers of a face, 3, 6 or 8.
    pub(crate) fn nodes(&self, face: u32) -> &[u32] {
        self.faces.nodes(face as usize)
    }

    /// Shape functions at the samples of a face.
    pub(crate) fn shapes(&self, face: u32) -> &[[f64; NODES]] {
        &self.shapes[face as usize]
    }

    /// Area at rest of one sample of a face.
    pub(crate) fn sample_area(&self, face: u32) -> SquareMetre {
        self.areas[face as usize]
    }

    /// The samples of a face at displacement `u`, or their mirror images in z = 0.
    pub(crate) fn samples(&self, face: u32, u: &[f64], mirrored: bool) -> Samples {
        let nodes = self.nodes(face).iter().map(|&node| mirror_point(self.node_position(node, u), mirrored));
        let nodes: Vec<Vector3<f64>> = nodes.collect();
        let sample = |shape: &[f64; NODES]| nodes.iter().zip(shape).map(|(x, value)| x * *value).sum();
        let positions: Vec<Vector3<f64>> = self.shapes(face).iter().map(sample).collect();
        Samples { bounds: Box3::around(&positions), positions }
    }

    /// The hulls of all faces at displacement `u`, and those of their mirror images where walls may meet them.
    pub(crate) fn hulls(&self, u: &[f64], half: bool) -> Hulls {
        let of_all = |mirrored: bool| (0..self.faces.len() as u32).map(|face| self.hull(face, u, mirrored)).collect();
        [of_all(false), if half { of_all(true) } else { Vec::new() }]
    }

    /// Control points of a face at displacement `u`, or their mirror images: the face lies inside their convex hull.
    fn hull(&self, face: u32, u: &[f64], mirrored: bool) -> Hull {
        let nodes = self.nodes(face);
        let position = |node: u32| mirror_point(self.node_position(node, u), mirrored);
        control_points(match is_triangle(nodes) {
            true => TRIANGLE_IN_FACE.iter().map(|&slot| position(nodes[slot])).collect(),
            false => nodes.iter().map(|&node| position(node)).collect(),
        })
    }

    /// Adds the `forces` on the samples of a face, or on those of its mirror image, to `gradient`.
    pub(crate) fn add_forces(&self, face: u32, mirrored: bool, forces: &[Vector3<f64>], gradient: &mut [f64]) {
        let mut sums = [Vector3::zeros(); NODES];
        for (shape, force) in self.shapes(face).iter().zip(forces) {
            sums.iter_mut().zip(shape).for_each(|(sum, value)| *sum += force * *value);
        }
        for (&node, sum) in self.nodes(face).iter().zip(sums) {
            let force = mirror_point(sum, mirrored);
            (0..3).for_each(|axis| gradient[3 * node as usize + axis] += force[axis]);
        }
    }

    fn node_position(&self, node: u32, u: &[f64]) -> Vector3<f64> {
        self.rest[node as usize] + nodal_vector(node, u)
    }
}

fn nodal_vector(node: u32, field: &[f64]) -> Vector3<f64> {
    Vector3::from_column_slice(&field[3 * node as usize..3 * node as usize + 3])
}

fn mirror_point(x: Vector3<f64>, mirrored: bool) -> Vector3<f64> {
    if mirrored { Vector3::new(x.x, x.y, -x.z) } else { x }
}

/// The corners of a face: three of a triangle, four of a quadrilateral.
fn face_corners(nodes: &[u32]) -> &[u32] {
    &nodes[..if nodes.len() == 8 && !is_triangle(nodes) { 4 } else { 3 }]
}

/// Into how many parts a face is cut along its first and its second coordinate, with middles at most `spacing` (m) apart. A quadrilateral is cut
/// each way by itself: the cells beside a thin wall are up to twelve times as long as wide, and cut by their longest side both ways they had
/// six samples where one is needed. A triangle has parts of its own shape, as many along every side.
fn face_pieces(corners: &[Vector3<f64>], spacing: Metre) -> [usize; 2] {
    let side = |from: usize, to: usize| (corners[to] - corners[from]).norm();
    let pieces = |length: Metre| (length / spacing).ceil().max(1.0) as usize;
    match corners.len() {
        // a square has one sample where it would have two as triangles: it is cut finer, so that areas have as many
        4 => [side(0, 1).max(side(2, 3)), side(1, 2).max(side(3, 0))].map(|length| pieces(SQRT_2 * length)),
        _ => [pieces(side(0, 1).max(side(1, 2)).max(side(2, 0))); 2],
    }
}

/// Area of a plane triangle or quadrilateral, m².
fn corner_area(corners: &[Vector3<f64>]) -> SquareMetre {
    match *corners {
        [a, b, c, d] => 0.5 * (c - a).cross(&(d - b)).norm(),
        [a, b, c, ..] => 0.5 * (b - a).cross(&(c - a)).norm(),
        _ => 0.0,
    }
}

/// The control points of the quadratic Bézier triangle through 6 nodes, or of the biquadratic Bézier patch that is the serendipity face
/// through 8; 3 nodes are their own.
fn control_points(mut nodes: Hull) -> Hull {
    if let [a, b, c, d, ab, bc, cd, da] = nodes[..] {
        let edge = |from: Vector3<f64>, middle: Vector3<f64>, to: Vector3<f64>| middle * 2.0 - (from + to) * 0.5;
        // the face passes through −¼ Σ corners + ½ Σ middles, and is ¼ of the inner control point there
        let [corners, middles] = [a + b + c + d, ab + bc + cd + da];
        let sides = [edge(a, ab, b), edge(b, bc, c), edge(c, cd, d), edge(d, da, a)];
        let centre = middles * 0.5 - corners * 0.25;
        let inner = centre * 4.0 - corners * 0.25 - sides.iter().sum::<Vector3<f64>>() * 0.5;
        return [a, b, c, d].into_iter().chain(sides).chain([inner]).collect();
    }
    if let [a, b, c, middles @ ..] = &mut nodes[..] {
        let ends = [(*a, *b), (*b, *c), (*c, *a)];
        middles.iter_mut().zip(ends).for_each(|(middle, (from, to))| *middle = *middle * 2.0 - (from + to) * 0.5);
    }
    nodes
}

/// Shape functions at the middles of the parts into which a face is cut, `pieces` along each of its coordinates.
fn sampled_shapes(nodes: &[u32], pieces: [usize; 2]) -> Shapes {
    let middles =
        if face_corners(nodes).len() == 4 { middles_of_rectangles(pieces) } else { middles_of_triangles(pieces[0]) };
    let values = |at: Point2| {
        let mut values = [0.0; NODES];
        let shapes = if is_triangle(nodes) { triangle_in_face(at) } else { shape_functions(nodes.len(), at) };
        shapes.iter().zip(&mut values).for_each(|((value, _), entry)| *entry = *value);
        values
    };
    middles.into_iter().map(values).collect()
}

fn middles_of_rectangles(pieces: [usize; 2]) -> Vec<Point2> {
    let middle = |i: usize, axis: usize| (i as f64 + 0.5) / pieces[axis] as f64;
    (0..pieces[0]).flat_map(|i| (0..pieces[1]).map(move |k| [middle(i, 0), middle(k, 1)])).collect()
}

fn middles_of_triangles(pieces: usize) -> Vec<Point2> {
    let n = pieces as f64;
    let both =
        |i: usize, k: usize| [(3.0, 1.0, true), (3.0, 2.0, i + k + 1 < pieces)].map(|(t, s, is)| (i, k, s / t, is));
    let cells = (0..pieces).flat_map(|i| (0..pieces - i).flat_map(move |k| both(i, k)));
    let middle = |(i, k, into, _): (usize, usize, f64, bool)| [(i as f64 + into) / n, (k as f64 + into) / n];
    cells.filter(|cell| cell.3).map(middle).collect()
}

/// The faces of all chambers in one list.
fn all_faces(mesh: &Mesh) -> Faces {
    let mut joined = Faces::Quadratic(Vec::new());
    for chamber in &mesh.chambers {
        match (&mut joined, &chamber.faces) {
            (Faces::Quadratic(joined), Faces::Quadratic(faces)) => joined.extend(faces),
            (Faces::Linear(joined), Faces::Linear(faces)) => joined.extend(faces),
            (Faces::QuadraticQuadrilaterals(joined), Faces::QuadraticQuadrilaterals(faces)) => joined.extend(faces),
            (joined, faces) => *joined = faces.clone(),
        }
    }
    joined
}
