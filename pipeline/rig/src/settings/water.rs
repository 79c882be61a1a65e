//! `[water]`: the surface that a camera looks through.
//!
//! Stands on: `si`. Never knows: how light is bent.

use serde::Deserialize;
use si::{Metre, Radian};

/// The water over the tail.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// z of the surface as a laboratory measures it, m.
    pub surface: Metre,
    /// How much higher it truly stands, m.
    pub surface_error: [Metre; 2],
    /// Refractive index, no unit.
    pub index: f64,
    /// Root of the mean squared slope of the ripples, rad.
    pub ripple: [Radian; 2],
    /// Lengths of their waves, m.
    pub wavelength: [Metre; 2],
    /// Soft reflections that wander with the ripples.
    pub glints: usize,
    /// How bright each is, grey levels.
    pub glint: [f64; 2],
    /// How wide each is, px, standard deviation.
    pub glint_size: [f64; 2],
}
