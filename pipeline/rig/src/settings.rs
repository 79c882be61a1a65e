//! What is built into the bench: `bench.toml`, compiled in, so that a recording is decided by its seed alone.
//!
//! Stands on: `si`. Never knows: what is drawn from its ranges.

mod force;
mod pneumatics;
mod water;

use std::collections::BTreeMap;

use serde::Deserialize;
use si::{Hertz, KilogramPerCubicMetre, Metre, Pascal, Point2, Point3, Second};

pub use force::{Buoyancy, Cell, Hammer, StillWater, Tank};
pub use pneumatics::{Log, Port, Valve};
pub use water::Water;

/// The text of the settings, which also decides whether a recording is still current.
pub const TEXT: &str = include_str!("../bench.toml");

/// The whole bench.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
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

/// What is hidden in a specimen, as ranges, and what a laboratory would write on its card.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// Everything hidden is drawn from it.
    pub seed: u64,
    /// Constitutive model of both solids, by its name in `fem`.
    pub material: String,
    /// Errors are divided by it, m.
    pub length: Metre,
    /// x of the holder's edge, m.
    pub clamp: Metre,
    /// True properties of the silicone.
    pub body: Ranges,
    /// True properties of the sheet.
    pub spine: Ranges,
    /// Damping ratio of a free ring-down, no unit.
    pub damping_ratio: [f64; 2],
    /// Frequency at which that ratio holds, Hz.
    pub ring_down: Hertz,
    /// x of the marks on the back, m.
    pub markers: Vec<Metre>,
    /// Their diameter, m.
    pub marker_diameter: Metre,
    /// The card's first guess for the silicone.
    pub nominal_body: Nominal,
    /// The card's first guess for the sheet.
    pub nominal_spine: Nominal,
}

/// Ranges of a solid's true properties.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranges {
    /// Pa.
    pub youngs_modulus: [Pascal; 2],
    /// No unit.
    pub poissons_ratio: [f64; 2],
    /// kg/m³, on the card as it is.
    pub density: KilogramPerCubicMetre,
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
    /// Solved equilibria between two levels.
    pub rungs_between: usize,
    /// Of time in a dynamic solve, s.
    pub step: Second,
    /// Before the first command and after the last, s.
    pub rest: Second,
    /// Of the staircase, Pa.
    pub levels: Vec<Pascal>,
    /// How long each is commanded, s.
    pub hold: Second,
    /// Between levels, s.
    pub pause: Second,
    /// Flapping trials.
    pub flaps: Vec<Flap>,
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
    /// Commanded, Pa.
    pub pressure: Pascal,
    /// Full cycles a second, Hz.
    pub frequency: Hertz,
    /// Full cycles.
    pub cycles: usize,
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
