//! Symmetry: whether a surface is symmetric about z = 0, and the plan cut there.

use crate::Surface;
use crate::distance::Nearest;
use si::{Metre, Point2};

/// Whether every corner's mirror image lies on the surface and the solid has no moment about z = 0.
pub(crate) fn is_symmetric(surface: &Surface, tolerance: Metre) -> bool {
    let moment = |f: usize| {
        let [a, b, c] = surface.corners(f);
        si::vec3::dot(a, si::vec3::cross(b, c)) / 6.0 * (a[2] + b[2] + c[2]) / 4.0
    };
    let sum: f64 = (0..surface.faces.len()).map(moment).sum();
    if sum.abs() > tolerance * surface.volume() {
        return false;
    }
    let nearest_face = Nearest::new((0..surface.faces.len()).map(|f| surface.corners(f)).collect());
    surface.points.iter().all(|p| nearest_face.find([p[0], p[1], -p[2]]).is_some_and(|hit| hit.distance <= tolerance))
}

/// Segments of the half where coordinate `axis` is not negative, and before them the cut itself.
///
/// Points nearer to the cut than `tolerance` (m) are put onto it.
pub(crate) fn cut_segments(segments: &[[Point2; 2]], axis: usize, tolerance: Metre) -> Vec<[Point2; 2]> {
    let snapped = segments.iter().map(|s| {
        s.map(|mut p| {
            // To zero exactly: faces on the plane of symmetry are known by z == 0.
            p[axis] = if p[axis].abs() <= tolerance { 0.0 } else { p[axis] };
            p
        })
    });
    let upper_segments: Vec<[Point2; 2]> = snapped.filter_map(|s| upper_part(s, axis)).collect();
    let along_axis = 1 - axis;
    let ends = upper_segments.iter().flatten().map(|p| p[along_axis]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
    let on_cut = |coordinate: f64| {
        let mut point = [0.0; 2];
        point[along_axis] = coordinate;
        point
    };
    std::iter::once([on_cut(low), on_cut(high)]).chain(upper_segments).collect()
}

fn upper_part([a, b]: [Point2; 2], axis: usize) -> Option<[Point2; 2]> {
    let inside = [a, b].map(|p| p[axis] >= 0.0);
    // a segment on the cut is replaced by the cut itself
    if (!inside[0] && !inside[1]) || (a[axis] <= 0.0 && b[axis] <= 0.0) {
        return None;
    }
    let t = a[axis] / (a[axis] - b[axis]);
    let mut meet = [0, 1].map(|k| a[k] + t * (b[k] - a[k]));
    meet[axis] = 0.0;
    Some([if inside[0] { a } else { meet }, if inside[1] { b } else { meet }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::block;

    #[test]
    fn a_centred_box_is_symmetric_and_a_shifted_one_is_not() {
        assert!(is_symmetric(&block([0.0, 0.0, -1.0], [1.0, 1.0, 1.0]), 1e-6));
        assert!(!is_symmetric(&block([0.0, 0.0, -0.9], [1.0, 1.0, 1.0]), 1e-6));
    }

    #[test]
    fn a_segment_across_the_cut_keeps_its_upper_part() {
        let segments = cut_segments(&[[[-1.0, 0.0], [1.0, 2.0]], [[-2.0, 0.0], [-1.0, 5.0]]], 0, 1e-9);
        assert_eq!(segments, [[[0.0, 1.0], [0.0, 2.0]], [[0.0, 1.0], [1.0, 2.0]]]);
    }
}
