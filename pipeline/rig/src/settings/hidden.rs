//! What is hidden in a specimen and in a run, as ranges.
//!
//! Stands on: `si`. Never knows: what is drawn from its ranges.

use serde::Deserialize;
use si::{Hertz, KilogramPerCubicMetre, Metre, Pascal, Second};

/// A material, as ranges, and what a laboratory would write of it on a card.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Its properties are drawn from it, the same for all specimens.
    pub seed: u64,
    /// Constitutive law, by its name in `fem`.
    pub law: String,
    /// Pa.
    pub youngs_modulus: [Pascal; 2],
    /// No unit.
    pub poissons_ratio: [f64; 2],
    /// kg/m³, on the card as it is.
    pub density: KilogramPerCubicMetre,
    /// Damping ratio of a free ring-down, no unit.
    pub damping_ratio: [f64; 2],
    /// Frequency at which that ratio holds, Hz.
    pub ring_down: Hertz,
    /// The card's first guess.
    pub nominal: Nominal,
}

/// What the card says of a solid.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nominal {
    /// Pa.
    pub youngs_modulus: Pascal,
    /// No unit.
    pub poissons_ratio: f64,
    /// Pa.
    pub plausible: [Pascal; 2],
}

/// What a casting hides, and its STL files do not show.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Casting {
    /// Greatest share by which one outer wall is thicker and the other thinner, no unit.
    pub asymmetry: f64,
    /// Standard deviation of a marker's place along and across, m.
    pub markers_off: Metre,
}

/// Why no two runs are alike.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Causes {
    /// Greatest share by which the regulated pressure is off in a run, no unit.
    pub supply: f64,
    /// Greatest time by which the valve is early or late, each time it switches, s.
    pub jitter: Second,
    /// Greatest share by which the silicone is softer or stiffer in a run, no unit.
    pub warmth: f64,
    /// How far the camera is moved when it is started.
    pub nudge: Nudge,
}

/// What a hand does to a camera.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nudge {
    /// Greatest shift along each axis, m.
    pub shift: Metre,
    /// Greatest turn about each axis, degrees.
    pub turn: f64,
}

/// The water around the tail, as ranges.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Of the added mass of elongated-body theory, no unit.
    pub added: [f64; 2],
    /// Coefficient of drag across the flow, no unit.
    pub drag: [f64; 2],
}
