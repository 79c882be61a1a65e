//! Mesh: hexahedra or tetrahedra with regions, chambers and marker points, from surfaces or from a mesh file. Paper: section V, the STL export.

use lab::card::{self, LengthUnit};
use mesh::Surface;
use serde::{Deserialize, Serialize};
use si::{Metre, Point3};
use std::path::Path;

use ::mesh::{ElementChoice, ElementName, Grading, Method, foreign};
use diagnostics::{Diagnostic, Result};
use records::subject::Specimen;
use records::{self, Cavity, Quality};
use sysid::{Meshed, NamedRegion};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Mesh;

/// `[mesh]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Which elements a body of surfaces gets; tetrahedra where it is not said.
    #[serde(default)]
    elements: ElementName,
    /// How tetrahedra are made; in columns where it is not said.
    #[serde(default)]
    method: Method,
    /// Target length of an edge of tetrahedra, m.
    edge: Metre,
    /// Whether a solid symmetric about z = 0 is meshed by its half.
    use_symmetry: bool,
    /// How far a marker on the card may lie from the skin, m.
    marker_distance_limit: Metre,
}

/// How surfaces are meshed.
pub(super) struct Mesher {
    pub settings: ::mesh::Settings,
    pub elements: ElementChoice,
}

/// What it reads of the card.
#[derive(Debug, Clone, Serialize)]
pub struct Card {
    unit: LengthUnit,
    solids: Vec<NamedRegion>,
    /// Whether there is a mesh file in place of surfaces.
    meshed: bool,
    chambers: Vec<Point>,
    markers: Vec<Mark>,
    /// The surface of the mesh that is clamped, where the card names one.
    clamped: Option<String>,
    /// Whether a trial drives a chamber on one side of z = 0 without that on the other: no half is then meshed.
    sided: bool,
}

impl Card {
    /// Whether the body is given by surfaces, which can be meshed anew.
    pub(super) fn has_surfaces(&self) -> bool {
        !self.meshed
    }

    /// How its surfaces are meshed with edges of some length (m): by half only where both sides move alike.
    fn mesher(&self, edge: Metre, use_symmetry: bool, elements: ElementChoice) -> Mesher {
        let use_symmetry = use_symmetry && !self.sided;
        // where columns are refused, the general method is the only one for finer or coarser meshes of the same body, too
        let settings = ::mesh::Settings { use_symmetry, method: Method::Auto, ..::mesh::Settings::new(edge) };
        Mesher { settings, elements }
    }
}

/// A marker of the card.
#[derive(Debug, Clone, Serialize)]
struct Mark {
    name: String,
    /// Its place, m.
    at: Point3,
    /// m; none of a point.
    diameter: Option<Metre>,
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
            solids: NamedRegion::all(&card.solid),
            meshed: card.solid.mesh.is_some(),
            chambers: card.chamber.iter().map(|c| Point { name: c.name.clone(), at: c.at }).collect(),
            markers: card.marker.iter().map(Mark::of).collect(),
            clamped: card.clamp.surface.clone(),
            sided: is_sided(card),
        }
    }
}

impl Mark {
    fn of(marker: &card::Marker) -> Self {
        Self { name: marker.name.clone(), at: marker.at, diameter: marker.diameter }
    }
}

/// Whether a driven channel fills a chamber on one side of z = 0, and another channel one on the other side.
fn is_sided(card: &card::Card) -> bool {
    let driven = |c: &&card::Chamber| card.trial.iter().any(|t| t.experiment.channels().contains(&c.channel));
    let are_opposed = |a: &card::Chamber, b: &card::Chamber| a.at[2] * b.at[2] < 0.0 && a.channel != b.channel;
    card.chamber.iter().filter(driven).any(|a| card.chamber.iter().any(|b| are_opposed(a, b)))
}

impl Stage for Mesh {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::Mesh;
    const DESCRIPTION: &'static str = "elements with chambers and markers, from surfaces or from a mesh file";
    const VERSION: u32 = 3;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let (name, solid) = (&of.card.name, &of.card.solid);
        let raw = |word: &str, file: &str| RawFile::new(word, name, file);
        let Some(mesh) = &solid.mesh else {
            return [card::BODY, card::SPINE].iter().filter_map(|word| Some(raw(word, solid.file(word)?))).collect();
        };
        let nodes = foreign::nodes_of(Path::new(mesh));
        let nodes = nodes.and_then(|nodes| nodes.to_str().map(|nodes| raw("nodes", nodes)));
        std::iter::once(raw("mesh", mesh)).chain(nodes).collect()
    }

    fn run(card: &Self::Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::Mesh> {
        context.progress(0.1, "meshing");
        let mut mesher = card.mesher(set.edge, set.use_symmetry, set.elements.graded(Grading::COARSE));
        mesher.settings.method = set.method;
        specimen_mesh(card, &mesher, set.marker_distance_limit, context)
    }
}

