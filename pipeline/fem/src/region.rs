//! Regions: what each part of a body is made of.
//!
//! Stands on: `material`. Never knows: a mesh.

use crate::material::Material;
use si::{KilogramPerCubicMetre, Pascal};

/// What one region is made of.
#[derive(Debug, Clone, Copy)]
pub struct RegionProperties {
    /// The law.
    pub material: &'static dyn Material,
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// ν, no unit, below 0.5.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
}
