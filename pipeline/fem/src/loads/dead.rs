//! Dead loads: nodal forces of constant size and direction, and the point, line and surface loads they are built from.

use crate::assembly::reference::{edge_integrals, face_integrals};
use crate::loads::Load;
use crate::mesh::Mesh;
use crate::setup_error::SetupError;
use nalgebra::Matrix3;
use si::Point3;

/// W = −f · u
#[derive(Debug, Clone, Default)]
pub(crate) struct DeadForces {
    /// 3 entries per node, N; empty: none.
    pub forces: Vec<f64>,
}

impl Load for DeadForces {
    fn potential(&self, u: &[f64]) -> f64 {
        -self.forces.iter().zip(u).map(|(force, displacement)| force * displacement).sum::<f64>()
    }

    fn add_gradient(&self, _u: &[f64], strength: f64, gradient: &mut [f64]) {
        gradient.iter_mut().zip(&self.forces).for_each(|(entry, force)| *entry -= strength * force);
    }

    fn add_hessian(&self, _u: &[f64], _strength: f64, _add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {}
}

/// Adds m g of every node to `forces`, 3 entries per node.
pub(crate) fn add_gravity(nodal_mass: &[f64], gravity: Point3, forces: &mut [f64]) {
    for (force, mass) in forces.chunks_exact_mut(3).zip(nodal_mass) {
        (0..3).for_each(|axis| force[axis] += mass * gravity[axis]);
    }
}

/// Nodal forces built from point forces, line loads and tractions.
#[derive(Debug, Clone, PartialEq)]
pub struct Forces<'a> {
    mesh: &'a Mesh,
    nodal: Vec<f64>,
}

impl<'a> Forces<'a> {
    /// No force on any node of `mesh`.
    pub fn none(mesh: &'a Mesh) -> Self {
        Self { mesh, nodal: vec![0.0; 3 * mesh.nodes.len()] }
    }

    /// Adds `force` (N) at `node`.
    ///
    /// # Errors
    /// [`SetupError::NoSuchNode`] when the node does not exist.
    pub fn on_node(mut self, node: u32, force: Point3) -> Result<Self, SetupError> {
        self.mesh.check_side("force at node", &[node], &[1])?;
        self.add_force(node, force, 1.0);
        Ok(self)
    }

    /// Adds a line load `per_length` (N/m) along an edge at rest: 2 nodes, or 3 with the mid-edge node last.
    ///
    /// # Errors
    /// [`SetupError::NoSuchNode`], or [`SetupError::Side`] when the edge has another number of nodes.
    pub fn on_edge(mut self, edge: &[u32], per_length: Point3) -> Result<Self, SetupError> {
        self.mesh.check_side("edge", edge, &[2, 3])?;
        for (&node, integral) in edge.iter().zip(edge_integrals(self.mesh, edge)) {
            self.add_force(node, per_length, integral);
        }
        Ok(self)
    }

    /// Adds `traction` (Pa, as a vector) over a face at rest: 3 or 4 corners, or 6 nodes with the mid-edge nodes of 01,
    /// 12, 20 last.
    ///
    /// # Errors
    /// [`SetupError::NoSuchNode`], or [`SetupError::Side`] when the face has another number of nodes.
    pub fn on_face(mut self, face: &[u32], traction: Point3) -> Result<Self, SetupError> {
        self.mesh.check_side("face", face, &[3, 4, 6, 8])?;
        for (&node, integral) in face.iter().zip(face_integrals(self.mesh, face)) {
            self.add_force(node, traction, integral);
        }
        Ok(self)
    }

    /// 3 entries per node, N, as [`crate::Solver::set_forces`] takes them.
    pub fn as_slice(&self) -> &[f64] {
        &self.nodal
    }

    fn add_force(&mut self, node: u32, force: Point3, weight: f64) {
        (0..3).for_each(|axis| self.nodal[3 * node as usize + axis] += weight * force[axis]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Elements;
    use crate::mesh::box_mesh;

    /// Sum of all forces and of their moments about the origin.
    fn wrench(mesh: &Mesh, list: &[f64]) -> (Point3, Point3) {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for (at, push) in mesh.nodes.iter().zip(list.chunks_exact(3)) {
            let moment_of = si::vec3::cross(*at, [push[0], push[1], push[2]]);
            (0..3).for_each(|axis| {
                (force[axis], moment[axis]) = (force[axis] + push[axis], moment[axis] + moment_of[axis])
            });
        }
        (force, moment)
    }

    #[test]
    fn a_load_on_an_edge_and_a_face_has_its_own_resultant_and_moment() {
        let mesh = box_mesh::quadratic([0.3, 0.2, 0.1], [1, 1, 1]);
        let Elements::Quadratic(tets) = &mesh.elements else { unreachable!("the mesh is quadratic") };
        let [a, b, c, _, ab, bc, ca, ..] = tets[0];
        let at = |node: u32| mesh.nodes[node as usize];
        let middle = |x: Point3, y: Point3| std::array::from_fn(|axis| 0.5 * (x[axis] + y[axis]));
        let length = si::vec3::norm(si::vec3::sub(at(b), at(a)));
        let (force, moment) =
            wrench(&mesh, Forces::none(&mesh).on_edge(&[a, b, ab], [0.0, 2.0, 0.0]).unwrap().as_slice());
        assert!((force[1] - 2.0 * length).abs() < 1e-15);
        let arm = si::vec3::cross(middle(at(a), at(b)), [0.0, 2.0 * length, 0.0]);
        assert!((0..3).all(|axis| (moment[axis] - arm[axis]).abs() < 1e-15));
        let normal = si::vec3::cross(si::vec3::sub(at(b), at(a)), si::vec3::sub(at(c), at(a)));
        let area = 0.5 * si::vec3::norm(normal);
        let (force, moment) =
            wrench(&mesh, Forces::none(&mesh).on_face(&[a, b, c, ab, bc, ca], [5.0, 0.0, 1.0]).unwrap().as_slice());
        assert!((force[0] - 5.0 * area).abs() < 1e-15 && (force[2] - area).abs() < 1e-15);
        let centre: Point3 = std::array::from_fn(|axis| (at(a)[axis] + at(b)[axis] + at(c)[axis]) / 3.0);
        let arm = si::vec3::cross(centre, [5.0 * area, 0.0, area]);
        assert!((0..3).all(|axis| (moment[axis] - arm[axis]).abs() < 1e-15));
    }

    #[test]
    fn a_load_on_a_node_that_does_not_exist_or_on_a_side_of_another_number_is_refused() {
        let mesh = box_mesh::linear([0.3, 0.2, 0.1], [1, 1, 1]);
        let none = || Forces::none(&mesh);
        let error = none().on_node(8, [1.0; 3]).unwrap_err().to_string();
        assert!(
            error.contains("force at node 0 refers to node 8") && error.contains("8 nodes, counted from 0"),
            "{error}"
        );
        assert!(none().on_node(7, [1.0; 3]).is_ok() && none().on_node(u32::MAX, [1.0; 3]).is_err());
        assert!(none().on_edge(&[0, 8], [1.0; 3]).is_err() && none().on_face(&[0, 1, 9], [1.0; 3]).is_err());
        let error = none().on_face(&[0, 1], [1.0; 3]).unwrap_err().to_string();
        assert!(error.contains("the face of a load has 2 nodes") && error.contains("3, 4, 6 or 8"), "{error}");
        assert!(none().on_edge(&[], [1.0; 3]).is_err());
    }
}
