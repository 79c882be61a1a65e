//! The settings of the bench: `bench.toml`, compiled in, so that a recording is determined by its seed.
//!
//! The keys enter the stamp of every recording ([`crate::stamp`]); renaming one makes all recordings stale.

mod camera;
mod force;
mod hidden;
mod pneumatics;
mod population;

use std::collections::BTreeMap;

use lab::card::Medium;
use serde::Deserialize;
use si::{Hertz, Metre, Pascal, Second};

pub use camera::{Calibration, Camera, Lamp, Plane, Water};
pub use force::{Buoyancy, Cell, Hammer, StillWater, Tank};
pub use hidden::{Casting, Causes, Fluid, Material, Mullins, Nominal, PosePerturbation};
pub use pneumatics::{Log, Port, Valve};
pub use population::Population;

/// The text of the settings; the stamp of a recording is made from it.
pub const TEXT: &str = include_str!("../../bench.toml");

/// The whole bench.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Materials, by name.
    pub material: BTreeMap<String, Material>,
    /// Deviations of a casting from its CAD.
    pub casting: Casting,
    /// Variations between runs.
    pub causes: Causes,
    /// The water around the tail.
    pub fluid: Fluid,
    /// Specimens, by name.
    pub specimen: BTreeMap<String, Specimen>,
    /// What is drawn anew for each specimen of a population.
    pub population: Population,
    /// The STL files.
    pub cad: Cad,
    /// Valve and hose.
    pub valve: Valve,
    /// Pressure logger.
    pub log: Log,
    /// Load cell and amplifier.
    pub cell: Cell,
    /// Tank.
    pub tank: Tank,
    /// Pressure-dependent static force.
    pub buoyancy: Buoyancy,
    /// Taps on the cell's fixture.
    pub hammer: Hammer,
    /// Recording of the waves after a run.
    pub still_water: StillWater,
    /// Camera.
    pub camera: Camera,
    /// The water over the tail, in the trials that are in water.
    pub water: Water,
    /// Grid and checkerboard.
    pub plane: Plane,
    /// The calibration film.
    pub calibration: Calibration,
    /// The lamp that synchronises the clocks.
    pub lamp: Lamp,
    /// Extent and resolution of the recordings, by name.
    pub profile: BTreeMap<String, Profile>,
}

impl Settings {
    /// The settings that are compiled in.
    pub fn built_in() -> Self {
        toml::from_str(TEXT).expect("bench.toml is part of the program and is read by every test")
    }
}

/// A specimen: its material, marks and trials.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// Seed of its casting and recordings.
    pub seed: u64,
    /// The silicone's name among the materials.
    pub body: String,
    /// Reference length of relative errors, m.
    pub length: Metre,
    /// x of the holder's edge; everything at or below it is clamped, m.
    pub clamp: Metre,
    /// x of the marks on the back, m.
    pub markers: Vec<Metre>,
    /// Their diameter, m.
    pub marker_diameter: Metre,
    /// Of the staircases in air, Pa.
    pub levels: Vec<Pascal>,
    /// Of the staircase in water, Pa.
    pub levels_in_water: Vec<Pascal>,
    /// Flapping trials, each repeated.
    pub flaps: Vec<FlappingTrial>,
}

impl Specimen {
    /// The highest commanded pressure, Pa.
    pub fn highest_pressure(&self) -> Pascal {
        let levels = self.levels.iter().chain(&self.levels_in_water).copied();
        levels.chain(self.flaps.iter().map(|flap| flap.pressure)).fold(0.0, f64::max)
    }
}

/// The STL files.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cad {
    /// Of their triangles, m.
    pub fineness: Metre,
}

/// Extent and resolution of a recording.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The specimens that are recorded where none is named.
    pub specimens: Vec<String>,
    /// Of the bench's own mesh.
    pub resolution: Resolution,
    /// Pressure levels of each side's sweep.
    pub levels: usize,
    /// Time step, s.
    pub step: Second,
    /// Time before the first command and after the last, s.
    pub rest: Second,
    /// How long each level of a staircase is commanded, s.
    pub hold: Second,
    /// Between levels, s.
    pub pause: Second,
    /// Full cycles of a flapping trial.
    pub cycles: usize,
    /// Recordings of each flapping trial.
    pub repeats: usize,
    /// Whether only the flapping trials marked `brief` are recorded.
    pub brief: bool,
    /// Poses of the checkerboard.
    pub poses: usize,
}

/// Resolution of the bench's own mesh.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// Edge length where no feature requires a shorter one, m.
    pub edge: Metre,
    /// Elements along each chamber.
    pub per_chamber: usize,
    /// Elements along each rib.
    pub per_rib: usize,
    /// By how much the cells of hexahedra are shorter than those of the study; none: tetrahedra.
    #[serde(default)]
    pub hexahedra: Option<f64>,
}

/// A flapping trial.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlappingTrial {
    /// Medium around the tail.
    pub medium: Medium,
    /// Commanded, Pa.
    pub pressure: Pascal,
    /// Full cycles a second, Hz.
    pub frequency: Hertz,
    /// Whether the predicted motion is validated against it.
    #[serde(default)]
    pub validate: bool,
    /// Use of its repeats for the thrust models.
    pub split: Option<RepeatSplit>,
    /// Whether it is part of a brief recording.
    #[serde(default)]
    pub brief: bool,
}

/// Use of the repeats of a trial for the thrust models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RepeatSplit {
    /// All are used for training.
    Train,
    /// All are used for testing.
    Test,
    /// The last is used for testing, the others for training.
    Last,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_settings_have_both_profiles() {
        let settings = Settings::built_in();
        assert!(["quick", "paper"].iter().all(|p| settings.profile.contains_key(*p)));
    }
}
