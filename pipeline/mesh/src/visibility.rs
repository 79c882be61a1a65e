//! Places of overlapping surfaces that bound something, and the farthest of them.

use si::vec3::{add, cross, norm, scale, sub};
use si::{Metre, Point3};
use tetrahedralize::Winding;

/// Sides of a face are looked at so far off it, as a share of an edge.
const DEPTH: f64 = 1e-3;

/// Which places of surfaces bound something: those with unlike parts on their two sides.
pub(crate) struct Visibility {
    space: Space,
    /// Sides are looked at so far off a face, m.
    depth: Metre,
    /// Longer faces are cut, m.
    edge: Metre,
}

impl Visibility {
    /// Of parts by their windings, of which so many are solids, with edges of a length, m.
    pub(crate) fn new(windings: Vec<Winding>, solids: usize, edge: Metre) -> Self {
        Self { space: Space { windings, solids }, depth: DEPTH * edge, edge }
    }

    /// Whether a place of a face bounds something.
    pub(crate) fn is_seen(&self, corners: [Point3; 3], point: Point3) -> bool {
        let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let offset = scale(normal, self.depth / norm(normal).max(f64::MIN_POSITIVE));
        self.space.part_at(add(point, offset)) != self.space.part_at(sub(point, offset))
    }

    /// Of the places of faces that bound something the one that is farthest by a measure, and how far.
    // The measure first: it takes a search in a tree where visibility takes two sums over all faces, and only places
    // beyond the farthest one need be asked for it. Cutting hidden faces off instead took minutes of a wheel.
    pub(crate) fn farthest(
        &self,
        faces: &[[Point3; 3]],
        distance: &dyn Fn(Point3) -> Metre,
    ) -> Option<(Metre, Point3)> {
        let mut worst: Option<(Metre, Point3)> = None;
        for (piece, place) in places_of_faces(faces, self.edge) {
            let measured = distance(place);
            // seen from a little within the piece: on an edge of the surface a place has no one side
            let inner = add(scale(place, 0.9), scale(triangle_centroid(piece), 0.1));
            if worst.is_none_or(|(most, _)| measured > most) && self.is_seen(piece, inner) {
                worst = Some((measured, place));
            }
        }
        worst
    }
}

/// What fills a place: the last part that holds it.
struct Space {
    windings: Vec<Winding>,
    /// The parts before are solids, the others cavities.
    solids: usize,
}

impl Space {
    fn part_at(&self, point: Point3) -> usize {
        // Half and not one: the winding number about a surface with gaps is no whole number, and decides by half all
        // the same.
        let holding = self.windings.iter().rposition(|w| w.number_at(point) > 0.5);
        holding.filter(|part| *part < self.solids).unwrap_or(usize::MAX)
    }
}

/// Places of faces, each with the piece of a face that it is of; no side of a piece is longer than a length.
pub(crate) fn places_of_faces(
    faces: &[[Point3; 3]],
    longest: Metre,
) -> impl Iterator<Item = ([Point3; 3], Point3)> + '_ {
    let pieces = faces.iter().flat_map(move |face| short_pieces(*face, longest));
    pieces.flat_map(|piece| face_samples(piece).map(|place| (piece, place)))
}

/// Seven places: corners alone of a coarse face that spans a dent lie on the surface, and would show no distance.
pub(crate) fn face_samples([a, b, c]: [Point3; 3]) -> [Point3; 7] {
    let middle = |p: Point3, q: Point3| [0, 1, 2].map(|k| (p[k] + q[k]) / 2.0);
    [a, b, c, middle(a, b), middle(b, c), middle(c, a), triangle_centroid([a, b, c])]
}

/// A triangle in pieces of which no side is longer than a length.
fn short_pieces(face: [Point3; 3], longest: Metre) -> Vec<[Point3; 3]> {
    let (mut short, mut stack) = (Vec::new(), vec![face]);
    while let Some([a, b, c]) = stack.pop() {
        let sides = [[a, b, c], [b, c, a], [c, a, b]];
        let lengths = sides.map(|[p, q, _]| norm(sub(p, q)));
        let side = (0..3).max_by(|i, j| lengths[*i].total_cmp(&lengths[*j])).unwrap_or(0);
        if lengths[side] <= longest {
            short.push([a, b, c]);
            continue;
        }
        let [p, q, tip] = sides[side];
        let half = scale(add(p, q), 0.5);
        stack.extend([[p, half, tip], [half, q, tip]]);
    }
    short
}

pub(crate) fn triangle_centroid(corners: [Point3; 3]) -> Point3 {
    scale(corners.into_iter().fold([0.0; 3], add), 1.0 / 3.0)
}
