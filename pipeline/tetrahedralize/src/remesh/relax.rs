//! Nodes of smooth parts move towards the middle of their faces, along the surface.

use si::Point3;
use si::vec3::{add, dot, norm, scale, sub};

use super::collapse::is_aligned;
use super::{FLAT, Kind, Remesh};
use crate::geometry::{flatness, normal, unit};

impl Remesh<'_> {
    pub(super) fn relax_nodes(&mut self) {
        for node in 0..self.points.len() as u32 {
            if !self.around[node as usize].is_empty() && self.node_kind(node) == Kind::Smooth {
                self.relax_node(node);
            }
        }
    }

    fn relax_node(&mut self, node: u32) {
        let star = self.around[node as usize].clone();
        let (mut area, mut middle, mut upwards) = (0.0, [0.0; 3], [0.0; 3]);
        for face in &star {
            let vector = normal(self.face_corners(*face));
            area += norm(vector);
            middle = add(middle, scale(self.face_centroid(*face), norm(vector)));
            upwards = add(upwards, vector);
        }
        let (at, upwards) = (self.points[node as usize], unit(upwards));
        let step = sub(scale(middle, 1.0 / area), at);
        let tangent = sub(step, scale(upwards, dot(step, upwards)));
        let reach = self.least_slack(&[node]);
        // onto the input, but not onto the other side of a thin wall
        let Some(foot) = self.envelope.nearest(add(at, tangent), 2.0 * reach) else { return };
        if dot(self.envelope.normal(foot.triangle), upwards) > 0.5 {
            self.move_node(node, &star, (foot.point, reach));
        }
    }

    fn move_node(&mut self, node: u32, star: &[u32], (to, reach): (Point3, f64)) {
        let position = self.points[node as usize];
        let old: Vec<[Point3; 3]> = star.iter().map(|f| self.face_corners(*f)).collect();
        self.points[node as usize] = to;
        let new: Vec<[Point3; 3]> = star.iter().map(|f| self.face_corners(*f)).collect();
        let minimum_flatness = |all: &[[Point3; 3]]| all.iter().map(|c| flatness(*c)).fold(f64::INFINITY, f64::min);
        let shaped = minimum_flatness(&new) > FLAT && minimum_flatness(&new) >= 0.8 * minimum_flatness(&old).min(0.5);
        let turned = old.iter().zip(&new).all(|(o, n)| is_aligned(*o, *n));
        let acceptable = shaped && turned && new.iter().all(|c| self.envelope.holds_triangle(*c, reach));
        match acceptable.then(|| self.assign_marks(star, &new, reach)).flatten() {
            Some(marks) => star.iter().zip(marks).for_each(|(f, marks)| self.marks[*f as usize] = marks),
            None => self.points[node as usize] = position,
        }
    }
}
