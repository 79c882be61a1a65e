//! Ranges of the hidden properties of a specimen and of a run.

use serde::Deserialize;
use si::{KilogramPerCubicMetre, Metre, Pascal, Second};

/// A material: the ranges of its true properties, and the nominal properties for the card.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Seed of its properties, which are the same for all specimens.
    pub seed: u64,
    /// Constitutive law, by its name in `fem`.
    pub law: String,
    /// Pa, `modulus_time` after loading.
    pub youngs_modulus: [Pascal; 2],
    /// s.
    #[serde(default)]
    pub modulus_time: Second,
    /// No unit.
    pub poissons_ratio: [f64; 2],
    /// C₂₀/C₁₀ and C₃₀/C₁₀ of the law, no unit.
    #[serde(default)]
    pub stiffening: [f64; 2],
    /// Relaxation time (s) and strength over the long-term modulus of each Maxwell branch; none: elastic.
    #[serde(default)]
    pub branches: Vec<[f64; 2]>,
    /// Factor of every strength, no unit.
    #[serde(default = "unscaled")]
    pub branch_factor: [f64; 2],
    /// kg/m³, on the card as it is.
    pub density: KilogramPerCubicMetre,
    /// The properties on the card.
    pub nominal: Nominal,
}

fn unscaled() -> [f64; 2] {
    [1.0; 2]
}

/// Properties of a solid on the card.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nominal {
    /// The law that the study assumes, by its name in `fem`.
    pub law: String,
    /// Pa.
    pub youngs_modulus: Pascal,
    /// No unit.
    pub poissons_ratio: f64,
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    #[serde(default)]
    pub stiffening: [f64; 2],
    /// Their standard deviations by a tensile test.
    pub stiffening_sigma: Option<[f64; 2]>,
    /// Pa.
    pub plausible: [Pascal; 2],
}

/// Deviations of a casting from its STL files.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Casting {
    /// Greatest relative difference of the outer walls from their nominal thickness, one thicker and one thinner, no unit.
    pub asymmetry: f64,
    /// Greatest offset of the sheet from the middle, m.
    pub sheet_offset: Metre,
    /// Standard deviation of a marker's position along and across, m.
    pub markers_off: Metre,
    /// Along how many chambers of one side the silicone does not adhere to the sheet.
    pub unbonded: usize,
    /// Thickness of the film on which it slides there, m.
    pub film: Metre,
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
    /// Softening of the silicone in its first cycles.
    pub mullins: Mullins,
    /// Change of the camera's pose between runs.
    pub nudge: PosePerturbation,
}

/// The Mullins effect after Ogden and Roxburgh \[ogden1999\]: cycles that strain a point up to an energy density W soften it, at the energy
/// density w W, to 1 − erf((1 − w) W / (m + β W)) / r of its modulus. Rest restores it.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mullins {
    /// r, no unit.
    pub r: f64,
    /// m, J/m³.
    pub m: f64,
    /// β, no unit.
    pub beta: f64,
    /// w: the mean energy density of a cycle over its highest, no unit.
    pub energy: f64,
}

impl Mullins {
    /// Modulus of a point that has been cycled up to the energy density `highest` (J/m³) over that of one that has rested, no unit.
    pub(crate) fn softened_share(&self, highest: f64) -> f64 {
        1.0 - libm::erf((1.0 - self.energy) * highest / (self.m + self.beta * highest)) / self.r
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_softens_by_its_own_energy_and_never_beyond_the_limit() {
        let mullins = Mullins { r: 50.0, m: 200.0, beta: 0.1, energy: 0.5 };
        assert_eq!(mullins.softened_share(0.0), 1.0);
        // by hand: erf(500 / 300) / 50 at 1000 J/m³
        assert!((mullins.softened_share(1000.0) - (1.0 - libm::erf(500.0 / 300.0) / 50.0)).abs() < 1e-15);
        let softer = [10.0, 100.0, 1000.0, 1e5].map(|energy| mullins.softened_share(energy));
        assert!(softer.is_sorted_by(|a, b| a > b) && softer.iter().all(|s| *s > 1.0 - 1.0 / 50.0), "{softer:?}");
    }
}
