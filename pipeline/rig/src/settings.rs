//! What is built into the bench: `bench.toml`, compiled in, so that a recording is decided by its seed alone.
//!
//! Stands on: `si`. Never knows: what is drawn from its ranges.

mod force;
mod hidden;
mod pneumatics;
mod water;

use std::collections::BTreeMap;

use lab::card::Medium;
use serde::Deserialize;
use si::{Hertz, Metre, Pascal, Point2, Point3, Second};

pub use force::{Buoyancy, Cell, Hammer, StillWater, Tank};
pub use hidden::{Casting, Causes, Fluid, Material, Nominal, Nudge};
pub use pneumatics::{Log, Port, Valve};
pub use water::Water;

/// The text of the settings, which also decides whether a recording is still current.
pub const TEXT: &str = include_str!("../bench.toml");

/// The whole bench.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What is known of each material, by name.
    pub material: BTreeMap<String, Material>,
    /// What a casting hides.
    pub casting: Casting,
    /// Why no two runs are alike.
    pub causes: Causes,
    /// The water around the tail.
    pub fluid: Fluid,
    /// What is known of each specimen, by name.
    pub specimen: BTreeMap<String, Specimen>,
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
    /// Buoyancy that crosses into the cell.
    pub buoyancy: Buoyancy,
    /// Taps on the cell's fixture.
    pub hammer: Hammer,
    /// What is left in the tank after a run.
    pub still_water: StillWater,
    /// Camera.
    pub camera: Camera,
    /// The water over the tail, in the trials that are in water.
    pub water: Water,
    /// Grid and checkerboard.
    pub plane: Plane,
    /// The calibration recording.
    pub calibration: Calibration,
    /// The lamp that both clocks see.
    pub lamp: Lamp,
    /// How much is recorded and how finely.
    pub profile: BTreeMap<String, Profile>,
}

impl Settings {
    /// The settings that are compiled in.
    pub fn built_in() -> Self {
        toml::from_str(TEXT).expect("bench.toml is part of the program and is read by every test")
    }
}

/// A specimen: what it is made of, how it is marked, and what is asked of it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// What its casting alone hides is drawn from it.
    pub seed: u64,
    /// The silicone's name among the materials.
    pub body: String,
    /// Errors are divided by it, m.
    pub length: Metre,
    /// x of the holder's edge, m.
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
    pub flaps: Vec<Flap>,
}

impl Specimen {
    /// The highest pressure that is ever commanded, Pa.
    pub fn highest(&self) -> Pascal {
        let levels = self.levels.iter().chain(&self.levels_in_water).copied();
        levels.chain(self.flaps.iter().map(|flap| flap.pressure)).fold(0.0, f64::max)
    }
}

/// The camera.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// px.
    pub width: usize,
    /// px.
    pub height: usize,
    /// Frames a second.
    pub rate: Hertz,
    /// Range of fx, px.
    pub focal: [f64; 2],
    /// fy / fx.
    pub aspect: f64,
    /// Principal point, px.
    pub centre: Point2,
    /// k1, k2, k3.
    pub radial: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
    /// Where it hangs, m, CAD frame.
    pub above: Point3,
    /// Turns about the picture's right, down and view, degrees.
    pub tilt: [f64; 3],
    /// How long light is collected in a frame, s, around the frame's time. The lamp is dimmed by it; the tail is drawn
    /// as it stands at each row's time, without blur.
    pub exposure: Second,
    /// From the first row's time to the last one's, s.
    pub readout: Second,
    /// Standard deviation of a pixel, grey levels.
    pub noise: f64,
    /// Quantiser of H.264.
    pub quantiser: u8,
}

/// The plane under the tail, and the checkerboard that is laid on it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// z, m.
    pub height: Metre,
    /// Of the grid, m.
    pub pitch: Metre,
    /// Width of a grid line, m.
    pub line: Metre,
    /// Squares of the checkerboard.
    pub columns: usize,
    /// Squares of the checkerboard.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
    /// Where its inner corner (0, 0) is laid down, m.
    pub corner: Point2,
}

/// The STL files.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cad {
    /// Of their triangles, m.
    pub fineness: Metre,
}

/// The recording of the checkerboard.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Frames in each pose.
    pub held: usize,
    /// Frames to the next.
    pub moving: usize,
    /// Frames on the plane, at the end.
    pub flat: usize,
}

/// The lamp.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Its centre, m.
    pub at: Point3,
    /// Its radius, m.
    pub radius: Metre,
}

/// How much is recorded and how finely.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Of the bench's own mesh.
    pub resolution: Resolution,
    /// Equilibria that are solved up each side.
    pub rungs: usize,
    /// Of time in a dynamic solve, s.
    pub step: Second,
    /// Before the first command and after the last, s.
    pub rest: Second,
    /// How long each level of a staircase is commanded, s.
    pub hold: Second,
    /// Between levels, s.
    pub pause: Second,
    /// Full cycles of a flapping trial.
    pub cycles: usize,
    /// How often each flapping trial is recorded.
    pub repeats: usize,
    /// Whether only the flaps that are marked so are recorded.
    pub brief: bool,
    /// Of the checkerboard.
    pub poses: usize,
}

/// Fineness of the bench's own mesh.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// Length of edges where no feature asks for less, m.
    pub edge: Metre,
    /// Elements along each chamber.
    pub per_chamber: usize,
    /// Elements along each rib.
    pub per_rib: usize,
}

/// A flapping trial.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flap {
    /// What surrounds the tail.
    pub medium: Medium,
    /// Commanded, Pa.
    pub pressure: Pascal,
    /// Full cycles a second, Hz.
    pub frequency: Hertz,
    /// Whether models of the motion are judged by it.
    #[serde(default)]
    pub validate: bool,
    /// On which side of the learning of thrust its repeats stand.
    pub split: Option<Splits>,
    /// Whether it belongs to a brief recording.
    #[serde(default)]
    pub brief: bool,
}

/// Where the repeats of a trial stand in the learning of thrust.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Splits {
    /// All are learned from.
    Train,
    /// None is.
    Test,
    /// All but the last are.
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
