//! Smoothing: each node goes where the squared distortions around it sum to the least, by Newton's method.

use si::Point3;
use si::vec3::{add, cross, dot, norm, scale, sub};

use super::Improve;
use crate::geometry::{distortion, normal, unit};
use crate::remesh::Kind;

/// Halvings of a step before it is given up.
const HALVINGS: usize = 4;

impl Improve<'_> {
    /// Smooths every node beside an element of more than a distortion once, in the order of their numbers.
    pub(super) fn smooth_all(&mut self, limit: f64) {
        for node in 0..self.complex.points.len() as u32 {
            let worst = self.worst_of(self.complex.star(node));
            if worst > limit {
                self.smooth_node(node);
            }
        }
    }

    fn smooth_node(&mut self, node: u32) {
        let skin = if self.on_skin[node as usize] { self.complex.skin_faces(node) } else { Vec::new() };
        if skin.is_empty() {
            let step = self.newton_step(node, None);
            self.descend_along(node, step, &[]);
        } else if self.node_kind(node, &skin) == Kind::Smooth {
            let upwards = unit(skin.iter().fold([0.0; 3], |sum, f| add(sum, normal(self.complex.positions_of(*f)))));
            let step = self.newton_step(node, Some(upwards));
            self.descend_along(node, step, &skin);
        }
    }

    /// Goes along a step, on the surface if there are faces of it, as far as the sum gets less and the worst no worse.
    fn descend_along(&mut self, node: u32, step: Point3, skin: &[[u32; 3]]) {
        let position = self.complex.points[node as usize];
        let old: Vec<[Point3; 3]> = skin.iter().map(|f| self.complex.positions_of(*f)).collect();
        let (sum, worst) = self.measure_star(node);
        let reach = self.slack[node as usize];
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let target = add(position, scale(step, share));
            let foot = if skin.is_empty() { Some(target) } else { self.surface_foot(target, &old, reach) };
            share *= 0.5;
            let Some(target) = foot else { continue };
            self.complex.points[node as usize] = target;
            let (new_sum, new_worst) = self.measure_star(node);
            // the envelope last: it costs a hundred times the measure
            let better = new_sum < 0.9999 * sum && new_worst <= worst.max(1.5);
            if better && skin.iter().zip(&old).all(|(f, o)| self.may_become(*o, self.complex.positions_of(*f), reach)) {
                return;
            }
            self.complex.points[node as usize] = position;
        }
    }

    /// The surface's point nearest to one, on the side that looks like the old faces.
    fn surface_foot(&self, at: Point3, old: &[[Point3; 3]], reach: f64) -> Option<Point3> {
        let upwards = unit(old.iter().fold([0.0; 3], |sum, f| add(sum, normal(*f))));
        let foot = self.envelope.nearest(at, 2.0 * reach)?;
        // faces between regions may look either way
        (dot(self.envelope.normal(foot.triangle), upwards).abs() > 0.5).then_some(foot.point)
    }

    /// Sum of squared distortions around a node, and the largest one.
    fn measure_star(&self, node: u32) -> (f64, f64) {
        let measures = self.complex.star(node).iter().map(|t| distortion(self.complex.corners_of(*t)));
        measures.fold((0.0, 0.0), |(sum, worst), m| (sum + m * m, f64::max(worst, m)))
    }

    /// Newton's step of the sum of squares; in the plane across a direction if there is one.
    fn newton_step(&self, node: u32, across: Option<Point3>) -> Point3 {
        let (mut gradient, mut hessian) = ([0.0; 3], [[0.0; 3]; 3]);
        let mut size = 0.0f64;
        for tet in self.complex.star(node) {
            let corners = self.corners_from(*tet, node);
            size = size.max(norm(sub(corners[1], corners[0])));
            add_square(corners, (&mut gradient, &mut hessian));
        }
        if let Some(upwards) = across {
            gradient = sub(gradient, scale(upwards, dot(gradient, upwards)));
        }
        let step = scale(solve(hessian, gradient), -1.0);
        let descends = dot(step, gradient) < 0.0 && norm(step).is_finite();
        let step = if descends { step } else { scale(unit(gradient), -0.1 * size) };
        let step = match across {
            Some(upwards) => sub(step, scale(upwards, dot(step, upwards))),
            None => step,
        };
        if norm(step) > 0.5 * size { scale(unit(step), 0.5 * size) } else { step }
    }

    /// A tetrahedron's corners with a node first, in an order of positive volume.
    fn corners_from(&self, tet: u32, node: u32) -> [Point3; 4] {
        let nodes = self.complex.tets[tet as usize];
        let order = match nodes.iter().position(|n| *n == node) {
            Some(0) | None => nodes,
            Some(1) => [nodes[1], nodes[0], nodes[3], nodes[2]],
            Some(2) => [nodes[2], nodes[0], nodes[1], nodes[3]],
            _ => [nodes[3], nodes[0], nodes[2], nodes[1]],
        };
        self.complex.positions_of(order)
    }
}

/// Adds gradient and Hessian of the squared distortion by the first corner: E = c S^{3/2} / V with S = ½ Σ l².
fn add_square(corners: [Point3; 4], (gradient, hessian): (&mut Point3, &mut [[f64; 3]; 3])) {
    let measure = distortion(corners);
    if !measure.is_finite() {
        return;
    }
    let [x, b, c, d] = corners;
    let pairs = [[x, b], [x, c], [x, d], [b, c], [b, d], [c, d]];
    let s = 0.5 * pairs.iter().map(|[p, q]| dot(sub(*p, *q), sub(*p, *q))).sum::<f64>();
    let ds = sub(scale(x, 3.0), add(b, add(c, d)));
    // six volumes, and their derivative by the first corner
    let dv = scale(cross(sub(c, b), sub(d, b)), -1.0);
    let v = dot(cross(sub(b, x), sub(c, x)), sub(d, x));
    let log = sub(scale(ds, 1.5 / s), scale(dv, 1.0 / v));
    // ∇E² = 2 E² ∇log E, ∇∇E² = E² (4 ∇log ∇logᵀ + 2 ∇∇log)
    let square = measure * measure;
    for i in 0..3 {
        gradient[i] += 2.0 * square * log[i];
        for j in 0..3 {
            let same = if i == j { 4.5 / s } else { 0.0 };
            let second = same - 1.5 * ds[i] * ds[j] / (s * s) + dv[i] * dv[j] / (v * v);
            hessian[i][j] += square * (4.0 * log[i] * log[j] + 2.0 * second);
        }
    }
}

/// The solution of three linear equations; not finite where they have none.
fn solve(h: [[f64; 3]; 3], g: Point3) -> Point3 {
    let determinant = dot(h[0], cross(h[1], h[2]));
    let columns = [cross(h[1], h[2]), cross(h[2], h[0]), cross(h[0], h[1])];
    let sum = add(scale(columns[0], g[0]), add(scale(columns[1], g[1]), scale(columns[2], g[2])));
    scale(sum, 1.0 / determinant)
}
