//! Middle nodes on the surfaces that a mesh stands for.
//!
//! The middle of a boundary edge moves to the nearest point of the surfaces that looks the same way; along a crease, to the nearest point of the
//! crease. Where an element might come near to folding, its middles go back onto their chords, the farthest first. What decides are the Bézier
//! coefficients of its determinant \[johnen2013\]: they bound it everywhere, samples only where they lie.

use crate::distance::Nearest;
use crate::foreign::{interface_faces, least_determinant};
use crate::{QuadraticElements, QuadraticMesh, Surface};
use si::vec3::{add, cross, dot, norm, scale, sub};
use si::{Metre, Point3};
use std::collections::BTreeMap;

/// A middle moves by this part of its edge at most: on a round surface, an edge of a third of a turn.
const REACH: f64 = 0.25;
/// Moves below this part of the edge are rounding of a plane surface.
const LEVEL: f64 = 1e-6;
/// Least bound of an element's determinant over that of the straight one.
// Chosen, not measured: clear of zero, where a load would fold the element, and far below what a round part needs.
const LEAST_DETERMINANT: f64 = 0.25;
/// Cosine of the angle between faces from which an edge of the surfaces is a crease: tessellations of round parts turn by up to 30°.
const CREASE: f64 = 0.766;
/// Cosine of the angle between the mesh's faces below which their edge can lie on a crease.
const TURNED: f64 = 0.94;
/// Cosine of the angle between a face of the mesh and the surface that it stands for.
const SAME_WAY: f64 = 0.5;

/// Middles of a mesh's boundary edges that are not on plane surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Curving {
    /// On the surfaces.
    pub curved: usize,
    /// On their chords, for the sake of their elements or for want of a surface that looks the same way.
    pub straight: usize,
}

/// Moves the middles of boundary edges onto the surfaces, normals out of the solid (of an insert, out of the insert). `tolerance` (m) is how far
/// off a crease the corners on it may lie.
pub(crate) fn curve_middles(solid: &mut QuadraticMesh, surfaces: &[&Surface], tolerance: Metre) -> Curving {
    let target = Target::of_surfaces(surfaces, tolerance);
    let chord_middles = solid.nodes.clone();
    let mut curving = Curving::default();
    for (middle, edge) in boundary_edges(solid) {
        match target.middle_of(&edge, chord_middles[middle as usize]) {
            Some(place) if norm(sub(place, chord_middles[middle as usize])) > LEVEL * edge.length() => {
                solid.nodes[middle as usize] = place;
                curving.curved += 1;
            }
            Some(_) => {}
            None => curving.straight += 1,
        }
    }
    let straightened = straighten_folded(solid, &chord_middles);
    Curving { curved: curving.curved - straightened, straight: curving.straight + straightened }
}

/// An edge between faces of the boundary.
struct BoundaryEdge {
    ends: [Point3; 2],
    /// Unit normals of the faces that meet at it.
    normals: Vec<Point3>,
}

impl BoundaryEdge {
    fn length(&self) -> Metre {
        norm(sub(self.ends[1], self.ends[0]))
    }

    /// Whether its faces turn at it, or are more than two.
    fn is_turned(&self) -> bool {
        !matches!(self.normals.as_slice(), [a, b] if dot(*a, *b) > TURNED)
    }
}

/// Edges of the skin and of interfaces by their middle nodes.
fn boundary_edges(solid: &QuadraticMesh) -> BTreeMap<u32, BoundaryEdge> {
    let place = |node: u32| solid.nodes[node as usize];
    let skin = solid.skin.iter().filter_map(|face| Some((face.nodes().try_into().ok()?, 1.0)));
    // an interface's face looks out of the lower region, which is into the insert
    let interfaces = interface_faces(solid).into_iter().map(|(face, _)| (face, -1.0));
    let mut edges = BTreeMap::new();
    for (face, sign) in skin.chain(interfaces) {
        let [a, b, c, ab, bc, ca]: [u32; 6] = face;
        let normal = cross(sub(place(b), place(a)), sub(place(c), place(a)));
        let normal = scale(normal, sign / norm(normal).max(f64::MIN_POSITIVE));
        for (middle, ends) in [(ab, [a, b]), (bc, [b, c]), (ca, [c, a])] {
            let edge = BoundaryEdge { ends: ends.map(place), normals: Vec::new() };
            edges.entry(middle).or_insert(edge).normals.push(normal);
        }
    }
    edges
}

