//! Faces that two shells share, as a body's pocket and the sheet in it, or two solids of one file that touch: those of the later shell alone are
//! meshed.
//!
//! Remeshed apart, the two surfaces would lie within an envelope of each other with nodes that do not match: slits and slivers of less than its
//! width all along their rims, which no operation removes. The earlier shell keeps its faces for winding numbers, which want a closed surface.

use si::Point3;

use crate::Part;
use crate::envelope::Envelope;
use crate::orient::{MAX_SHELLS, consistent_shells};

/// A part without the faces that a later shell has as well, and these.
pub(crate) struct OwnFaces {
    pub(crate) part: Part,
    pub(crate) shared: Vec<[Point3; 3]>,
}

/// A connected part of a surface.
struct Shell {
    low: Point3,
    high: Point3,
    envelope: Envelope,
}

impl Shell {
    fn new(triangles: &[[Point3; 3]], longest: f64) -> Self {
        let bound = |start: f64, pick: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|k| triangles.iter().flatten().map(|p| p[k]).fold(start, pick))
        };
        let (low, high) = (bound(f64::INFINITY, f64::min), bound(f64::NEG_INFINITY, f64::max));
        Self { low, high, envelope: Envelope::new(triangles, longest) }
    }

    /// Whether a triangle lies on it.
    fn holds(&self, corners: [Point3; 3], tolerance: f64) -> bool {
        let in_box = |p: &Point3| (0..3).all(|k| p[k] >= self.low[k] - tolerance && p[k] <= self.high[k] + tolerance);
        corners.iter().all(in_box)
            && corners.iter().all(|p| self.envelope.tree.within(*p, tolerance, None).is_some())
            && self.envelope.holds_triangle(corners, tolerance)
    }
}

/// The faces of each part that no later shell has within `tolerance` (m).
pub(crate) fn part_shared(parts: &[Part], tolerance: f64, longest: f64) -> Vec<OwnFaces> {
    let numbers: Vec<Vec<usize>> = parts.iter().map(shell_numbers).collect();
    let shells: Vec<Vec<Shell>> =
        parts.iter().zip(&numbers).map(|(part, shells)| shells_of(part, shells, longest)).collect();
    let own_faces = |(number, part): (usize, &Part)| {
        let is_shared = |face: usize| {
            let corners = part.faces[face].map(|n| part.points[n as usize]);
            let later_shells = shells[number].iter().skip(numbers[number][face] + 1);
            later_shells.chain(shells[number + 1..].iter().flatten()).any(|later| later.holds(corners, tolerance))
        };
        let (shared, unshared): (Vec<usize>, Vec<usize>) = (0..part.faces.len()).partition(|face| is_shared(*face));
        let corners = |face: usize| part.faces[face].map(|n| part.points[n as usize]);
        OwnFaces {
            part: Part { faces: unshared.into_iter().map(|face| part.faces[face]).collect(), ..part.clone() },
            shared: shared.into_iter().map(corners).collect(),
        }
    };
    parts.iter().enumerate().map(own_faces).collect()
}

/// The shell of each face; one of all, where there are too many to compare.
fn shell_numbers(part: &Part) -> Vec<usize> {
    let (shells, _) = consistent_shells(&part.faces);
    let is_comparable = shells.iter().all(|shell| (*shell as usize) < MAX_SHELLS);
    shells.into_iter().map(|shell| if is_comparable { shell as usize } else { 0 }).collect()
}

fn shells_of(part: &Part, numbers: &[usize], longest: f64) -> Vec<Shell> {
    let mut members: Vec<Vec<[Point3; 3]>> = vec![Vec::new(); numbers.iter().max().map_or(0, |last| last + 1)];
    part.triangles().into_iter().zip(numbers).for_each(|(triangle, shell)| members[*shell].push(triangle));
    members.iter().map(|triangles| Shell::new(triangles, longest)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fill;

    /// A box from corner to corner, normals outwards.
    fn block(low: Point3, high: Point3, fill: Fill) -> Part {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Part { points: (0..8).map(corner).collect(), faces, fill }
    }

    #[test]
    fn a_side_that_two_boxes_share_is_the_later_ones_alone() {
        let body = block([0.0; 3], [0.01, 0.01, 0.01], Fill::Region(0));
        let insert = block([0.01, -0.001, 0.0], [0.02, 0.012, 0.011], Fill::Region(1));
        let parts = part_shared(&[body, insert], 1e-6, 0.01);
        assert_eq!((parts[0].part.faces.len(), parts[0].shared.len()), (10, 2));
        assert_eq!((parts[1].part.faces.len(), parts[1].shared.len()), (12, 0));
        assert!(parts[0].shared.iter().flatten().all(|p| p[0] == 0.01));
    }

    #[test]
    fn of_two_boxes_of_one_part_that_touch_one_keeps_the_side() {
        let mut body = block([0.0; 3], [0.01, 0.01, 0.01], Fill::Region(0));
        let other = block([0.01, 0.0, 0.0], [0.02, 0.01, 0.01], Fill::Region(0));
        body.points.extend(other.points);
        body.faces.extend(other.faces.iter().map(|face| face.map(|n| n + 8)));
        let parts = part_shared(&[body], 1e-6, 0.01);
        assert_eq!((parts[0].part.faces.len(), parts[0].shared.len()), (22, 2));
    }
}
