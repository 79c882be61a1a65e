//! Elements that thin walls will take, estimated before they are made.
//!
//! The estimate of a body by its volume and area knows one length of edges; walls in several elements have edges of a part of their thickness.

use si::Point3;
use si::vec3::norm;

use crate::envelope::{Envelope, MAX_TRIANGLES, cut_pieces};
use crate::geometry::normal;
use crate::{Fill, Part, Refusal, Settings};

/// Area of an equilateral triangle over the square of its edge.
pub(crate) const TRIANGLE: f64 = 0.433;
/// Tetrahedra below a triangle of a surface.
pub(crate) const BELOW: f64 = 3.0;

/// Whether the walls of parts can be meshed with the elements through them that are asked for.
///
/// # Errors
/// [`Refusal::ThinWalls`]
pub(crate) fn check_walls(parts: &[Part], walls: &Envelope, set: &Settings) -> Result<(), Refusal> {
    let elements: f64 = parts.iter().map(|part| wall_elements(part, walls, set)).sum();
    let limit = set.max_elements;
    if elements <= limit { Ok(()) } else { Err(Refusal::ThinWalls { elements, limit }) }
}

fn wall_elements(part: &Part, walls: &Envelope, set: &Settings) -> f64 {
    let elements_below = |piece: [Point3; 3]| {
        let [wall, gap] = walls.wall_and_gap(piece, piece[0], [set.envelope, set.edge]);
        let width = if part.fill == Fill::Void { gap } else { wall };
        let size = (set.aspect * width).clamp(set.least, set.edge);
        // each of the two sides of a wall has half of its layers
        let layers = (width.min(set.edge) / (2.0 * size)).max(1.0);
        BELOW * layers * norm(normal(piece)) / (2.0 * TRIANGLE * size * size)
    };
    part.triangles().into_iter().flat_map(|face| cut_pieces(face, set.edge, MAX_TRIANGLES)).map(elements_below).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tetrahedralize;

    /// A plate of 30 × 20 × 2 mm.
    fn plate() -> Part {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { [0.03, 0.02, 0.002][k] } else { 0.0 });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]]).collect();
        Part { points: (0..8).map(corner).collect(), faces, fill: Fill::Region(0) }
    }

    #[test]
    fn the_estimate_is_within_three_times_what_is_meshed_and_too_many_are_refused() {
        for layers in [1.0, 2.0, 3.0] {
            let set = Settings { aspect: 1.0 / layers, ..Settings::new(5e-3) };
            let estimated = wall_elements(&plate(), &Envelope::new(&plate().triangles(), set.edge), &set);
            let made = tetrahedralize(&[plate()], &set).unwrap().tets.len() as f64;
            assert!((1.0 / 3.0..3.0).contains(&(estimated / made)), "{estimated} of {made}");
        }
        let set = Settings { aspect: 1.0 / 40.0, least: 1e-6, ..Settings::new(5e-3) };
        let refusal = tetrahedralize(&[plate()], &set).unwrap_err();
        assert!(matches!(refusal, Refusal::ThinWalls { .. }), "{refusal}");
    }
}
