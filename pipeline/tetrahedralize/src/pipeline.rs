//! From surfaces to tetrahedra: the order of the steps.

use si::Point3;
use si::vec3::norm;

use crate::complex::{Complex, OUTSIDE};
use crate::delaunay::Delaunay;
use crate::envelope::Envelope;
use crate::estimate::{BELOW, TRIANGLE, check_walls};
use crate::geometry::{distance, normal};
use crate::improve::Improve;
use crate::insertion::insert_triangle;
use crate::labels::{Space, label_all};
use crate::lattice::{SizeField, graded_lattice};
use crate::orient::{orient_part, without_degenerate};
use crate::remesh::{Remesh, Sizing, Solid};
use crate::shared_faces::{OwnFaces, part_shared};
use crate::topology::{Speck, clean_labels};
use crate::tree::Tree;
use crate::{Fill, Part, Refusal, Repair, Settings, Tetrahedra};

/// Distances are sampled: what is held to this share of the envelope keeps to it in between.
const MARGIN: f64 = 0.8;
/// Share of the envelope that the remeshed surface may use; what is left is for the tetrahedra's own changes of it.
const SHARE: f64 = 0.6;
/// Faces of two parts are one where they are nearer than this share of the envelope.
const SHARED: f64 = 0.25;
/// A node lies on a triangle's plane when it is nearer than this share of the distance allowed there.
const ON_PLANE: f64 = 0.05;
/// Parts of less than the cube of this share of an edge are splinters, not chambers.
const SPECK: f64 = 0.05;
/// So are those thinner than this share of the envelope.
const THIN: f64 = 0.5;
/// Volume of a regular tetrahedron over the cube of its edge.
const TETRAHEDRON: f64 = 0.117_85;

/// Remeshed surfaces of all parts.
#[derive(Default)]
struct Skin {
    points: Vec<Point3>,
    faces: Vec<[u32; 3]>,
    size: Vec<f64>,
    slack: Vec<f64>,
    lines: Vec<[Point3; 2]>,
    corners: Vec<Point3>,
}

/// Fills surfaces with tetrahedra.
///
/// # Errors
/// [`Refusal`], which names the part, the face or the place; before anything is made, when that would take too much memory.
pub fn tetrahedralize(parts: &[Part], set: &Settings) -> Result<Tetrahedra, Refusal> {
    tetrahedralize_watched(parts, set, &|_| ())
}

/// As [`tetrahedralize`]; `watch` is called when a step is done, with what was done and the number of elements then.
///
/// # Errors
/// As [`tetrahedralize`].
pub fn tetrahedralize_watched(parts: &[Part], set: &Settings, watch: &dyn Fn(&str)) -> Result<Tetrahedra, Refusal> {
    check_parts(parts, set)?;
    let oriented: Vec<(Part, Vec<Repair>)> = parts.iter().map(|part| orient_part(&without_degenerate(part))).collect();
    let (parts, repairs): (Vec<Part>, Vec<Vec<Repair>>) = oriented.into_iter().unzip();
    let parts = parts.as_slice();
    let triangles: Vec<[Point3; 3]> = parts.iter().flat_map(Part::triangles).collect();
    let set = &Settings { envelope: MARGIN * set.envelope, ..*set };
    let envelope = Envelope::new(&triangles, set.edge);
    check_walls(parts, &envelope, set)?;
    let (skin, space) = remesh_parts(parts, &envelope, set);
    watch(&format!("surfaces remeshed: {} triangles", skin.faces.len()));
    let places: Vec<[Point3; 3]> = skin.faces.iter().map(|f| f.map(|n| skin.points[n as usize])).collect();
    let tree = Tree::new(&places);
    let minimum = |values: &[f64]| -> Vec<f64> {
        skin.faces.iter().map(|f| f.iter().map(|n| values[*n as usize]).fold(f64::INFINITY, f64::min)).collect()
    };
    let (size, slack) = (minimum(&skin.size), minimum(&skin.slack));
    let field = SizeField { tree: &tree, size: &size, gradation: set.gradation, edge: set.edge };
    let mut complex = conforming_complex(&skin, &field, &space);
    label_all(&mut complex, &space);
    clean_labels(&mut complex, Speck { volume: (SPECK * set.edge).powi(3), thickness: THIN * set.envelope });
    complex.remove_label(OUTSIDE);
    if complex.living_tets().next().is_none() {
        return Err(Refusal::Nothing { at: triangles[0][0] });
    }
    watch(&format!("surfaces inserted: {} tetrahedra", complex.living_tets().count()));
    let (on_skin, _) = complex.whole_skin();
    let node_size = complex.points.iter().map(|p| field.length_and_distance(*p)[0]).collect();
    let allowed = |p: &Point3| tree.nearest(*p, f64::INFINITY).map_or(0.0, |near| slack[near.triangle as usize]);
    let node_slack = complex.points.iter().map(|p| allowed(p) * 0.95 / SHARE).collect();
    let lines = Tree::new(&skin.lines.iter().map(|[a, b]| [*a, *b, *b]).collect::<Vec<_>>());
    let corners = Tree::new(&skin.corners.iter().map(|a| [*a; 3]).collect::<Vec<_>>());
    let mut improve =
        Improve { complex, size: node_size, slack: node_slack, on_skin, envelope: &envelope, lines, corners };
    improve.run_rounds(set.rounds, watch);
    Ok(Tetrahedra { repairs: repairs.concat(), ..compact_complex(&improve.complex) })
}

