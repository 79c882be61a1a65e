//! A body, inserts and cavities: the surfaces of one solid, each of its own.

use crate::Surface;
use crate::visibility::{Visibility, triangle_centroid};
use si::vec3::{add, norm, scale};
use si::{CubicMetre, Metre, Point3};
use tetrahedralize::{Fill, Part, Winding};

/// Faces of a part from which it is seen what lies on their two sides.
const PROBES: usize = 400;
/// Probes lie so far off the face, as a share of the part's length.
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

    /// What of the surfaces bounds something, where others lie within a solid or within a cavity; none where all do.
    pub(crate) fn visibility(&self, edge: Metre) -> Option<Visibility> {
        let surfaces = self.surfaces();
        let windings = surfaces.iter().map(|s| surface_winding(s)).collect();
        let visibility = Visibility::new(windings, 1 + self.inserts.len(), edge);
        let is_seen = |corners: [Point3; 3]| visibility.is_seen(corners, triangle_centroid(corners));
        let is_whole = |s: &&Surface| probe_faces(s).into_iter().all(|f| is_seen(s.corners(f)));
        (!surfaces.iter().all(is_whole)).then_some(visibility)
    }
}

fn surface_winding(surface: &Surface) -> Winding {
    Winding::new(&(0..surface.faces.len()).map(|f| surface.corners(f)).collect::<Vec<_>>())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};
    use crate::visibility::places_of_faces;

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
        let visibility = solid.visibility(2e-3).unwrap();
        let faces: Vec<[Point3; 3]> = (0..crossed.faces.len()).map(|f| crossed.corners(f)).collect();
        // how deep a place lies within the first box: the second one's sides do so by 2 mm, and none of it is seen
        let depth = |p: Point3| (0..3).map(|k| p[k].min([0.03, 0.01, 0.01][k] - p[k])).fold(f64::INFINITY, f64::min);
        let worst = |faces: &[[Point3; 3]]| visibility.farthest(faces, &depth).unwrap().0;
        assert!(places_of_faces(&faces, 2e-3).map(|(_, place)| depth(place)).fold(0.0, f64::max) > 1.9e-3);
        assert!(worst(&faces).abs() < 1e-12, "{}", worst(&faces));
        // both surfaces are seen beyond the other
        assert!(visibility.farthest(&faces, &|p| -p[1]).unwrap().0 > 0.0099);
        assert_eq!(solid.expected_volumes(), [None]);
        assert!(Assembly::of_body(&other, None).visibility(2e-3).is_none());
    }

    #[test]
    fn of_an_insert_that_sticks_out_no_volume_is_expected() {
        let (body, insert) = (block([0.0; 3], [0.03, 0.02, 0.02]), block([0.02, 0.005, 0.005], [0.05, 0.015, 0.015]));
        let solid = Assembly { body: &body, inserts: vec![&insert], cavities: Vec::new() };
        assert_eq!(solid.expected_volumes()[0], None);
    }
}
