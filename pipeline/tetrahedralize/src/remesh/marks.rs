//! Points of the input that the new faces must stay near: its corners, and points of long edges where two planes meet.

use si::Point3;
use si::vec3::{add, dot, scale, sub};

use super::Remesh;
use crate::geometry::{distance, nearest_on_triangle, normal, unit};

/// Faces whose normals differ by less than 0.6° lie in one plane.
const PLANE: f64 = 0.999_95;
/// Marks of an edge at most: more are needed by no body with edges of a useful length.
const MAX_MARKS: f64 = 400.0;

impl Remesh<'_> {
    /// Marks points of long edges where two planes meet: between marked corners alone, a ridge could be cut off.
    pub(super) fn mark_edges(&mut self, spacing: f64) {
        for edge in self.all_edges() {
            let parts = (self.edge_length(edge) / spacing).ceil().min(MAX_MARKS) as u32;
            let wings = self.edge_faces(edge);
            if parts < 2 || self.is_flat(&wings) {
                continue;
            }
            let [p, q] = edge.map(|n| self.points[n as usize]);
            for k in 1..parts {
                self.marks[wings[0] as usize].push(self.input.len() as u32);
                self.input.push(add(p, scale(sub(q, p), f64::from(k) / f64::from(parts))));
            }
        }
    }

    /// Whether faces at an edge lie in one plane.
    fn is_flat(&self, wings: &[u32]) -> bool {
        let &[f, g] = wings else { return false };
        let [m, n] = [f, g].map(|face| unit(normal(self.face_corners(face))));
        dot(m, n) > PLANE
    }

    /// The input's points of old faces, each with the new face that is nearest to it; none when one of them is too far from all.
    pub(super) fn assign_marks(&self, old: &[u32], new: &[[Point3; 3]], reach: f64) -> Option<Vec<Vec<u32>>> {
        let mut marks = vec![Vec::new(); new.len()];
        for mark in old.iter().flat_map(|f| &self.marks[*f as usize]) {
            let position = self.input[*mark as usize];
            let gaps =
                new.iter().map(|corners| distance(position, nearest_on_triangle(position, *corners))).enumerate();
            let (place, gap) = gaps.min_by(|a, b| a.1.total_cmp(&b.1))?;
            if gap > reach {
                return None;
            }
            marks[place].push(*mark);
        }
        Some(marks)
    }
}