/// A specimen's mesh; a marker may lie so far (m) from the skin.
///
/// # Errors
/// A [`Diagnostic`] when a surface cannot be read or meshed, or the card names a chamber or marker that is not there.
pub(super) fn specimen_mesh(
    card: &Card,
    mesher: &Mesher,
    marker_limit: Metre,
    context: &dyn StageContext,
) -> Result<records::Mesh> {
    let meshed_body = match card.meshed {
        true => read_mesh_file(card, context)?,
        false => mesh_surfaces(card, mesher, context)?,
    };
    let chambers = chamber_cavities(card, &meshed_body)?;
    let (markers, marker_distance_m) =
        meshed_body.markers(card.markers.iter().map(|m| (m.name.as_str(), m.at, m.diameter)), marker_limit)?;
    let clamped = card.clamped.as_deref().map_or(Ok(Vec::new()), |surface| meshed_body.clamped(surface))?;
    let quality = Quality {
        dofs: 3 * meshed_body.solid.nodes.len(),
        half: meshed_body.solid.half,
        min_dihedral_deg: meshed_body.min_dihedral_deg,
        hausdorff_m: meshed_body.hausdorff_m,
        volume_error: meshed_body.volume_error,
        not_hexahedra: meshed_body.not_hexahedra,
        marker_distance_m,
    };
    Ok(records::Mesh { solid: meshed_body.solid, chambers, markers, clamped, quality })
}

/// Largest distance of another mesh's skin from a marker, m: a coarse one lies farther off than the study's own.
pub(super) const MARKER_LIMIT: Metre = 3e-3;

/// A specimen's mesh in tetrahedra with edges of some length (m), halved where it is symmetric.
///
/// # Errors
/// As [`specimen_mesh`].
pub(super) fn with_edge(card: &Card, edge: Metre, context: &dyn StageContext) -> Result<records::Mesh> {
    specimen_mesh(card, &card.mesher(edge, true, ElementChoice::Tetrahedra), MARKER_LIMIT, context)
}

/// A specimen's mesh in hexahedra with cells shorter than those of the study by a factor, halved where it is symmetric; a body without a chamber is
/// divided as if it had a wall as thick as the edge (m).
///
/// # Errors
/// As [`specimen_mesh`]; also when the body cannot be divided into hexahedra.
pub(super) fn with_finer_cells(
    card: &Card,
    (edge, finer): (Metre, f64),
    context: &dyn StageContext,
) -> Result<records::Mesh> {
    let elements = ElementChoice::Hexahedra(Grading::COARSE.finer(finer));
    specimen_mesh(card, &card.mesher(edge, true, elements), MARKER_LIMIT, context)
}

fn mesh_surfaces(card: &Card, mesher: &Mesher, context: &dyn StageContext) -> Result<Meshed> {
    let body = read_surface(card, card::BODY, context)?;
    let sheet = card.solids.iter().any(|region| region.solid == card::SPINE);
    let spine = sheet.then(|| read_surface(card, card::SPINE, context)).transpose()?;
    Meshed::of_surfaces((&body, spine.as_ref()), &mesher.settings, mesher.elements, &card.solids).map_err(
        |diagnostic| {
            let body = context.display_path(card::BODY);
            let spine = sheet.then(|| format!(" with {}", context.display_path(card::SPINE)));
            diagnostic.while_doing(body + &spine.unwrap_or_default())
        },
    )
}

fn read_mesh_file(card: &Card, context: &dyn StageContext) -> Result<Meshed> {
    let mesh_path = context.display_path("mesh");
    let file = Path::new(&mesh_path);
    let nodes = foreign::nodes_of(file).map(|_| context.bytes("nodes")).transpose()?;
    let bytes = (&*context.bytes("mesh")?, nodes.as_deref());
    Meshed::of_file(file, bytes, card.unit.metres(), &card.solids).map_err(|diagnostic| diagnostic.in_file(file))
}

fn read_surface(card: &Card, word: &str, context: &dyn StageContext) -> Result<Surface> {
    let read = ::mesh::stl::read(&context.bytes(word)?, card.unit.metres());
    read.map_err(|e| Diagnostic::from(e).in_file(Path::new(&context.display_path(word))))
}

fn chamber_cavities(card: &Card, meshed_body: &Meshed) -> Result<Vec<Cavity>> {
    let cavity = |chamber: &Point| {
        let skin = meshed_body.chamber(&chamber.name, chamber.at)?;
        Ok(Cavity { name: chamber.name.clone(), skin, volume_m3: meshed_body.cavities[usize::from(skin)].volume })
    };
    card.chambers.iter().map(cavity).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tail of the tests with its chambers at these heights (m), of which channel `left` is driven.
    fn tail(heights: [Metre; 2]) -> card::Card {
        let mut card = card::parse(include_str!("../../tests/card.toml"), Path::new("card.toml")).unwrap();
        card.chamber.iter_mut().zip(heights).for_each(|(chamber, z)| chamber.at[2] = z);
        card
    }

    #[test]
    fn sides_move_apart_where_a_channel_fills_one_of_them_alone() {
        assert!(!is_sided(&tail([0.0, 0.0])) && !is_sided(&tail([0.01, 0.01])) && is_sided(&tail([0.01, -0.01])));
        let mut shared = tail([0.01, -0.01]);
        shared.chamber.iter_mut().for_each(|chamber| chamber.channel = "left".into());
        assert!(!is_sided(&shared));
        let mut still = tail([0.01, -0.01]);
        still.trial.clear();
        assert!(!is_sided(&still));
    }

    #[test]
    fn a_tail_whose_sides_move_apart_is_never_meshed_by_its_half() {
        let card = |heights| -> Card { Part::part_of(&Specimen { card: tail(heights).into() }) };
        let halved = |card: Card| {
            [true, false].map(|wanted| card.mesher(3e-3, wanted, ElementChoice::Tetrahedra).settings.use_symmetry)
        };
        assert_eq!(halved(card([0.0, 0.0])), [true, false]);
        assert_eq!(halved(card([0.01, -0.01])), [false, false]);
    }
}
