//! The family of materials: every law that a card can name.
//!
//! Stands on: the contract in `material.rs` and its members. Never knows: which region is made of what.

mod corotated;
mod linear;
mod neo_hookean;

#[cfg(test)]
mod conformance;

pub(crate) use corotated::turn_of;

use crate::material::Material;

/// All laws; the conformance suite walks this list.
pub const ALL: &[&dyn Material] = &[&corotated::Corotated, &neo_hookean::NeoHookean, &linear::Linear];

/// The law called `name`, as cards write it: `corotated`, `neo_hookean` or `linear`.
pub fn by_name(name: &str) -> Option<&'static dyn Material> {
    ALL.iter().copied().find(|law| law.name() == name)
}
