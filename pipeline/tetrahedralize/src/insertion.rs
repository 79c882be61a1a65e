//! Surface triangles into tetrahedra, as unions of faces.
//!
//! Where a triangle is no face yet, every edge that crosses it is split where it meets the triangle's plane. A tetrahedron whose crossing edges are
//! all split falls into parts that lie on one side each, whatever the order: new edges end on the plane. So neighbours conform without a table of
//! cuts, which TetWild's later form has [hu2020], and a split that would invert something is left out alone, not with its triangle. What is
//! left out shows as an interface that departs from the surface by less than the tetrahedron, since labels come from winding numbers.

use std::collections::BTreeSet;

use si::Point3;
use si::vec3::{add, cross, dot, scale, sub};

use crate::complex::Complex;
use crate::delaunay::sorted_edge;
use crate::geometry::{distance, normal, orientation, unit};

/// The six edges of a tetrahedron.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// A triangle of the surface in its own frame.
struct Plane {
    origin: Point3,
    axes: [Point3; 2],
    normal: Point3,
    /// Its corners along the axes.
    corners: [[f64; 2]; 3],
    nodes: [u32; 3],
    /// Nodes so near to the plane lie on it.
    near: f64,
}

impl Plane {
    fn new(nodes: [u32; 3], places: [Point3; 3], near: f64) -> Self {
        let normal = unit(normal(places));
        let direction = unit(sub(places[1], places[0]));
        let axes = [direction, cross(normal, direction)];
        let origin = places[0];
        let corners = places.map(|p| axes.map(|axis| dot(sub(p, origin), axis)));
        Self { origin, axes, normal, corners, nodes, near }
    }

    fn height_of(&self, at: Point3) -> f64 {
        dot(sub(at, self.origin), self.normal)
    }

    fn flatten_point(&self, at: Point3) -> [f64; 2] {
        self.axes.map(|axis| dot(sub(at, self.origin), axis))
    }

    /// Heights of a tetrahedron's corners; 0 of those on the plane.
    fn corner_heights(&self, nodes: [u32; 4], places: [Point3; 4]) -> [f64; 4] {
        [0, 1, 2, 3].map(|k| {
            let height = self.height_of(places[k]);
            if self.nodes.contains(&nodes[k]) || height.abs() <= self.near { 0.0 } else { height }
        })
    }

    /// The part of the plane within a tetrahedron, as points of a convex polygon in no order.
    fn plane_section(&self, nodes: [u32; 4], places: [Point3; 4]) -> Vec<[f64; 2]> {
        let heights = self.corner_heights(nodes, places);
        let touching = (0..4).filter(|k| heights[*k] == 0.0).map(|k| self.flatten_point(places[k]));
        let cut = EDGES.iter().filter(|[i, j]| heights[*i] * heights[*j] < 0.0);
        touching
            .chain(
                cut.map(|[i, j]| {
                    self.flatten_point(meeting_point([places[*i], places[*j]], [heights[*i], heights[*j]]))
                }),
            )
            .collect()
    }

    /// Whether a convex polygon overlaps the triangle by more than the tolerance, by the axis that parts them best.
    fn overlaps_triangle(&self, polygon: &[[f64; 2]]) -> bool {
        let sides = [0, 1, 2].map(|k| [self.corners[k], self.corners[(k + 1) % 3]]);
        let pairs = polygon.iter().enumerate().flat_map(|(i, p)| polygon[..i].iter().map(move |q| [*p, *q]));
        let parted = |[p, q]: [[f64; 2]; 2]| {
            let side = [q[0] - p[0], q[1] - p[1]];
            let length = side[0].hypot(side[1]);
            if length <= self.near {
                return false;
            }
            let normal = [-side[1] / length, side[0] / length];
            let span = |points: &[[f64; 2]]| {
                let offsets = points.iter().map(|x| x[0] * normal[0] + x[1] * normal[1]);
                offsets.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)])
            };
            let (mine, other) = (span(&self.corners), span(polygon));
            mine[1].min(other[1]) - mine[0].max(other[0]) <= self.near
        };
        !sides.into_iter().chain(pairs).any(parted)
    }
}

