//! Mesh: tetrahedra with regions, chambers and marker points from two surfaces. Paper: section V, the STL export.

use lab::card::LengthUnit;
use mesh::{QuadraticMesh, Report, Spot, Surface};
use serde::{Deserialize, Serialize};
use si::{Metre, Point3};
use std::path::Path;

use crate::records::{self, Cavity, Quality};
use crate::subject::Specimen;
use ::mesh::chamber_at;
use diagnostics::{Diagnostic, Result};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

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

/// What it reads of the card.
#[derive(Debug, Clone, Serialize)]
pub struct Card {
    unit: LengthUnit,
    chambers: Vec<Point>,
    markers: Vec<Point>,
}

/// A named point of the card, m.
#[derive(Debug, Clone, Serialize)]
struct Point {
    name: String,
    at: Point3,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        let card = &of.card;
        Self {
            unit: card.solid.unit,
            chambers: card.chamber.iter().map(|c| Point { name: c.name.clone(), at: c.at }).collect(),
            markers: card.marker.iter().map(|m| Point { name: m.name.clone(), at: m.at }).collect(),
        }
    }
}

impl Stage for Mesh {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::Mesh;
    const DESCRIPTION: &'static str = "two surfaces are meshed by tetrahedra, with chambers and markers";
    const VERSION: u32 = 1;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let (name, solid) = (&of.card.name, &of.card.solid);
        vec![RawFile::new("body", name, &solid.body.file), RawFile::new("spine", name, &solid.spine.file)]
    }

    fn run(card: &Self::Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::Mesh> {
        context.progress(0.1, "meshing");
        let mesher = ::mesh::Settings { use_symmetry: set.use_symmetry, ..::mesh::Settings::new(set.edge) };
        made(card, &mesher, set.marker_distance_limit, context)
    }
}

/// A specimen's mesh; a marker may lie so far (m) from the skin.
///
/// # Errors
/// A [`Diagnostic`] when a surface cannot be read or meshed, or the card names a chamber or marker that is not there.
pub fn made(
    card: &Card,
    by: &::mesh::Settings,
    marker_limit: Metre,
    context: &dyn StageContext,
) -> Result<records::Mesh> {
    let (body, spine) = (surface(card, "body", context)?, surface(card, "spine", context)?);
    let (linear, report) = ::mesh::mesh(&body, &spine, by).map_err(|e| {
        let [body, spine] = ["body", "spine"].map(|word| context.display_path(word));
        Diagnostic::from(e).while_doing(format!("{body} with {spine}"))
    })?;
    let solid = ::mesh::quadratic(&linear);
    let chambers = chambers(card, &solid, &report)?;
    let (markers, marker_distance_m) = embed_markers(card, &solid, marker_limit)?;
    let quality = quality(&solid, &report, marker_distance_m);
    Ok(records::Mesh { solid, chambers, markers, quality })
}

fn surface(card: &Card, word: &str, context: &dyn StageContext) -> Result<Surface> {
    let read = ::mesh::stl::read(&context.bytes(word)?, card.unit.metres());
    read.map_err(|e| Diagnostic::from(e).in_file(Path::new(&context.display_path(word))))
}

fn chambers(card: &Card, solid: &QuadraticMesh, report: &Report) -> Result<Vec<Cavity>> {
    card.chambers.iter().map(|chamber| cavity(chamber, solid, report)).collect()
}

fn cavity(chamber: &Point, solid: &QuadraticMesh, report: &Report) -> Result<Cavity> {
    match chamber_at(solid, chamber.at) {
        Some(skin) => {
            let volume_m3 = report.chambers[usize::from(skin)].volume;
            Ok(Cavity { name: chamber.name.clone(), skin, volume_m3 })
        }
        None => Err(Diagnostic::new(
            format!("chamber `{}` is not where the card says, at {}", chamber.name, millimetres(chamber.at)),
            format!("the body has {} closed cavities and none holds that point", report.chambers.len()),
            format!("give a point inside one; their centres are {}", centres(report)),
        )),
    }
}

fn centres(report: &Report) -> String {
    report.chambers.iter().map(|c| millimetres(c.centroid)).collect::<Vec<_>>().join("; ")
}

fn embed_markers(card: &Card, solid: &QuadraticMesh, limit: Metre) -> Result<(Vec<Spot>, Metre)> {
    let (mut spots, mut worst) = (Vec::new(), 0.0_f64);
    for marker in &card.markers {
        let (spot, distance) = ::mesh::embed(solid, marker.at);
        if distance > limit {
            return Err(Diagnostic::new(
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
        dofs: 3 * solid.nodes.len(),
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
