//! Checks of surfaces: each is closed and of a plausible size; together they form one body with chambers and markers as on the card.

use lab::card;
use mesh::Surface;
use si::Metre;

use super::Project;
use super::finding::Finding;
use diagnostics::{Result, input};
use records::subject::Specimen;
use study::stages::mesh::{Mesh, Settings};
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// Largest factor between a body's longest side and the card's length: only the former includes the clamped part.
const APART: f64 = 2.5;

/// Checks each surface; where both are valid, also that they can be meshed together.
///
/// # Errors
/// A diagnostic when the settings of the mesh are invalid.
pub(crate) fn surface_findings(project: &Project, specimen: &Specimen) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (solid, file) in STL.iter().filter_map(|solid| Some((*solid, specimen.card.solid.file(solid)?))) {
        let surface = closed_surface(project, specimen, file, &mut findings);
        if let Some(body) = surface.filter(|_| solid == card::BODY) {
            findings.extend(size_mismatch(project, specimen, (file, body.length())));
            findings.extend(clamp_mismatch(project, specimen, &body));
        }
    }
    let is_incomplete =
        specimen.card.solid.files().iter().any(|(_, file)| !project.file_path(&specimen.card.name, file).is_file());
    if findings.is_empty() && !is_incomplete {
        let settings = project.settings.section::<Settings>("mesh")?;
        let raw = Mesh::raw(specimen);
        let meshed = Mesh::run(&Part::part_of(specimen), &settings, (), &inspection_context(project.folders, &raw));
        findings.extend(meshed.err().map(|diagnostic| Finding::from(diagnostic.while_doing(&specimen.card.name))));
    }
    Ok(findings)
}

/// The solids that are made from STL files.
const STL: [&str; 2] = [card::BODY, card::SPINE];

/// A closed surface, m; a missing file is reported with the card.
fn closed_surface(project: &Project, specimen: &Specimen, file: &str, findings: &mut Vec<Finding>) -> Option<Surface> {
    let surface_path = project.display_path(&specimen.card.name, file);
    let message = |e: &dyn std::fmt::Display| Finding::message(&format!("{surface_path}: {e}"));
    let bytes = input::read(&project.file_path(&specimen.card.name, file), input::MESH).ok()?;
    match mesh::stl::read(&bytes, specimen.card.solid.unit.metres()) {
        Err(e) => findings.push(message(&e)),
        Ok(surface) => match surface.shells() {
            Err(e) => findings.push(message(&e)),
            Ok(_) => return Some(surface),
        },
    }
    None
}

fn size_mismatch(project: &Project, specimen: &Specimen, (file, body_length): (&str, Metre)) -> Option<Finding> {
    let (card, solid) = (&specimen.card, &specimen.card.solid);
    let factor = (body_length / card.length).max(card.length / body_length);
    (factor > APART).then(|| {
        let surface_path = project.display_path(&card.name, file);
        let defect =
            format!("{surface_path}: the body is {body_length:.4} m long, the card's length is {} m", card.length);
        let reason = format!("they differ by a factor of {factor:.1}; the file was read in {}", solid.unit.word());
        Finding::fix(defect, reason, "correct unit under [solid], or length, on the card")
    })
}

/// A clamp that constrains nothing or everything.
fn clamp_mismatch(project: &Project, specimen: &Specimen, body: &Surface) -> Option<Finding> {
    let (low, high) = body.bounds();
    let clamp_x = specimen.card.clamp.below_x?;
    (!(low[0]..high[0]).contains(&clamp_x)).then(|| {
        let constrained = if clamp_x < low[0] { "nothing" } else { "everything" };
        let card_path = project.display_path(&specimen.card.name, lab::folder::CARD);
        let reason = format!("the body reaches from x = {:.4} to {:.4} m", low[0], high[0]);
        let action = "give the x at which the holder ends, m in the frame of the STL files";
        Finding::fix(format!("{card_path}: clamp.below_x = {clamp_x} m constrains {constrained}"), reason, action)
    })
}
