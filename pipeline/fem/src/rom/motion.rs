//! What a motion of a reduced model is integrated under.

use materials::Relaxation;
use si::{Pascal, Second};

use crate::dynamics::settings::DynamicSettings;

/// Actuation at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuation {
    /// One per chamber, Pa.
    pub pressures: Vec<Pascal>,
}

/// A motion of a reduced model from rest.
#[derive(Clone, Copy)]
pub struct ReducedMotion<'a> {
    /// How it is integrated; the tolerance is the reduced model's own.
    pub settings: &'a DynamicSettings,
    /// Factor of the moduli, one per region.
    pub modulus_scale: &'a [f64],
    /// Relaxation of the shear part, one per region; empty: none.
    pub relaxation: &'a [Relaxation],
    /// C₂₀/C₁₀ and C₃₀/C₁₀, one pair per region; empty: those of the system that was reduced.
    pub stiffening: &'a [[f64; 2]],
    /// Actuation at a time (s from the start).
    pub actuation: &'a dyn Fn(Second) -> Actuation,
}
