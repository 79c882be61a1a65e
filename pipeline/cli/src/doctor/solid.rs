//! Checks of surfaces: each is closed and of a plausible size; together they form one body with chambers and markers as on the card.

use lab::card;
use mesh::Surface;
use si::Metre;

use super::Look;
use super::finding::Finding;
use diagnostics::{Result, input};
use study::stages::mesh::{Mesh, Settings};
use study::subject::Specimen;
use workflow::runner::inspection_context;
use workflow::stage::Stage;
use workflow::subject::Part;

/// Largest factor between a body's longest side and the card's length: only the former includes the clamped part.
const APART: f64 = 2.5;

/// Checks each surface; where both are valid, also that they can be meshed together.
///
/// # Errors
/// A diagnostic when the settings of the mesh are invalid.
pub fn look(look: &Look, of: &Specimen) -> Result<Vec<Finding>> {
    let mut found = Vec::new();
    for (word, file) in STL.iter().filter_map(|word| Some((*word, of.card.solid.file(word)?))) {
        let surface = surface(look, of, file, &mut found);
        if let Some(body) = surface.filter(|_| word == card::BODY) {
            found.extend(size(look, of, (file, body.length())));
            found.extend(clamped(look, of, &body));
        }
    }
    let absent = of.card.solid.files().iter().any(|(_, file)| !look.path(&of.card.name, file).is_file());
    if found.is_empty() && !absent {
        let set = look.settings.section::<Settings>("mesh")?;
        let raw = Mesh::raw(of);
        let meshed = Mesh::run(&Part::part_of(of), &set, (), &inspection_context(look.folders, &raw));
        found.extend(meshed.err().map(|diagnostic| Finding::from(diagnostic.while_doing(&of.card.name))));
    }
    Ok(found)
}

/// The solids that are made from STL files.
const STL: [&str; 2] = [card::BODY, card::SPINE];

/// A closed surface, m; a missing file is reported with the card.
fn surface(look: &Look, of: &Specimen, file: &str, found: &mut Vec<Finding>) -> Option<Surface> {
    let place = look.place(&of.card.name, file);
    let message = |e: &dyn std::fmt::Display| Finding::message(&format!("{place}: {e}"));
    let bytes = input::read(&look.path(&of.card.name, file), input::MESH).ok()?;
    match mesh::stl::read(&bytes, of.card.solid.unit.metres()) {
        Err(e) => found.push(message(&e)),
        Ok(surface) => match surface.shells() {
            Err(e) => found.push(message(&e)),
            Ok(_) => return Some(surface),
        },
    }
    None
}

fn size(look: &Look, of: &Specimen, (file, long): (&str, Metre)) -> Option<Finding> {
    let (card, solid) = (&of.card, &of.card.solid);
    let factor = (long / card.length).max(card.length / long);
    (factor > APART).then(|| {
        let place = look.place(&card.name, file);
        let what = format!("{place}: the body is {long:.4} m long, the card's length is {} m", card.length);
        let why = format!("they differ by a factor of {factor:.1}; the file was read in {}", solid.unit.word());
        Finding::fix(what, why, "correct unit under [solid], or length, on the card")
    })
}

/// A clamp that constrains nothing or everything.
fn clamped(look: &Look, of: &Specimen, body: &Surface) -> Option<Finding> {
    let (low, high) = body.bounds();
    let at = of.card.clamp.below_x?;
    (!(low[0]..high[0]).contains(&at)).then(|| {
        let held = if at < low[0] { "nothing" } else { "everything" };
        let place = look.place(&of.card.name, lab::folder::CARD);
        let why = format!("the body reaches from x = {:.4} to {:.4} m", low[0], high[0]);
        let act = "give the x at which the holder ends, m in the frame of the STL files";
        Finding::fix(format!("{place}: clamp.below_x = {at} m constrains {held}"), why, act)
    })
}
