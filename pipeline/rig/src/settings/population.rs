//! Settings of a population: what differs between its specimens beyond what every specimen's own seed draws.

use serde::Deserialize;
use si::{Metre, Pascal};

/// Ranges from which a population is drawn; casting, clocks, lens, surface and runs follow from each specimen's seed as always.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// The specimen whose shape, marks and levels all have.
    pub like: String,
    /// Of the silicone at its modulus time, Pa.
    pub youngs_modulus: [Pascal; 2],
    /// Factor of the coefficients of stiffening, no unit.
    pub stiffening: [f64; 2],
    /// Factor of the strength of every branch, no unit.
    pub branch_factor: [f64; 2],
    /// The strength of a branch of time τ is multiplied by (τ / 1 s) to this power: the slope of the loss factor over frequency.
    pub branch_slope: [f64; 2],
    /// Of the sheet, Pa.
    pub sheet_youngs_modulus: [Pascal; 2],
    /// Added mass relative to elongated-body theory's, no unit.
    pub added: [f64; 2],
    /// Normal drag coefficient, no unit.
    pub drag: [f64; 2],
    /// Factor of every time of the valve, no unit.
    pub valve: [f64; 2],
    /// Greatest displacement of the camera along each axis, m.
    pub camera_shift: Metre,
    /// Greatest rotation of the camera about each axis, degrees.
    pub camera_turn: f64,
}
