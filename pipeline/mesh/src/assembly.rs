//! A body, inserts and cavities: the surfaces of one solid, each of its own.

use crate::Surface;
use si::vec3::{add, cross, norm, scale, sub};
use si::{CubicMetre, Metre, Point3};
use tetrahedralize::{Fill, Part, Winding};

/// Faces of a part from which it is seen what lies on their two sides.
const PROBES: usize = 400;
/// Pieces of a face of which a part is hidden are cut down to this share of an edge.
// Where faces coincide everything is cut down to it: with 0.05 a wheel of five thousand faces took minutes.
const HIDDEN: f64 = 0.25;
/// Probes lie so far off the face, as a share of the part's length or of an edge.
const DEPTH: f64 = 1e-3;

/// The surfaces of one solid. An insert displaces the body and the inserts before it where both are; a cavity displaces all.
#[derive(Debug, Clone)]
pub struct Assembly<'a> {
    /// The body: region 0.
    pub body: &'a Surface,
    /// Inserts: regions 1, 2, …
    pub inserts: Vec<&'a Surface>,
    /// Cavities that the body's own surface does not show.
    pub cavities: Vec<&'a Surface>,
}

impl<'a> Assembly<'a> {
    /// Of a body with a sheet, if it has one.
    pub(crate) fn of_body(body: &'a Surface, spine: Option<&'a Surface>) -> Self {
        Self { body, inserts: spine.into_iter().collect(), cavities: Vec::new() }
    }

    /// Body and inserts, in the order of their regions.
    pub(crate) fn solids(&self) -> impl Iterator<Item = &'a Surface> + '_ {
        std::iter::once(self.body).chain(self.inserts.iter().copied())
    }

