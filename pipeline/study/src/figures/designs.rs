//! Figure `designs`: the specimens cut open at mid height, beside each other at one scale. Paper, figure 3.
//!
//! Drawn from the meshes of their STL files, whose surfaces they follow; the properties of card and mesh are printed under each.

use plot::{DOUBLE_COLUMN_MM, Figure, OverlayKind, Paint, Panel, Placed, Scene, Side, palette};
use si::{MILLIMETRE, ModulusUnit, Pascal, Point3};

use super::order::{capitalised, in_order};
use super::origin_note;
use diagnostics::{Diagnostic, Result};
use records::Mesh;
use records::subject::{Specimen, Study};
use sysid::surfaces::{Bounds, Surfaces};
use workflow::figure;
use workflow::needs::Every;

/// The figure.
pub struct Designs;

/// Panels in a row.
const ACROSS: usize = 3;

impl figure::Figure for Designs {
    type Of = Study;
    type Needs = Every<Mesh, Specimen>;
    const NAME: &'static str = "designs";
    const CAPTION: &'static str = "the actuators cut open: their chambers, ribs, walls and sheet";
    const VERSION: u32 = 4;

    fn draw(Every(meshes): Self::Needs) -> Result<Figure> {
        if meshes.is_empty() {
            return Err(Diagnostic::new("there is no design to show", "no specimen has a mesh", "study run mesh"));
        }
        let meshes = in_order(meshes);
        let window = common_window(meshes.iter().map(|(_, mesh)| mesh));
        let mut figure = Figure::new(DOUBLE_COLUMN_MM);
        for row in meshes.chunks(ACROSS) {
            figure =
                figure.row(52.0, row.iter().map(|(s, mesh)| design_panel(s, mesh, window)).collect::<Vec<Placed>>());
        }
        Ok(figure.noted(&origin_note(meshes.iter().map(|(s, _)| s.card.as_ref()))))
    }
}

/// Two corners of a box around all solids, so that they are drawn at one scale.
fn common_window<'a>(meshes: impl Iterator<Item = &'a Mesh>) -> [Point3; 2] {
    let nodes = meshes.flat_map(|m| m.solid.nodes.iter().copied());
    let [low, high] = nodes.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [[0, 1, 2].map(|k| p[k].min(low[k])), [0, 1, 2].map(|k| p[k].max(high[k]))]
    });
    let tall = high[2].max(-low[2]);
    [[low[0], low[1], -tall], [high[0], high[1], 0.0]]
}

fn design_panel(specimen: &Specimen, mesh: &Mesh, [low, high]: [Point3; 2]) -> Placed {
    let lower = Surfaces::lower_half(&mesh.solid, &mesh.solid.nodes);
    let silicone = silicone_colour(&specimen.card);
    let painted = |bounds: Bounds| match bounds {
        Bounds::Body | Bounds::CutBody => Some(Paint::Solid(silicone)),
        other => other.painted(),
    };
    let scene = lower.add_to(Scene::new(super::CUT_VIEW), painted);
    // all corners of the box count, not two alone: the view rotates it
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
    let rim = (0..8).map(corner).collect();
    let card = &specimen.card;
    let text = [
        format!("nominal E: {}", card.solid.parts.iter().map(nominal_modulus).collect::<Vec<_>>().join(", ")),
        format!("air: {}", chamber_volumes(mesh)),
    ];
    let text_place = |down: f64| [0.5 * (low[0] + high[0]), low[1], low[2] - down];
    let scene = scene
        .with_overlay(rim, OverlayKind::Line(plot::Dash::Solid), palette::PAPER, 0.0)
        .with_overlay(vec![text_place(0.006)], OverlayKind::Text(text[0].clone(), Side::Below), palette::BLACK, 6.0)
        .with_overlay(vec![text_place(0.013)], OverlayKind::Text(text[1].clone(), Side::Below), palette::BLACK, 6.0)
        .with_scale_bar(20.0 * MILLIMETRE);
    Panel::Scene(scene).titled(&capitalised(&card.name))
}

/// Modulus that is painted twice as dark as none, Pa.
const DARK: Pascal = 1e6;

/// The colour of the softest solid: the stiffer, the darker.
fn silicone_colour(card: &lab::Card) -> plot::Colour {
    let lowest = card.solid.parts.iter().map(|part| part.solid.youngs_modulus).fold(f64::INFINITY, f64::min);
    palette::BODY.towards(palette::BLACK, 0.5 * (lowest / DARK).min(1.0))
}

/// The nominal modulus of a solid.
fn nominal_modulus(lab::card::Part { name, solid }: &lab::card::Part) -> String {
    let ModulusUnit { scale, unit } = ModulusUnit::of(solid.youngs_modulus);
    format!("{name} {:.2} {unit}", scale * solid.youngs_modulus)
}

/// The volume of each chamber.
fn chamber_volumes(mesh: &Mesh) -> String {
    let chamber_text = |c: &records::Cavity| format!("{} {:.1} ml", c.name, 1e6 * c.volume_m3);
    mesh.chambers.iter().map(chamber_text).collect::<Vec<_>>().join(", ")
}
