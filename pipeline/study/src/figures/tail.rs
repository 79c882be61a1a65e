//! Figure `tail`: the specimen at rest, and inflated as the identified model has it. Paper, figure 1.
//!
//! Drawn from the mesh: (a) both regions at rest, the body see-through; (b) the inflated body from above, painted by how far
//! each point has moved.
//!
//! Stands on: plot. Never knows: how a displacement was computed.

use plot::{Axis, ColourBar, DOUBLE_COLUMN_MM, Figure, OverlayKind, Paint, Panel, Scene, View, palette};
use shape::{QuadraticMesh, Skin};
use si::{MILLIBAR, MILLIMETRE, Point3, vec3};

use super::origin_note;
use crate::fault::{Fault, Outcome};
use crate::figure;
use crate::needs::Every;
use crate::records::{Identified, Level, Mesh};

/// The figure.
pub struct Tail;

/// A surface to draw: points, m, and faces by index.
struct Sheet {
    points: Vec<Point3>,
    faces: Vec<[u32; 3]>,
}

impl figure::Figure for Tail {
    type Needs = (Every<Mesh>, Every<Identified>);
    const NAME: &'static str = "tail";
    const SHOWS: &'static str = "the specimen at rest and inflated, as its identified model has it";
    const EDITION: u32 = 1;

    fn draw((Every(meshes), Every(identified)): Self::Needs) -> Outcome<Figure> {
        let (Some((specimen, mesh)), Some((_, found))) = (meshes.first(), identified.first()) else {
            return Err(Fault::new("there is no tail to show", "no specimen is identified", "study run identify"));
        };
        let highest = found.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let title = format!("{} at {:.0} mbar, simulated", specimen.card.name, highest / MILLIBAR);
        let panels = [
            Panel::Scene(at_rest(mesh)).titled(&format!("{} at rest", specimen.card.name)),
            Panel::Scene(inflated(mesh, found)).titled(&title).share(1.1),
        ];
        Ok(Figure::new(DOUBLE_COLUMN_MM)
            .row(74.0, panels)
            .noted(&origin_note(meshes.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

fn at_rest(mesh: &Mesh) -> Scene {
    let solid = &mesh.solid;
    let faces = |wanted: fn(Skin) -> bool| drawn(solid, &solid.nodes, wanted);
    let spine = region_faces(solid, shape::SPINE);
    let outer = faces(|on| on == Skin::Outer);
    let walls = faces(|on| matches!(on, Skin::Chamber(_)));
    Scene::new(View::CORNER)
        .with_surface(&spine.points, &spine.faces, Paint::Solid(palette::SPINE))
        .with_surface(&walls.points, &walls.faces, Paint::Clear(palette::PRESSURE, 0.35))
        .with_surface(&outer.points, &outer.faces, Paint::Clear(palette::BODY, 0.25))
        .with_scale_bar(20.0 * MILLIMETRE)
}

fn inflated(mesh: &Mesh, found: &Identified) -> Scene {
    let solid = &mesh.solid;
    let moved: Vec<Point3> = solid.nodes.iter().zip(&found.inflated).map(|(&x, &u)| vec3::add(x, u)).collect();
    let far: Vec<f64> = found.inflated.iter().map(|&u| vec3::norm(u) / MILLIMETRE).collect();
    let outer = drawn(solid, &moved, |on| on == Skin::Outer);
    let far = if solid.half { [far.as_slice(), far.as_slice()].concat() } else { far };
    let markers: Vec<Point3> = mesh.markers.iter().map(|spot| spot.at(&moved)).collect();
    Scene::new(View { towards: [-0.12, 0.28, -1.0], up: [0.0, 1.0, 0.0] })
        .with_values(&outer.points, &outer.faces, &far, ColourBar { range: None, ..Axis::linear("displacement", "mm") })
        .with_overlay(markers, OverlayKind::Markers(plot::Marker::Disc), palette::INK, 3.0)
        .with_scale_bar(20.0 * MILLIMETRE)
}

/// The skin that is wanted as four small faces each, and its mirror image of a half model.
fn drawn(solid: &QuadraticMesh, points: &[Point3], wanted: fn(Skin) -> bool) -> Sheet {
    let chosen = solid.skin.iter().filter(|f| wanted(f.on));
    mirrored(solid, points, chosen.flat_map(|f| quarters(f.nodes)).collect())
}

/// Faces of one region towards anything else: the skin's faces whose corners all belong to it.
fn region_faces(solid: &QuadraticMesh, region: u16) -> Sheet {
    let faces = [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]];
    let mut seen = std::collections::BTreeMap::new();
    for (tet, _) in solid.tets.iter().zip(&solid.regions).filter(|(_, r)| **r == region) {
        for face in faces {
            let nodes = face.map(|i: usize| tet[i]);
            let mut key = [nodes[0], nodes[1], nodes[2]];
            key.sort_unstable();
            seen.entry(key).and_modify(|(count, _)| *count += 1).or_insert((1, nodes));
        }
    }
    let own = seen.into_values().filter(|(count, _)| *count == 1).flat_map(|(_, nodes)| quarters(nodes)).collect();
    mirrored(solid, &solid.nodes, own)
}

fn quarters([a, b, c, ab, bc, ca]: [u32; 6]) -> [[u32; 3]; 4] {
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

fn mirrored(solid: &QuadraticMesh, points: &[Point3], faces: Vec<[u32; 3]>) -> Sheet {
    if !solid.half {
        return Sheet { points: points.to_vec(), faces };
    }
    let shift = points.len() as u32;
    let reflected = points.iter().map(|&[x, y, z]| [x, y, -z]);
    let back = faces.iter().map(|&[a, b, c]| [a + shift, c + shift, b + shift]).collect::<Vec<_>>();
    Sheet { points: points.iter().copied().chain(reflected).collect(), faces: [faces, back].concat() }
}
