//! Surfaces: each closed and of a plausible size, both one body, chambers and marks where the card says.
//!
//! Stands on: shape, the stage mesh. Never knows: a film.

use shape::Surface;
use si::Metre;

use super::Look;
use super::finding::Finding;
use crate::fault::Outcome;
use crate::runner;
use crate::stage::Stage;
use crate::stages::mesh::{Mesh, Settings};
use crate::subject::Specimen;

/// A body's longest side and the card's length may differ by this factor either way: the clamped part counts in one alone.
const APART: f64 = 2.5;

/// Each surface for itself; where both are sound, what the mesher says of them together.
///
/// # Errors
/// A fault when the settings of the mesh cannot be understood.
pub fn look(look: &Look, of: &Specimen) -> Outcome<Vec<Finding>> {
    let solid = &of.card.solid;
    let mut found = Vec::new();
    let body = surface(look, of, &solid.body.file, &mut found);
    let spine = surface(look, of, &solid.spine.file, &mut found);
    if let Some(body) = &body {
        found.extend(size(look, of, body.length()));
        found.extend(clamped(look, of, body));
    }
    if body.is_some() && spine.is_some() && found.is_empty() {
        let set = look.settings.section::<Settings>("mesh")?;
        let raw = Mesh::raw(of);
        let meshed = Mesh::run(of, &set, (), &runner::desk(look.folders, &raw));
        found.extend(meshed.err().map(|fault| Finding::said(&format!("{}: {}", of.card.name, fault.what))));
    }
    Ok(found)
}

/// A closed surface, m; a file that is not there was named with the card.
fn surface(look: &Look, of: &Specimen, file: &str, found: &mut Vec<Finding>) -> Option<Surface> {
    let place = look.place(&of.card.name, file);
    let bytes = std::fs::read(look.path(&of.card.name, file)).ok()?;
    let said = |e: &dyn std::fmt::Display| Finding::said(&format!("{place}: {e}"));
    match shape::stl::read(&bytes, of.card.solid.unit.metres()) {
        Err(e) => found.push(said(&e)),
        Ok(surface) => match surface.shells() {
            Err(e) => found.push(said(&e)),
            Ok(_) => return Some(surface),
        },
    }
    None
}

fn size(look: &Look, of: &Specimen, long: Metre) -> Option<Finding> {
    let (card, solid) = (&of.card, &of.card.solid);
    let factor = (long / card.length).max(card.length / long);
    (factor > APART).then(|| {
        let place = look.place(&card.name, &solid.body.file);
        let what = format!("{place}: the body is {long:.4} m long, the card's length is {} m", card.length);
        let why = format!("they differ by a factor of {factor:.1}; the file was read in {}", solid.unit.word());
        Finding::mend(what, why, "correct unit under [solid], or length, on the card")
    })
}

/// A clamp that holds nothing or everything.
fn clamped(look: &Look, of: &Specimen, body: &Surface) -> Option<Finding> {
    let (low, high) = body.bounds();
    let at = of.card.clamp.below_x;
    (!(low[0]..high[0]).contains(&at)).then(|| {
        let held = if at < low[0] { "nothing" } else { "everything" };
        let place = look.place(&of.card.name, lab::folder::CARD);
        let why = format!("the body reaches from x = {:.4} to {:.4} m", low[0], high[0]);
        let act = "give the x at which the holder ends, m in the frame of the STL files";
        Finding::mend(format!("{place}: clamp.below_x = {at} m holds {held}"), why, act)
    })
}
