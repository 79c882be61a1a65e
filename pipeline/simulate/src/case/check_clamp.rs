//! Checks of clamps: where they hold, along which axes, and where they may move.

use lab::range::Checked;

use super::check_place::{FAR, check_place, check_vector};
use super::rule::require;
use super::{Axis, Case, Clamp, Place};

/// A clamp holds the nodes of a place, or of a surface of the mesh file.
pub(super) fn check_clamp(key: &str, clamp: &Clamp, case: &Case) -> Checked {
    match clamp.surface {
        None => check_place(key, Place::of(clamp.plane, clamp.block))?,
        Some(_) => {
            require(key, clamp.plane.is_none() && clamp.block.is_none(), "it has one of plane, box and surface")?
        }
    }
    require(&format!("{key}.hold"), !clamp.hold.is_empty(), "a clamp holds along at least one axis")?;
    check_displacement(key, clamp, case)
}

/// A clamp moves its nodes along the axes that it holds, in equilibria of single levels: motions hold clamps at rest, and paths follow loads.
fn check_displacement(key: &str, clamp: &Clamp, case: &Case) -> Checked {
    let name = |word: &str| format!("{key}.{word}");
    check_vector(&name("displacement"), &clamp.displacement, FAR, "m")?;
    let moves = |axis: Axis| clamp.displacement[axis as usize] != 0.0;
    let along_held = [Axis::X, Axis::Y, Axis::Z].into_iter().all(|axis| !moves(axis) || clamp.hold.contains(&axis));
    require(&name("displacement"), along_held, "a clamp moves along axes that it holds")?;
    let is_symmetric = !case.mesh.half || !moves(Axis::Z);
    require(
        &name("displacement"),
        is_symmetric,
        "a clamp of a half model does not move along z: that would break the symmetry",
    )?;
    let is_level_by_level = case.statics.as_ref().is_some_and(|set| set.arc_length.is_none());
    let rule = "clamps move in [static] without arc_length";
    require(&name("displacement"), is_level_by_level || !clamp.is_displaced(), rule)?;
    let rule = "a clamp's force is written of [static] without arc_length";
    require(&name("name"), is_level_by_level || clamp.name.is_none(), rule)
}
