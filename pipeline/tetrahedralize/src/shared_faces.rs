//! Faces that two parts share, as a body's pocket and the sheet in it: those of the later part alone are meshed.
//!
//! Remeshed apart, the two surfaces would lie within an envelope of each other with nodes that do not match: slits and slivers of less than its
//! width all along their rims, which no operation removes. The earlier part keeps its faces for winding numbers, which want a closed surface.

use si::Point3;

use crate::Part;
use crate::envelope::Envelope;

/// A part without the faces that a later one has as well, and these.
pub(crate) struct OwnFaces {
    pub(crate) part: Part,
    pub(crate) shared: Vec<[Point3; 3]>,
}

/// The faces of each part that no later part has within `tolerance` (m).
pub(crate) fn part_shared(parts: &[Part], tolerance: f64, longest: f64) -> Vec<OwnFaces> {
    let envelopes: Vec<Envelope> = parts.iter().map(|part| Envelope::new(&part.triangles(), longest)).collect();
    let is_shared = |number: usize, face: &[u32; 3]| {
        let corners = face.map(|n| parts[number].points[n as usize]);
        let on_surface = |later: &Envelope| {
            corners.iter().all(|p| later.tree.within(*p, tolerance, None).is_some())
                && later.holds_triangle(corners, tolerance)
        };
        envelopes[number + 1..].iter().any(on_surface)
    };
    let own_faces = |(number, part): (usize, &Part)| {
        let (shared, own): (Vec<[u32; 3]>, Vec<[u32; 3]>) = part.faces.iter().partition(|face| is_shared(number, face));
        let shared = shared.into_iter().map(|face| face.map(|n| part.points[n as usize])).collect();
        OwnFaces { part: Part { faces: own, ..part.clone() }, shared }
    };
    parts.iter().enumerate().map(own_faces).collect()
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
        let own = part_shared(&[body, insert], 1e-6, 0.01);
        assert_eq!((own[0].part.faces.len(), own[0].shared.len()), (10, 2));
        assert_eq!((own[1].part.faces.len(), own[1].shared.len()), (12, 0));
        assert!(own[0].shared.iter().flatten().all(|p| p[0] == 0.01));
    }
}
