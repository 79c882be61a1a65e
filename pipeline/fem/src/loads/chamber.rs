//! Chamber pressure: a follower load that stays normal to the deformed wall.
//!
//! W = −V(u), so that strength p gives −p V. The volume of the cavity is V = −⅓ ∮ x · n dA over its wall, whose normals
//! n point out of the solid. On a face x · n dA = x · (x_ξ × x_η) dξ dη, a polynomial of the node positions that
//! the quadrature integrates exactly.
//!
//! In a half model the wall ends on z = 0. The missing lid lies in that plane with the origin, so x · n = 0 on it.

use crate::assembly::quadrature::{square_9, triangle_1, triangle_7};
use crate::assembly::shape_functions::{face, is_triangle, triangle_in_face};
use crate::loads::Load;
use crate::mesh::{Chamber, Faces, Mesh};
use nalgebra::{Matrix3, Vector3};
use si::{CubicMetre, Point2};

/// Pairs of nodes (a > b) of the face with the most nodes.
const MAX_PAIRS: usize = 8 * 7 / 2;

/// W = −V(u) of one chamber.
#[derive(Debug, Clone)]
pub(crate) struct ChamberPressure {
    /// Volume of the cavity at rest, m³; of a half model, of the half.
    pub at_rest: CubicMetre,
    faces: Faces,
    /// Node numbers of the wall and their rest positions relative to a point inside.
    positions: Vec<(u32, Vector3<f64>)>,
    /// Face node → its index in `positions`.
    local: Vec<u32>,
    quadrature: FaceShapes,
    /// Of the triangles among 8-node faces.
    triangles: FaceShapes,
}

/// The shape functions of a face at every point of a rule, and its weight.
type FaceShapes = Vec<(Vec<(f64, Point2)>, f64)>;

impl ChamberPressure {
    /// From a chamber whose face nodes exist in `mesh`.
    pub fn new(mesh: &Mesh, chamber: &Chamber) -> Self {
        let faces = chamber.faces.clone();
        let mut nodes: Vec<u32> = (0..faces.len()).flat_map(|face| faces.nodes(face).to_vec()).collect();
        let corners = nodes.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let rest_position = |node: &u32| Vector3::from(mesh.nodes[*node as usize]);
        // Positions about a point inside: far from the origin x · n of opposite walls would cancel.
        let mut centre = nodes.iter().map(rest_position).sum::<Vector3<f64>>() / nodes.len().max(1) as f64;
        if mesh.symmetry_plane_z {
            // On the plane of symmetry, so that x · n stays 0 on the missing lid.
            centre.z = 0.0;
        }
        let local = corners.iter().map(|node| nodes.partition_point(|other| other < node) as u32).collect();
        let positions = nodes.iter().map(|node| (*node, rest_position(node) - centre)).collect();
        let points = match faces {
            Faces::Linear(_) => triangle_1(),
            Faces::Quadratic(_) => triangle_7(),
            Faces::QuadraticQuadrilaterals(_) => square_9(),
        };
        let quadrature = points.into_iter().map(|(point, weight)| (face(faces.nodes_each(), point), weight)).collect();
        let triangles = triangle_7().into_iter().map(|(point, weight)| (triangle_in_face(point), weight)).collect();
        let mut chamber = Self { at_rest: 0.0, faces, positions, local, quadrature, triangles };
        chamber.at_rest = chamber.volume(&vec![0.0; 3 * mesh.nodes.len()]);
        chamber
    }

    /// Volume of the cavity at displacement `u`, m³; of a half model, of the half.
    pub fn volume(&self, u: &[f64]) -> CubicMetre {
        let mut volume = 0.0;
        self.for_each_point(u, |_, _, weight, [x, by_xi, by_eta]| {
            volume -= weight / 3.0 * x.dot(&by_xi.cross(&by_eta));
        });
        volume
    }

    fn face_quadrature(&self, nodes: &[u32]) -> &FaceShapes {
        if is_triangle(nodes) { &self.triangles } else { &self.quadrature }
    }