/// Where an edge meets the plane.
fn meeting_point([p, q]: [Point3; 2], [above, below]: [f64; 2]) -> Point3 {
    add(p, scale(sub(q, p), above / (above - below)))
}

/// Puts a triangle between three nodes into the tetrahedra; returns how many splits were left out.
pub(crate) fn insert_triangle(complex: &mut Complex, nodes: [u32; 3], near: f64) -> usize {
    let [a, b, c] = nodes;
    let present = |t: &u32| complex.tets[*t as usize].contains(&b) && complex.tets[*t as usize].contains(&c);
    if complex.star(a).iter().any(present) {
        return 0;
    }
    let plane = Plane::new(nodes, complex.positions_of(nodes), near);
    let mut failed = 0;
    for edge in crossing_edges(complex, &plane) {
        failed += usize::from(!split_on(complex, edge, &plane));
    }
    failed
}

/// The edges that cross the triangle, or its plane within a tetrahedron that the triangle enters.
fn crossing_edges(complex: &Complex, plane: &Plane) -> BTreeSet<[u32; 2]> {
    let mut edges = BTreeSet::new();
    let mut queue: Vec<u32> = plane.nodes.iter().flat_map(|n| complex.star(*n)).copied().collect();
    let mut queued: BTreeSet<u32> = queue.iter().copied().collect();
    while let Some(tet) = queue.pop() {
        let (nodes, places) = (complex.tets[tet as usize], complex.corners_of(tet));
        let section = plane.plane_section(nodes, places);
        if section.len() < 3 || !plane.overlaps_triangle(&section) {
            continue;
        }
        let heights = plane.corner_heights(nodes, places);
        let crossed = EDGES.iter().filter(|[i, j]| heights[*i] * heights[*j] < 0.0);
        edges.extend(crossed.map(|[i, j]| sorted_edge([nodes[*i], nodes[*j]])));
        queue.extend(nodes.iter().flat_map(|n| complex.star(*n)).filter(|t| queued.insert(**t)));
    }
    edges
}

/// Splits an edge on the plane where the parts stay positive.
fn split_on(complex: &mut Complex, edge: [u32; 2], plane: &Plane) -> bool {
    let ends = complex.positions_of(edge);
    let heights = ends.map(|p| plane.height_of(p));
    let crossing_point = meeting_point(ends, heights);
    if distance(crossing_point, ends[0]) == 0.0 || distance(crossing_point, ends[1]) == 0.0 {
        return false;
    }
    let node = complex.add_point(crossing_point);
    let (ring, halves) = complex.bisect_edge(edge, node);
    // beside elements that are flat to rounding the point is not where it was meant to be: one near it will do
    let positive = candidate_shifts(ends, plane.near).any(|by| {
        complex.points[node as usize] = add(crossing_point, by);
        halves.iter().all(|(nodes, _)| orientation(complex.positions_of(*nodes)) > 0.0)
    });
    if positive {
        complex.replace_tets(&ring, &halves);
    }
    positive
}

/// No shift, then some of less than a length in all directions, the smallest first.
fn candidate_shifts([p, q]: [Point3; 2], near: f64) -> impl Iterator<Item = Point3> {
    let edge_direction = unit(sub(q, p));
    let smallest_component =
        (0..3).min_by(|i, j| edge_direction[*i].abs().total_cmp(&edge_direction[*j].abs())).unwrap_or(0);
    let transverse = unit(cross(edge_direction, [0, 1, 2].map(|k| f64::from(u8::from(k == smallest_component)))));
    let directions = [edge_direction, transverse, cross(edge_direction, transverse)];
    let small = [1e-4, 1e-2, 0.3].into_iter().flat_map(move |share| {
        (0..26).map(move |i| {
            let signs = [i / 9, i / 3 % 3, i % 3].map(|digit| [1.0, -1.0, 0.0][digit] * share * near);
            directions.iter().zip(signs).fold([0.0; 3], |sum, (axis, sign)| add(sum, scale(*axis, sign)))
        })
    });
    std::iter::once([0.0; 3]).chain(small)
}
