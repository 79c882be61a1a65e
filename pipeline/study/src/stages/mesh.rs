//! Mesh: two surfaces become tetrahedra with regions, chambers and marker points. Paper: section V, the STL export.
//!
//! Stands on: shape. Never knows: how the actuator was designed; it sees the surfaces alone.

use lab::card::{Card, Chamber};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use shape::{QuadraticMesh, Report, Spot, Surface};
use si::{Metre, Point3};

use crate::fault::{Fault, Outcome};
use crate::model::chamber_at;
use crate::records::{self, Cavity, Quality};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Mesh;

/// `[mesh]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Target length of an edge, m.
    edge: Metre,
    /// Whether a solid symmetric about z = 0 is meshed by its half.
    use_symmetry: bool,
    /// How far a marker on the card may lie from the skin, m.
    marker_distance_limit: Metre,
}

impl Stage for Mesh {
    type Settings = Settings;
    type Needs = ();
    type Makes = records::Mesh;
    const STORY: &'static str = "two surfaces become tetrahedra with chambers and marks";
    const EDITION: u32 = 1;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let (name, solid) = (&of.card.name, &of.card.solid);
        vec![RawFile::new("body", name, &solid.body.file), RawFile::new("spine", name, &solid.spine.file)]
    }

    fn card(of: &Specimen) -> Value {
        let card = &of.card;
        json!({
            "unit": card.solid.unit.word(),
            "chambers": card.chamber.iter().map(|c| json!([c.name, c.at])).collect::<Vec<_>>(),
            "markers": card.marker.iter().map(|m| m.at).collect::<Vec<_>>(),
        })
    }

    fn run(of: &Specimen, set: &Settings, (): (), desk: &dyn Desk) -> Outcome<records::Mesh> {
        desk.progress(0.1, "meshing");
        let mesher = shape::Settings { use_symmetry: set.use_symmetry, ..shape::Settings::new(set.edge) };
        made(&of.card, &mesher, set.marker_distance_limit, desk)
    }
}

/// A specimen's mesh; a marker may lie so far (m) from the skin.
///
/// # Errors
/// A [`Fault`] when a surface cannot be read or meshed, or the card names a chamber or marker that is not there.
pub fn made(card: &Card, by: &shape::Settings, marker_limit: Metre, desk: &dyn Desk) -> Outcome<records::Mesh> {
    let (body, spine) = (surface(card, "body", desk)?, surface(card, "spine", desk)?);
    let (linear, report) = shape::mesh(&body, &spine, by).map_err(Fault::from_tool)?;
    let solid = shape::quadratic(&linear);
    let chambers = chambers(card, &solid, &report)?;
    let (markers, marker_distance_m) = embed_markers(card, &solid, marker_limit)?;
    let quality = quality(&solid, &report, marker_distance_m);
    Ok(records::Mesh { solid, chambers, markers, quality })
}

fn surface(card: &Card, word: &str, desk: &dyn Desk) -> Outcome<Surface> {
    let read = shape::stl::read(&desk.bytes(word)?, card.solid.unit.metres());
    read.map_err(|e| Fault::from_tool(format!("{}: {e}", desk.place(word))))
}

fn chambers(card: &Card, solid: &QuadraticMesh, report: &Report) -> Outcome<Vec<Cavity>> {
    card.chamber.iter().map(|chamber| cavity(chamber, solid, report)).collect()
}

fn cavity(chamber: &Chamber, solid: &QuadraticMesh, report: &Report) -> Outcome<Cavity> {
    match chamber_at(solid, chamber.at) {
        Some(skin) => {
            let volume_m3 = report.chambers[usize::from(skin)].volume;
            Ok(Cavity { name: chamber.name.clone(), skin, volume_m3 })
        }
        None => Err(Fault::new(
            format!("chamber `{}` is not where the card says, at {}", chamber.name, millimetres(chamber.at)),
            format!("the body has {} closed cavities and none holds that point", report.chambers.len()),
            format!("give a point inside one; their centres are {}", centres(report)),
        )),
    }
}

fn centres(report: &Report) -> String {
    report.chambers.iter().map(|c| millimetres(c.centroid)).collect::<Vec<_>>().join("; ")
}

fn embed_markers(card: &Card, solid: &QuadraticMesh, limit: Metre) -> Outcome<(Vec<Spot>, Metre)> {
    let (mut spots, mut worst) = (Vec::new(), 0.0_f64);
    for marker in &card.marker {
        let (spot, distance) = shape::embed(solid, marker.at);
        if distance > limit {
            return Err(Fault::new(
                format!("marker `{}` at {} is not on the skin", marker.name, millimetres(marker.at)),
                format!(
                    "it lies {:.2} mm off; the limit is {:.2} mm (study.toml, [mesh] marker_distance_limit)",
                    1e3 * distance,
                    1e3 * limit
                ),
                "correct its place on the card: metres, in the frame of the STL files",
            ));
        }
        spots.push(spot);
        worst = worst.max(distance);
    }
    Ok((spots, worst))
}

fn quality(solid: &QuadraticMesh, report: &Report, marker_distance_m: Metre) -> Quality {
    let error = |mesh: f64, stl: f64| mesh / stl - 1.0;
    Quality {
        freedoms: 3 * solid.nodes.len(),
        half: solid.half,
        min_dihedral_deg: report.min_dihedral_deg,
        hausdorff_m: report.hausdorff_m,
        volume_error: [
            error(report.volume_body, report.volume_body_stl),
            error(report.volume_spine, report.volume_spine_stl),
        ],
        marker_distance_m,
    }
}

fn millimetres(at: Point3) -> String {
    format!("({:.2}, {:.2}, {:.2}) mm", 1e3 * at[0], 1e3 * at[1], 1e3 * at[2])
}
