//! Flips of edges to the Delaunay diagonal.

use si::Point3;
use si::vec3::{dot, norm, sub};

use super::collapse::is_aligned;
use super::{FLAT, Remesh};
use crate::geometry::{flatness, least_height, normal};

impl Remesh<'_> {
    /// Flips edges whose opposite angles sum to more than 180°, which makes the least angle larger.
    pub(super) fn flip_edges(&mut self) {
        for _ in 0..5 {
            let edges = self.all_edges();
            if edges.into_iter().filter(|e| self.flip_edge(*e)).count() == 0 {
                break;
            }
        }
    }

    fn flip_edge(&mut self, edge: [u32; 2]) -> bool {
        let wings = self.edge_faces(edge);
        let &[f, g] = wings.as_slice() else { return false };
        let (f, g) = if self.runs_forwards(f, edge) { (f, g) } else { (g, f) };
        let [a, b] = edge;
        let tip = |face: u32| self.faces[face as usize].into_iter().find(|n| !edge.contains(n));
        let (Some(p), Some(q)) = (tip(f), tip(g)) else { return false };
        let angles = [p, q].map(|n| self.angle_at(n, edge)).iter().sum::<f64>();
        if p == q || angles < std::f64::consts::PI * 1.0001 || !self.edge_faces([p, q]).is_empty() {
            return false;
        }
        let reach = self.least_slack(&[a, b, p, q]);
        // a line that runs beside another within the envelope is that line
        let sliver = [f, g].iter().any(|face| least_height(self.face_corners(*face)) < reach);
        if self.is_feature(edge) && !(sliver && self.runs_forwards(f, edge) != self.runs_forwards(g, edge)) {
            return false;
        }
        let new = [[p, a, q], [q, b, p]];
        let places = new.map(|n| self.positions_of(n));
        let old = [self.face_corners(f), self.face_corners(g)];
        let larger = if norm(normal(old[0])) > norm(normal(old[1])) { old[0] } else { old[1] };
        let sound = places.iter().all(|c| flatness(*c) > FLAT && is_aligned(larger, *c));
        sound
            && places.iter().all(|c| self.envelope.holds_triangle(*c, reach))
            && self.replace_faces(&[f, g], &new, reach)
    }

    /// The angle under which a node sees an edge.
    fn angle_at(&self, node: u32, [a, b]: [u32; 2]) -> f64 {
        let [apex, p, q]: [Point3; 3] = self.positions_of([node, a, b]);
        let (u, v) = (sub(p, apex), sub(q, apex));
        norm(si::vec3::cross(u, v)).atan2(dot(u, v))
    }
}
