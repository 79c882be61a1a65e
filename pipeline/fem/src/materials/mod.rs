//! Constitutive laws, listed in [`ALL`]; the contract is [`Material`].

mod corotated;
mod linear;
mod neo_hookean;
mod yeoh;

#[cfg(test)]
mod conformance;

pub(crate) use corotated::polar_rotation;

use crate::material::Material;

/// All laws. The conformance tests run on each.
pub const ALL: &[&dyn Material] = &[&corotated::Corotated, &neo_hookean::NeoHookean, &yeoh::Yeoh, &linear::Linear];

/// The law called `name`, as cards and cases write it.
pub fn by_name(name: &str) -> Option<&'static dyn Material> {
    ALL.iter().copied().find(|law| law.name() == name)
}
