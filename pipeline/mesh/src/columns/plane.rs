//! Plane: a graph of outlines becomes a triangulated plan, and regions of it that no outline cuts.

use super::arrange::Graph;
use crate::surface::connected_components;
use si::{Metre, Point2};
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, RefinementParameters, Triangulation};

/// Least angle of the refinement, degrees; Ruppert's algorithm provably terminates up to 20.7°.
const ANGLE: f64 = 20.0;

/// Largest area of a triangle in squares of the target length; an equilateral one has 0.43.
const AREA: f64 = 0.65;

/// A triangulated plan.
pub(crate) struct Plane {
    pub points: Vec<Point2>,
    /// Vertices, counterclockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the region of each triangle.
    pub regions: Vec<u32>,
    pub region_count: u32,
    /// Vertices that the refinement put onto edges of the graph.
    pub chords: Vec<u32>,
}

/// Triangulates the plan with edges of about `edge` (m) and shorter ones around `extra` points.
///
/// # Errors
/// A point of an edge of the graph that crosses another one.
pub(crate) fn triangulate_plan(graph: &Graph, extra: &[Point2], edge: Metre) -> Result<Plane, Point2> {
    let mut plane = ConstrainedDelaunayTriangulation::<spade::Point2<f64>>::new();
    let mut handles = Vec::with_capacity(graph.points.len());
    for p in &graph.points {
        handles.push(plane.insert(spade::Point2::new(p[0], p[1])).map_err(|_| *p)?);
    }
    for &[a, b] in &graph.edges {
        let (from, to) = (handles[a as usize], handles[b as usize]);
        if from != to && !plane.exists_constraint(from, to) && plane.try_add_constraint(from, to).is_empty() {
            return Err(graph.points[a as usize]);
        }
    }
    for &p in surrounding_box(&graph.points, 2.0 * edge).iter().chain(extra) {
        plane.insert(spade::Point2::new(p[0], p[1])).map_err(|_| p)?;
    }
    let area = AREA * edge * edge;
    plane.refine(
        RefinementParameters::new()
            .with_angle_limit(AngleLimit::from_deg(ANGLE))
            .with_max_allowed_area(area)
            // Outlines that meet at an acute angle have no triangulation with the least angle, and the refinement would
            // go on towards their corner.
            .with_min_required_area(0.01 * area)
            .with_max_additional_vertices(200_000),
    );
    Ok(read_plane(&plane, graph.points.len()))
}

/// Corners of a box around all points. Without it, edges of the convex hull would be almost parallel to the outline and the
/// refinement would create slivers there.
fn surrounding_box(points: &[Point2], margin: Metre) -> [Point2; 4] {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let reach = |k: usize| points.iter().fold(none, |(l, h), p| (l.min(p[k]), h.max(p[k])));
    let ((l0, h0), (l1, h1)) = (reach(0), reach(1));
    let (low, high) = ([l0 - margin, l1 - margin], [h0 + margin, h1 + margin]);
    [low, [high[0], low[1]], high, [low[0], high[1]]]
}

fn read_plane(plane: &ConstrainedDelaunayTriangulation<spade::Point2<f64>>, given: usize) -> Plane {
    let points = plane.vertices().map(|v| [v.position().x, v.position().y]).collect();
    let triangles = plane.inner_faces().map(|f| f.vertices().map(|v| v.fix().index() as u32)).collect();
    let faces: Vec<_> = plane.inner_faces().map(|f| f.fix().index()).collect();
    let last = faces.iter().copied().max().unwrap_or(0);
    let mut number = vec![u32::MAX; last + 1];
    faces.iter().enumerate().for_each(|(i, &f)| number[f] = i as u32);
    let open = plane.undirected_edges().filter(|e| !e.is_constraint_edge());
    let links = open.filter_map(|e| {
        let [a, b] = [e.as_directed(), e.as_directed().rev()].map(|d| d.face().as_inner());
        Some([number[a?.fix().index()], number[b?.fix().index()]])
    });
    let (regions, region_count) = connected_components(faces.len(), links);
    let added = plane.vertices().filter(|v| v.index() >= given);
    let chords = added.filter(|v| v.out_edges().any(|e| e.is_constraint_edge())).map(|v| v.index() as u32).collect();
    Plane { points, triangles, regions, region_count, chords }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::doubled_area;

    #[test]
    fn a_square_within_a_square_makes_two_regions_without_needles() {
        let square = |r: f64| [[-r, -r], [r, -r], [r, r], [-r, r]];
        let points: Vec<Point2> = square(1.0).into_iter().chain(square(3.0)).collect();
        let ring = |f: u32| (0..4).map(move |i| [f + i, f + (i + 1) % 4]);
        let graph = Graph { points, edges: ring(0).chain(ring(4)).collect() };
        let plane = triangulate_plan(&graph, &[], 0.7).unwrap();
        // the two squares and what surrounds them
        assert_eq!(plane.region_count, 3);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| plane.points[v as usize]);
            doubled_area(a, b, c) / 2.0
        };
        let inner: f64 = (0..plane.triangles.len())
            .filter(|&t| {
                plane.triangles[t]
                    .iter()
                    .any(|&v| plane.points[v as usize][0].abs() < 0.9 && plane.points[v as usize][1].abs() < 0.9)
            })
            .map(|t| area(&plane.triangles[t]))
            .sum();
        assert!(inner > 0.0 && inner <= 4.0 + 1e-9);
        assert!((plane.triangles.iter().map(area).sum::<f64>() - 8.8 * 8.8).abs() < 1e-9);
    }

    #[test]
    fn edges_that_cross_are_refused_with_a_place() {
        let points = vec![[0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]];
        assert!(triangulate_plan(&Graph { points, edges: vec![[0, 1], [2, 3]] }, &[], 1.0).is_err());
    }
}
