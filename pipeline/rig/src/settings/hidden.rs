//! Ranges of the hidden properties of a specimen and of a run.

use serde::Deserialize;
use si::{Hertz, KilogramPerCubicMetre, Metre, Pascal, Second};

/// A material: the ranges of its true properties, and the nominal properties for the card.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Seed of its properties, which are the same for all specimens.
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
    /// The properties on the card.
    pub nominal: Nominal,
}

/// Properties of a solid on the card.
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

/// Deviations of a casting from its STL files.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Casting {
    /// Greatest relative difference of the outer walls from their nominal thickness, one thicker and one thinner, no unit.
    pub asymmetry: f64,
    /// Standard deviation of a marker's position along and across, m.
    pub markers_off: Metre,
}

/// Variations between runs.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Causes {
    /// Greatest relative error of the regulated pressure in a run, no unit.
    pub supply: f64,
    /// Greatest timing error of each switching of the valve, s.
    pub jitter: Second,
    /// Greatest relative change of the silicone's modulus with temperature in a run, no unit.
    pub warmth: f64,
    /// Change of the camera's pose between runs.
    pub nudge: PosePerturbation,
}

/// Change of the camera's pose when it is started.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PosePerturbation {
    /// Greatest translation along each axis, m.
    pub shift: Metre,
    /// Greatest rotation about each axis, degrees.
    pub turn: f64,
}

/// The water around the tail, as ranges.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Added mass relative to elongated-body theory's, no unit.
    pub added: [f64; 2],
    /// Normal drag coefficient, no unit.
    pub drag: [f64; 2],
}