    /// Calls `visit` at every quadrature point: node numbers, shape functions, weight, and (x, ∂x/∂ξ, ∂x/∂η).
    fn for_each_point(&self, u: &[f64], mut visit: impl FnMut(&[u32], &[(f64, Point2)], f64, [Vector3<f64>; 3])) {
        let now: Vec<Vector3<f64>> = self
            .positions
            .iter()
            .map(|(node, position)| {
                position + Vector3::from_column_slice(&u[3 * *node as usize..3 * *node as usize + 3])
            })
            .collect();
        for face in 0..self.faces.len() {
            let nodes = self.faces.nodes(face);
            let local = &self.local[face * nodes.len()..(face + 1) * nodes.len()];
            for (shape, weight) in self.face_quadrature(nodes) {
                let mut frame = [Vector3::zeros(); 3];
                for ((value, derivative), &at) in shape.iter().zip(local) {
                    let x = now[at as usize];
                    frame[0] += x * *value;
                    frame[1] += x * derivative[0];
                    frame[2] += x * derivative[1];
                }
                visit(nodes, shape, *weight, frame);
            }
        }
    }
}

impl Load for ChamberPressure {
    fn potential(&self, u: &[f64]) -> f64 {
        -self.volume(u)
    }

    /// ∂V/∂x_a = −⅓ ∮ N_a (x_ξ × x_η) + N_a,ξ (x_η × x) + N_a,η (x × x_ξ)
    fn add_gradient(&self, u: &[f64], strength: f64, gradient: &mut [f64]) {
        self.for_each_point(u, |nodes, shape, weight, [x, by_xi, by_eta]| {
            let (normal, over_xi, over_eta) = (by_xi.cross(&by_eta), by_eta.cross(&x), x.cross(&by_xi));
            for (&node, (value, derivative)) in nodes.iter().zip(shape) {
                let force =
                    (normal * *value + over_xi * derivative[0] + over_eta * derivative[1]) * (strength * weight / 3.0);
                (0..3).for_each(|axis| gradient[3 * node as usize + axis] += force[axis]);
            }
        });
    }

    // The Hessian of the volume is assembled, not the derivative of face forces: summed over a closed surface it is
    // symmetric by construction (to 1e-15), so that one Cholesky factor serves Newton and the adjoint.
    /// ∂²V/∂x_a∂x_b = [w_ab]×,
    /// w_ab = −⅓ ∮ (N_a,ξ N_b − N_a N_b,ξ) x_η + (N_a N_b,η − N_a,η N_b) x_ξ + (N_a,η N_b,ξ − N_a,ξ N_b,η) x
    fn add_hessian(&self, u: &[f64], strength: f64, add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {
        let mut axes = [Vector3::zeros(); MAX_PAIRS];
        let mut visited = 0;
        self.for_each_point(u, |nodes, shape, weight, [x, by_xi, by_eta]| {
            let mut pair = 0;
            for (a, (na, da)) in shape.iter().enumerate() {
                for (nb, db) in &shape[..a] {
                    let axis = by_eta * (da[0] * nb - na * db[0])
                        + by_xi * (na * db[1] - da[1] * nb)
                        + x * (da[1] * db[0] - da[0] * db[1]);
                    axes[pair] += axis * (strength * weight / 3.0);
                    pair += 1;
                }
            }
            visited += 1;
            if visited == self.face_quadrature(nodes).len() {
                add_blocks(nodes, &axes, add);
                (axes, visited) = ([Vector3::zeros(); MAX_PAIRS], 0);
            }
        });
    }
}

/// The blocks [w_ab]× of one face, a > b.
fn add_blocks(nodes: &[u32], axes: &[Vector3<f64>; MAX_PAIRS], add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {
    let mut pair = 0;
    for (a, &node) in nodes.iter().enumerate() {
        for &other in &nodes[..a] {
            // a node that a triangle names again has no force
            if other != node {
                add(node, other, &axes[pair].cross_matrix());
            }
            pair += 1;
        }
    }
}