/// Whether there is something to mesh, and not too much.
fn check_parts(parts: &[Part], set: &Settings) -> Result<(), Refusal> {
    let numbers = [("edge", set.edge), ("envelope", set.envelope), ("least", set.least), ("aspect", set.aspect)];
    for (name, value) in numbers.into_iter().chain([("gradation", set.gradation)]) {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Refusal::Setting { name, value });
        }
    }
    let (mut elements, mut length) = (0.0, 0.0f64);
    for (number, part) in parts.iter().enumerate() {
        let placed = |f: &[u32; 3]| {
            f.iter().all(|n| part.points.get(*n as usize).is_some_and(|p| p.iter().all(|x| x.is_finite())))
        };
        if let Some(face) = part.faces.iter().position(|f| !placed(f)) {
            return Err(Refusal::NoPlace { part: number, face });
        }
        if part.faces.is_empty() {
            return Err(Refusal::Empty { part: number });
        }
        let area: f64 = part.triangles().iter().map(|t| si::vec3::norm(normal(*t)) / 2.0).sum();
        let far = part.points.iter().map(|p| distance(*p, part.points[0])).fold(0.0, f64::max);
        length = length.max(far);
        // no body of a given area holds more than a ball
        let volume = (area / (4.0 * std::f64::consts::PI)).powf(1.5) * 4.0 / 3.0 * std::f64::consts::PI;
        elements += volume / (TETRAHEDRON * set.edge.powi(3)) + BELOW * area / (TRIANGLE * set.edge.powi(2));
    }
    // an overflow is none of a number below the limit
    if elements <= set.max_elements {
        return Ok(());
    }
    Err(Refusal::TooLarge { length, edge: set.edge, elements, limit: set.max_elements })
}

fn remesh_parts(parts: &[Part], envelope: &Envelope, set: &Settings) -> (Skin, Space) {
    let sizing = Sizing {
        edge: set.edge,
        least: set.least,
        aspect: set.aspect,
        gradation: set.gradation,
        slack: SHARE * set.envelope,
        solid: Solid::Below,
        walls: envelope,
    };
    let mut skin = Skin::default();
    let mut surfaces = Vec::new();
    let own_faces = part_shared(parts, SHARED * set.envelope, set.edge);
    for (number, (OwnFaces { part, shared }, whole)) in own_faces.into_iter().zip(parts).enumerate() {
        let envelope = Envelope::new(&whole.triangles(), set.edge);
        let mut surface = Remesh::new((part.points, part.faces), &envelope, 0.4 * set.edge);
        let solid = match (number, part.fill) {
            (_, Fill::Void) => Solid::Above,
            (0, _) => Solid::Below,
            _ => Solid::Both,
        };
        surface.remesh_surface(&Sizing { solid, ..sizing.clone() });
        let (points, faces, size, slack) = surface.finish_surface();
        let (lines, corners) = surface.features();
        skin.lines.extend(lines);
        skin.corners.extend(corners);
        let places: Vec<[Point3; 3]> = faces.iter().map(|f| f.map(|n| points[n as usize])).collect();
        surfaces.push((Tree::new(&[places, shared].concat()), part.fill));
        let first = skin.points.len() as u32;
        skin.points.extend(points);
        skin.faces.extend(faces.into_iter().map(|f| f.map(|n| n + first)));
        skin.size.extend(size);
        skin.slack.extend(slack);
    }
    (skin, Space::new(surfaces))
}

/// Tetrahedra of which the surfaces are unions of faces.
fn conforming_complex(skin: &Skin, field: &SizeField, space: &Space) -> Complex {
    let inner = graded_lattice(field, &skin.points, &|at| space.label_at(at) != OUTSIDE);
    let mut delaunay = Delaunay::around(&skin.points);
    let numbers = delaunay.insert_all(&skin.points);
    delaunay.insert_all(&inner);
    let tets = delaunay.living_tetrahedra();
    let labels = vec![0; tets.len()];
    let mut complex = Complex::new(delaunay.points, tets, labels);
    // The largest first: a triangle's plane cuts tetrahedra beyond it as well, up to what is there already. Holes in a sheet cut what is above the
    // sheet into flat tetrahedra when they come before its faces.
    let area = |face: &[u32; 3]| norm(normal(face.map(|n| skin.points[n as usize])));
    let mut faces = skin.faces.clone();
    faces.sort_by(|a, b| area(b).total_cmp(&area(a)));
    // a second time for triangles whose splits were refused: others have changed the tetrahedra since
    for _ in 0..2 {
        let mut failed = 0;
        for face in &faces {
            let tolerance = ON_PLANE * face.iter().map(|n| skin.slack[*n as usize]).fold(f64::INFINITY, f64::min);
            let nodes = face.map(|n| numbers[n as usize]);
            let [a, b, c] = nodes;
            if a != b && b != c && c != a {
                failed += insert_triangle(&mut complex, nodes, tolerance);
            }
        }
        if failed == 0 {
            break;
        }
    }
    complex
}

fn compact_complex(complex: &Complex) -> Tetrahedra {
    let mut number = vec![u32::MAX; complex.points.len()];
    let mut mesh = Tetrahedra::default();
    for tet in complex.living_tets() {
        let nodes = complex.tets[tet as usize].map(|n| {
            let number = &mut number[n as usize];
            if *number == u32::MAX {
                *number = mesh.nodes.len() as u32;
                mesh.nodes.push(complex.points[n as usize]);
            }
            *number
        });
        mesh.tets.push(nodes);
        mesh.regions.push(complex.labels[tet as usize]);
    }
    mesh
}
