//! Bruce: Nemo's shape in the stiffer silicone.
//!
//! Stands on: Nemo's shape. Never knows: its own hidden moduli.

use super::nemo;
use crate::specimen::Specimen;

/// The third specimen.
pub const BRUCE: Specimen = Specimen { name: "bruce", tail: nemo::tail };
