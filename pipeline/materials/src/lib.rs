//! Constitutive laws at one point of a body: hyperelastic energies, their relaxation, and their tangents.
//!
//! A law ([`Material`]) is an energy of the deformation gradient, linear in its [`Moduli`]; all are listed in [`ALL`]. [`Relaxation`] adds
//! Maxwell branches to any objective law; [`step`] advances them by one time step, with derivatives. [`tangent`] holds the kinds of tangent
//! that Newton's method assembles.
//!
//! ```
//! use materials::{Moduli, Relaxation, Springpot, by_name};
//! use nalgebra::Matrix3;
//!
//! let rubber = by_name("neo_hookean").ok_or("no such law")?;
//! let (energy, stress) = rubber.energy_and_stress(&Matrix3::identity(), Moduli::of(2e5, 0.45));
//! assert!(energy == 0.0 && stress.norm() == 0.0);
//!
//! let silicone = Relaxation::springpot(Springpot { strength: 0.06, exponent: 0.27, decades: [-3, 1] })?;
//! assert!(silicone.modulus(0.01) > silicone.modulus(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Depends on `si`, nalgebra and thiserror.

mod corotated;
mod linear;
mod lopez_pamies;
pub mod material;
mod neo_hookean;
mod ogden;
mod power_pair;
pub mod relaxation;
pub mod step;
mod stretch;
pub mod symmetric;
pub mod tangent;
mod yeoh;

#[cfg(test)]
mod conformance;
#[cfg(test)]
mod relaxation_tests;

pub use corotated::polar_rotation;
pub use material::{Material, Moduli};
pub use relaxation::{Branch, MAX_BRANCHES, Relaxation, RelaxationError, Springpot};

/// All laws. The conformance tests run on each.
pub const ALL: &[&dyn Material] = &[
    &corotated::Corotated,
    &neo_hookean::NeoHookean,
    &yeoh::Yeoh,
    &lopez_pamies::LopezPamies,
    &power_pair::MODERATE,
    &power_pair::STEEP,
    &power_pair::STEEPEST,
    &ogden::Ogden,
    &linear::Linear,
];

/// The law called `name`, as cards and cases write it.
pub fn by_name(name: &str) -> Option<&'static dyn Material> {
    ALL.iter().copied().find(|law| law.name() == name)
}