/// The surfaces to lie on.
struct Target {
    faces: Nearest,
    /// Edges at which they turn, as triangles without width.
    creases: Nearest,
    tolerance: Metre,
}

impl Target {
    fn of_surfaces(surfaces: &[&Surface], tolerance: Metre) -> Self {
        let faces = surfaces.iter().flat_map(|s| (0..s.faces.len()).map(|f| s.corners(f))).collect();
        let creases = surfaces.iter().flat_map(|s| s.creases(CREASE)).map(|[a, b]| [a, b, b]).collect();
        Self { faces: Nearest::new(faces), creases: Nearest::new(creases), tolerance }
    }

    /// Where the middle of an edge belongs; none where nothing within reach looks the same way.
    fn middle_of(&self, edge: &BoundaryEdge, chord_middle: Point3) -> Option<Point3> {
        let on_crease = |end: Point3| self.creases.find(end).is_some_and(|hit| hit.distance <= self.tolerance);
        let nearest =
            if edge.is_turned() && edge.ends.into_iter().all(on_crease) { &self.creases } else { &self.faces };
        let nearest_point = nearest.find(chord_middle).filter(|hit| hit.distance <= REACH * edge.length())?;
        let mean = edge.normals.iter().fold([0.0; 3], |sum, normal| add(sum, *normal));
        let [a, b, c] = nearest.corners(&nearest_point);
        let normal = cross(sub(b, a), sub(c, a));
        // a crease has no normal, and nothing to look the same way
        let same_way = dot(normal, mean) >= SAME_WAY * norm(normal) * norm(mean);
        let [share_a, share_b, share_c] = nearest_point.shares;
        same_way.then(|| [0, 1, 2].map(|k| share_a * a[k] + share_b * b[k] + share_c * c[k]))
    }
}

/// Puts middles back onto their chords until no determinant is too small, and says how many.
fn straighten_folded(solid: &mut QuadraticMesh, chord_middles: &[Point3]) -> usize {
    let QuadraticElements::Tetrahedra(tets) = &solid.elements else { return 0 };
    let (nodes, mut straightened) = (&mut solid.nodes, 0);
    let displacement = |nodes: &[Point3], node: u32| norm(sub(nodes[node as usize], chord_middles[node as usize]));
    loop {
        let straightened_before = straightened;
        for tet in tets {
            let farthest = tet[4..].iter().max_by(|a, b| displacement(nodes, **a).total_cmp(&displacement(nodes, **b)));
            // A middle that goes back can uncover a fold in a neighbour, whose other middles leaned the same way: it is
            // seen in the next round.
            if let Some(&middle) = farthest.filter(|middle| displacement(nodes, **middle) > 0.0)
                && is_folded(&tet.map(|node| nodes[node as usize]))
            {
                nodes[middle as usize] = chord_middles[middle as usize];
                straightened += 1;
            }
        }
        if straightened == straightened_before {
            return straightened;
        }
    }
}