    /// All surfaces, those that displace others last.
    pub(crate) fn surfaces(&self) -> Vec<&'a Surface> {
        self.solids().chain(self.cavities.iter().copied()).collect()
    }

    pub(crate) fn parts(&self) -> Vec<Part> {
        let solids = self.solids().zip(0..).map(|(surface, region)| (surface, Fill::Region(region)));
        let voids = self.cavities.iter().map(|surface| (*surface, Fill::Void));
        let part = |(surface, fill): (&Surface, Fill)| Part {
            points: surface.points.clone(),
            faces: surface.faces.clone(),
            fill,
        };
        solids.chain(voids).map(part).collect()
    }

    /// What each region should hold: the volume of its surface less that of the parts that lie in it, m³; none where a surface is open or overlaps
    /// itself, or a part lies in another one in part.
    pub(crate) fn expected_volumes(&self) -> Vec<Option<CubicMetre>> {
        let surfaces = self.surfaces();
        let windings: Vec<Winding> = surfaces.iter().map(|surface| surface_winding(surface)).collect();
        let mut volumes: Vec<Option<f64>> =
            surfaces.iter().zip(&windings).map(|(s, w)| is_simple(s, w).then(|| s.volume())).collect();
        for inner in (1..surfaces.len()).rev() {
            for outer in (0..inner).rev() {
                let share = share_inside(surfaces[inner], |probe| windings[outer].number_at(probe) > 0.5);
                // Not 1 and 0: where the surfaces share faces, probes beside these fall to either side by rounding.
                if share > 0.98 {
                    volumes[outer] = volumes[outer].zip(volumes[inner]).map(|(v, _)| v - surfaces[inner].volume());
                    break;
                }
                if share > 0.02 {
                    volumes[outer] = None;
                }
            }
        }
        volumes.truncate(1 + self.inserts.len());
        volumes
    }

    /// The parts of the surfaces that bound something, where others lie within a solid or within a cavity; none where all do.
    pub(crate) fn visible_parts(&self, edge: Metre) -> Option<Surface> {
        let surfaces = self.surfaces();
        let space =
            Space { windings: surfaces.iter().map(|s| surface_winding(s)).collect(), solids: 1 + self.inserts.len() };
        let depth = DEPTH * edge;
        let bounds = |corners: [Point3; 3], point: Point3| {
            let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
            let offset = scale(normal, depth / norm(normal).max(f64::MIN_POSITIVE));
            space.part_at(add(point, offset)) != space.part_at(sub(point, offset))
        };
        let probed =
            |s: &&Surface| probe_faces(s).into_iter().all(|f| bounds(s.corners(f), triangle_centroid(s.corners(f))));
        if surfaces.iter().all(probed) {
            return None;
        }
        let mut visible = Surface::default();
        let faces = surfaces.iter().flat_map(|s| (0..s.faces.len()).map(|f| s.corners(f)));
        for face in faces {
            for piece in visible_pieces(face, &|point| bounds(face, point), [HIDDEN * edge, edge]) {
                let first = visible.points.len() as u32;
                visible.points.extend(piece);
                visible.faces.push([first, first + 1, first + 2]);
            }
        }
        Some(visible)
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

fn surface_winding(surface: &Surface) -> Winding {
    Winding::new(&(0..surface.faces.len()).map(|f| surface.corners(f)).collect::<Vec<_>>())
}

fn triangle_centroid(corners: [Point3; 3]) -> Point3 {
    scale(corners.into_iter().fold([0.0; 3], add), 1.0 / 3.0)
}

/// Faces of some area, evenly spaced in their list.
fn probe_faces(surface: &Surface) -> Vec<usize> {
    let step = surface.faces.len().div_ceil(PROBES).max(1);
    (0..surface.faces.len()).step_by(step).filter(|f| norm(surface.normal(*f)) > 0.0).collect()
}

/// The share of points just inside of a surface where something holds.
fn share_inside(surface: &Surface, holds: impl Fn(Point3) -> bool) -> f64 {
    let depth = DEPTH * surface.length();
    let probes = probe_faces(surface);
    let inside = |face: usize| {
        let normal = surface.normal(face);
        add(triangle_centroid(surface.corners(face)), scale(normal, -depth / norm(normal)))
    };
    probes.iter().filter(|face| holds(inside(**face))).count() as f64 / probes.len().max(1) as f64
}

/// Whether a surface is closed and winds once around what is just inside of it: otherwise its parts overlap, and its volume is none.
fn is_simple(surface: &Surface, winding: &Winding) -> bool {
    surface.shells().is_ok() && share_inside(surface, |probe| (winding.number_at(probe) - 1.0).abs() < 0.5) > 0.97
}

/// The parts of a triangle that are visible: cut in two until they are so as a whole, or shorter than the first length; those longer than the
/// second are cut in any case.
fn visible_pieces(
    face: [Point3; 3],
    is_visible: &dyn Fn(Point3) -> bool,
    [shortest, longest]: [Metre; 2],
) -> Vec<[Point3; 3]> {
    let (mut visible, mut stack) = (Vec::new(), vec![face]);
    while let Some(piece) = stack.pop() {
        let [a, b, c] = piece;
        let sides = [[a, b, c], [b, c, a], [c, a, b]];
        let lengths = sides.map(|[p, q, _]| norm(sub(p, q)));
        let longest_side = (0..3).max_by(|i, j| lengths[*i].total_cmp(&lengths[*j])).unwrap_or(0);
        let centre = triangle_centroid(piece);
        // corners are seen from a little within the piece: on an edge of the surface a place has no one side
        let inner = piece.map(|p| is_visible(add(scale(p, 0.9), scale(centre, 0.1))));
        let count = inner.into_iter().chain([is_visible(centre)]).filter(|v| *v).count();
        // Four places of a long piece may all be seen while something narrow hides what lies between them: it is cut in
        // any case.
        if lengths[longest_side] > longest || (count % 4 != 0 && lengths[longest_side] > shortest) {
            let [p, q, tip] = sides[longest_side];
            let half = scale(add(p, q), 0.5);
            stack.extend([[p, half, tip], [half, q, tip]]);
        } else if count == 4 {
            visible.push(piece);
        }
    }
    visible
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};

    #[test]
    fn an_insert_within_a_body_displaces_it_and_one_in_a_pocket_does_not() {
        let (body, insert) = (block([0.0; 3], [0.03, 0.02, 0.02]), block([0.01; 3], [0.02, 0.015, 0.015]));
        let solid = Assembly { body: &body, inserts: vec![&insert], cavities: Vec::new() };
        let volumes = solid.expected_volumes();
        assert!((volumes[0].unwrap() - 1.175e-5).abs() < 1e-12 && (volumes[1].unwrap() - 2.5e-7).abs() < 1e-12);
        let pocket = with_cavity(body.clone(), [0.01; 3], [0.02, 0.015, 0.015]);
        let filled = Assembly { body: &pocket, ..solid };
        assert!((filled.expected_volumes()[0].unwrap() - 1.175e-5).abs() < 1e-12);
    }

    #[test]
    fn of_two_boxes_that_cross_the_faces_within_each_other_are_left_out() {
        let mut crossed = block([0.0; 3], [0.03, 0.01, 0.01]);
        let other = block([0.01, -0.01, 0.002], [0.02, 0.02, 0.008]);
        crossed.points.extend(&other.points);
        crossed.faces.extend(other.faces.iter().map(|f| f.map(|n| n + 8)));
        let solid = Assembly::of_body(&crossed, None);
        let visible = solid.visible_parts(2e-3).unwrap();
        // both surfaces less the ring of the second within the first, and two holes of 10 by 6 mm in the first
        let area = 1.4e-3 + 1.08e-3 - 3.2e-4 - 1.2e-4;
        assert!((visible.area() / area - 1.0).abs() < 0.03, "{}", visible.area() / area);
        assert_eq!(solid.expected_volumes(), [None]);
        assert!(Assembly::of_body(&other, None).visible_parts(2e-3).is_none());
    }

    #[test]
    fn of_an_insert_that_sticks_out_no_volume_is_expected() {
        let (body, insert) = (block([0.0; 3], [0.03, 0.02, 0.02]), block([0.02, 0.005, 0.005], [0.05, 0.015, 0.015]));
        let solid = Assembly { body: &body, inserts: vec![&insert], cavities: Vec::new() };
        assert_eq!(solid.expected_volumes()[0], None);
    }
}
