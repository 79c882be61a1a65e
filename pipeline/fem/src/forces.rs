//! Dead forces as a person gives them: on points, along edges, over faces; they keep their size and direction.
//!
//! Stands on: `mesh`, `rest`. Never knows: a solver, a pressure.

use crate::body::rest::{edge_shares, triangle_shares};
use crate::mesh::Mesh;
use si::Point3;

/// A list of nodal forces in the making.
#[derive(Debug, Clone, PartialEq)]
pub struct Forces<'a> {
    mesh: &'a Mesh,
    list: Vec<f64>,
}

impl<'a> Forces<'a> {
    /// No force on any node of `mesh`.
    pub fn none(mesh: &'a Mesh) -> Self {
        Self { mesh, list: vec![0.0; 3 * mesh.nodes.len()] }
    }

    /// Adds `force` (N) at `node`.
    ///
    /// # Panics
    /// When the node does not exist, here as in the other ways to push.
    pub fn on_node(mut self, node: u32, force: Point3) -> Self {
        self.add(node, force, 1.0);
        self
    }

    /// Adds `per_length` (N/m) along an edge at rest: 2 nodes, or 3 with the middle one last.
    pub fn on_edge(mut self, edge: &[u32], per_length: Point3) -> Self {
        for (&node, share) in edge.iter().zip(edge_shares(self.mesh, edge)) {
            self.add(node, per_length, share);
        }
        self
    }

    /// Adds `traction` (Pa, as a vector) over a face at rest: 3 nodes, or 6 with the middles of edges 01, 12, 20 last.
    pub fn on_face(mut self, face: &[u32], traction: Point3) -> Self {
        for (&node, share) in face.iter().zip(triangle_shares(self.mesh, face)) {
            self.add(node, traction, share);
        }
        self
    }

    /// 3 a node, N: what [`crate::Solver::set_forces`] takes.
    pub fn as_slice(&self) -> &[f64] {
        &self.list
    }

    fn add(&mut self, node: u32, force: Point3, share: f64) {
        (0..3).for_each(|axis| self.list[3 * node as usize + axis] += share * force[axis]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes;
    use crate::mesh::Elements;

    /// Sum of all forces and of their moments about the origin.
    fn wrench(mesh: &Mesh, list: &[f64]) -> (Point3, Point3) {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for (at, push) in mesh.nodes.iter().zip(list.chunks_exact(3)) {
            let turn = si::vec3::cross(*at, [push[0], push[1], push[2]]);
            (0..3).for_each(|axis| (force[axis], moment[axis]) = (force[axis] + push[axis], moment[axis] + turn[axis]));
        }
        (force, moment)
    }

    #[test]
    fn a_load_on_an_edge_and_a_face_has_its_own_resultant_and_moment() {
        let mesh = boxes::quadratic([0.3, 0.2, 0.1], [1, 1, 1]);
        let Elements::Quadratic(tets) = &mesh.elements else { unreachable!("quadratic was asked for") };
        let [a, b, c, _, ab, bc, ca, ..] = tets[0];
        let at = |node: u32| mesh.nodes[node as usize];
        let middle = |x: Point3, y: Point3| std::array::from_fn(|axis| 0.5 * (x[axis] + y[axis]));
        let length = si::vec3::norm(si::vec3::sub(at(b), at(a)));
        let (force, moment) = wrench(&mesh, Forces::none(&mesh).on_edge(&[a, b, ab], [0.0, 2.0, 0.0]).as_slice());
        assert!((force[1] - 2.0 * length).abs() < 1e-15);
        let arm = si::vec3::cross(middle(at(a), at(b)), [0.0, 2.0 * length, 0.0]);
        assert!((0..3).all(|axis| (moment[axis] - arm[axis]).abs() < 1e-15));
        let normal = si::vec3::cross(si::vec3::sub(at(b), at(a)), si::vec3::sub(at(c), at(a)));
        let area = 0.5 * si::vec3::norm(normal);
        let (force, moment) =
            wrench(&mesh, Forces::none(&mesh).on_face(&[a, b, c, ab, bc, ca], [5.0, 0.0, 1.0]).as_slice());
        assert!((force[0] - 5.0 * area).abs() < 1e-15 && (force[2] - area).abs() < 1e-15);
        let centre: Point3 = std::array::from_fn(|axis| (at(a)[axis] + at(b)[axis] + at(c)[axis]) / 3.0);
        let arm = si::vec3::cross(centre, [5.0 * area, 0.0, area]);
        assert!((0..3).all(|axis| (moment[axis] - arm[axis]).abs() < 1e-15));
    }
}
