//! Vertices that the refinement placed on chords of an outline are moved onto the outline itself.
//!
//! At the rim of a round body, a vertex slightly inside the outline would have a high column beside neighbours without
//! height: slivers, and lost volume.

use super::arrange::Graph;
use super::plane::Plane;
use crate::distance::Nearest;
use crate::frame::doubled_area;
use si::{Metre, Point2};

/// Fraction of its area that a triangle must keep.
const LOSS: f64 = 0.5;

/// Moves `plane.chords` onto the outlines, at most by `reach` (m), except where a triangle would degenerate.
pub(crate) fn snap_to_outlines(plane: &mut Plane, outlines: &Graph, reach: Metre) {
    let flat = |v: u32| [outlines.points[v as usize][0], outlines.points[v as usize][1], 0.0];
    let segments: Vec<_> = outlines.edges.iter().map(|&[a, b]| [flat(a), flat(b), flat(b)]).collect();
    let nearest_segment = Nearest::new(segments.clone());
    let mut triangles_at = vec![Vec::new(); plane.points.len()];
    for (t, corners) in plane.triangles.iter().enumerate() {
        corners.iter().for_each(|&v| triangles_at[v as usize].push(t));
    }
    for v in plane.chords.clone() {
        let point = plane.points[v as usize];
        let hit =
            nearest_segment.find([point[0], point[1], 0.0]).filter(|hit| hit.distance > 1e-9 && hit.distance <= reach);
        let Some(hit) = hit else { continue };
        let target = [0, 1].map(|k| (0..3).map(|i| hit.shares[i] * segments[hit.face][i][k]).sum());
        // A vertex that would flatten a triangle stays on the chord: the volume that it loses there is less harmful
        // than a sliver.
        if triangles_at[v as usize].iter().all(|&t| keeps_area(plane, t, v, target)) {
            plane.points[v as usize] = target;
        }
    }
}

fn keeps_area(plane: &Plane, triangle: usize, vertex: u32, to: Point2) -> bool {
    let corners = plane.triangles[triangle];
    let old = corners.map(|v| plane.points[v as usize]);
    let new = corners.map(|v| if v == vertex { to } else { plane.points[v as usize] });
    doubled_area(new[0], new[1], new[2]) > LOSS * doubled_area(old[0], old[1], old[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_on_a_chord_moves_onto_the_arc_and_one_that_is_too_far_stays() {
        let outlines = Graph { points: vec![[0.0, 0.0], [1.0, 0.1], [2.0, 0.0]], edges: vec![[0, 1], [1, 2]] };
        let points = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, -1.0]];
        let triangles = vec![[0, 1, 3], [1, 2, 3], [0, 4, 1], [1, 4, 2]];
        let mut plane = Plane { points, triangles, regions: vec![0; 4], region_count: 1, chords: vec![1, 3] };
        snap_to_outlines(&mut plane, &outlines, 0.2);
        assert!((plane.points[1][1] - 0.1).abs() < 0.01 && plane.points[3] == [1.0, 1.0]);
    }
}