fn is_folded(places: &[Point3; 10]) -> bool {
    let [a, b, c, d] = [places[0], places[1], places[2], places[3]];
    least_determinant(places) < LEAST_DETERMINANT * dot(cross(sub(b, a), sub(c, a)), sub(d, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::block;
    use crate::{Method, Settings, TetMesh, mesh_assembly, quadratic};

    const RADIUS: f64 = 0.01;

    /// A cylinder of fine facets with sharp rims.
    fn cylinder(facets: u32) -> Surface {
        let rim = |z: f64| {
            move |k: u32| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(facets);
                [RADIUS * angle.cos(), RADIUS * angle.sin(), z]
            }
        };
        let points =
            (0..facets).map(rim(0.0)).chain((0..facets).map(rim(RADIUS))).chain([[0.0; 3], [0.0, 0.0, RADIUS]]);
        let faces = (0..facets).flat_map(|k| {
            let (a, b) = (k, (k + 1) % facets);
            let (c, d) = (a + facets, b + facets);
            [[a, b, d], [a, d, c], [2 * facets, b, a], [2 * facets + 1, c, d]]
        });
        Surface { points: points.collect(), faces: faces.collect() }
    }

    fn meshed(surface: &Surface, edge: f64) -> crate::Chosen {
        let set = Settings { method: Method::General, use_symmetry: false, ..Settings::new(edge) };
        mesh_assembly(&crate::Assembly::of_body(surface, None), &set, &|_| ()).unwrap()
    }

    #[test]
    fn middles_of_a_cylinder_lie_on_its_side_and_on_its_rims() {
        let chosen = meshed(&cylinder(180), RADIUS / 2.0);
        let curving = chosen.curving.unwrap();
        assert!(curving.curved > 20 * curving.straight && curving.curved > 50, "{curving:?}");
        let (mut off_chords, mut off_middles) = (0.0_f64, 0.0_f64);
        for (middle, edge) in boundary_edges(&chosen.solid) {
            let radius = |p: Point3| p[0].hypot(p[1]);
            if edge.ends.iter().all(|end| (radius(*end) / RADIUS - 1.0).abs() < 1e-3) {
                let chord = scale(add(edge.ends[0], edge.ends[1]), 0.5);
                off_chords = off_chords.max((radius(chord) / RADIUS - 1.0).abs());
                off_middles = off_middles.max((radius(chosen.solid.nodes[middle as usize]) / RADIUS - 1.0).abs());
            }
        }
        assert!(off_chords > 5e-3 && off_middles < 2e-4, "{off_chords} {off_middles}");
    }

    #[test]
    fn curved_elements_hold_the_volume_that_straight_ones_miss() {
        let surface = cylinder(180);
        let chosen = meshed(&surface, RADIUS / 2.0);
        let straight = quadratic(&chosen.solid.clone().into_corners());
        let missing = |mesh: &QuadraticMesh| (enclosed(mesh) / surface.volume() - 1.0).abs();
        assert!(missing(&chosen.solid) < 0.1 * missing(&straight), "{} {}", missing(&chosen.solid), missing(&straight));
    }

    /// Volume within the skin, by the divergence theorem over small straight triangles, m³.
    fn enclosed(mesh: &QuadraticMesh) -> f64 {
        const PARTS: u32 = 8;
        let mut volume = 0.0;
        for face in &mesh.skin {
            let corners: Vec<Point3> = face.nodes().iter().map(|n| mesh.nodes[*n as usize]).collect();
            let place = |i: u32, j: u32| {
                let shares = [i, j].map(|k| f64::from(k) / f64::from(PARTS));
                let shape = crate::quadratic_face::shape_functions(6, shares);
                shape.iter().zip(&corners).fold([0.0; 3], |sum, (n, x)| add(sum, scale(*x, *n)))
            };
            let cone = |[a, b, c]: [Point3; 3]| dot(a, cross(b, c)) / 6.0;
            for (i, j) in (0..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (i, j))) {
                volume += cone([place(i, j), place(i + 1, j), place(i, j + 1)]);
                if i + j + 1 < PARTS {
                    volume += cone([place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
                }
            }
        }
        volume
    }

    #[test]
    fn middles_of_a_box_stay_on_its_edges() {
        let chosen = meshed(&block([0.0; 3], [0.03, 0.02, 0.02]), 5e-3);
        assert_eq!(chosen.curving, Some(Curving::default()));
    }

    #[test]
    fn an_element_that_would_fold_keeps_its_chord() {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]];
        let skin = vec![crate::SkinFace { nodes: [0, 2, 1], on: crate::Skin::Outer }];
        let mut solid = quadratic(&TetMesh { nodes, tets: vec![[0, 1, 2, 3]], regions: vec![0], skin, half: false });
        let chord_middles = solid.nodes.clone();
        // a tenth of the height is harmless, the whole height folds
        for (rise, kept) in [(0.01, 1), (0.1, 0)] {
            solid.nodes[4][2] = rise;
            assert_eq!(straighten_folded(&mut solid, &chord_middles), 1 - kept, "{rise}");
            assert_eq!(solid.nodes[4][2] > 0.0, kept == 1);
            solid.nodes.clone_from(&chord_middles);
        }
    }
}
