//! The hidden truth of a virtual specimen (`truth.toml`, `truth/<trial>.csv`): the true parameters, which
//! only the final comparison reads.

mod force;
mod traces;
mod tracks;

use std::path::Path;

use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal, Second};

use crate::table::{SEE, toml_error};
use diagnostics::{Diagnostic, input};

pub use force::{TrueCell, TrueForce, TrueTap, TrueWave};
pub use traces::{TrueForces, read_forces, write_forces};
pub use tracks::{TrueTrack, parse_tracks, read_tracks, write_tracks};

/// The hidden parameters of a specimen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Always [`crate::VIRTUAL_BENCH`].
    pub origin: String,
    /// The specimen's name.
    pub specimen: String,
    /// The seed everything hidden was drawn from.
    pub seed: u64,
    /// z of the water surface in the trials in water, m; the card's is a measured one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_surface: Option<Metre>,
    /// The soft body.
    pub body: Properties,
    /// The stiff sheet.
    pub spine: Properties,
    /// What the casting hides from the STL files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub casting: Option<Casting>,
    /// The water around the tail.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Fluid>,
    /// The lens, as in `track`: px, and no unit for the distortion.
    pub lens: Lens,
    /// The camera's pose: CAD frame → camera frame.
    pub pose: Pose,
    /// The load cell, where the specimen hung on one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<TrueCell>,
    /// The body under pressure in one channel after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inflation: Vec<TrueInflation>,
    /// What differs from trial to trial.
    pub trial: Vec<TrueTrial>,
    /// What differs from force log to force log.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub force: Vec<TrueForce>,
}

/// True properties of a solid; Young's modulus is the one after all relaxation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Properties {
    /// Pa.
    pub youngs_modulus: Pascal,
    /// No unit.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// C₂₀/C₁₀ and C₃₀/C₁₀ of its law, no unit.
    #[serde(default)]
    pub stiffening: [f64; 2],
    /// Its relaxation; none where it is elastic.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branch: Vec<TrueBranch>,
}

/// A Maxwell branch of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueBranch {
    /// Modulus over the long-term modulus, no unit.
    pub strength: f64,
    /// Relaxation time, s.
    pub time: Second,
}

/// What a casting hides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Casting {
    /// The right outer wall is thicker and the left one thinner by this share, no unit.
    pub asymmetry: f64,
    /// By how much the sheet lies off the middle, towards +y, m.
    #[serde(default)]
    pub sheet_offset: Metre,
    /// How far each marker is off its place on the card, along and across, m.
    pub markers: Vec<[f64; 2]>,
    /// Where the silicone does not adhere to the sheet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unbonded: Option<Unbonded>,
}

/// A stretch along which the silicone does not adhere to the sheet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unbonded {
    /// The side of the sheet: `-y` or `+y`.
    pub side: String,
    /// x where it begins, m.
    pub from: Metre,
    /// x where it ends, m.
    pub to: Metre,
}

/// Equilibria under rising pressure in one channel, after all relaxation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueInflation {
    /// The channel.
    pub channel: String,
    /// Its pressures, Pa.
    pub pressure: Vec<Pascal>,
    /// Rotation of the far third, rad, positive towards y.
    pub rotation: Vec<f64>,
    /// Highest bulge of the wall under pressure, m.
    pub bulge: Vec<Metre>,
    /// Deepest dent of the other wall, m.
    pub dent: Vec<Metre>,
    /// x of that at rest, m.
    pub dent_at: Vec<Metre>,
}

/// The water around the tail, as elongated-body theory and a drag across the flow have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Share of the theory's added mass, no unit.
    pub added: f64,
    /// Coefficient of drag, no unit.
    pub drag: f64,
}

/// A pinhole with radial and tangential distortion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Focal length along u, px.
    pub fx: f64,
    /// Focal length along v, px.
    pub fy: f64,
    /// Principal point, u, px.
    pub cx: f64,
    /// Principal point, v, px.
    pub cy: f64,
    /// Radial, second order.
    pub k1: f64,
    /// Radial, fourth order.
    pub k2: f64,
    /// Tangential.
    pub p1: f64,
    /// Tangential.
    pub p2: f64,
    /// Radial, sixth order.
    pub k3: f64,
}

/// A rigid motion x ↦ R x + t.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// R, rows.
    pub rotation: [[f64; 3]; 3],
    /// t, m.
    pub translation: [f64; 3],
}

/// What was hidden in one trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueTrial {
    /// The trial's id.
    pub id: String,
    /// Where its true tracks lie, relative to the truth.
    pub tracks: String,
    /// log time = offset + scale × video time: the offset, s.
    pub clock_offset: Second,
    /// log time = offset + scale × video time: the scale, no unit.
    pub clock_scale: f64,
    /// When the lamp lights, s on the video's clock.
    pub led_on: Second,
    /// By how much the regulated pressure was off, as a share, no unit.
    #[serde(default)]
    pub supply: f64,
    /// The silicone's moduli against those above, mean over the body, no unit.
    #[serde(default = "unit_factor")]
    pub softening: f64,
    /// Where the camera was in it, when elsewhere than in the calibration's film: CAD frame → camera frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
}

fn unit_factor() -> f64 {
    1.0
}

/// The truth in the file `path`.
///
/// # Errors
/// [`Diagnostic`] when the file cannot be read or is no truth.
pub fn read(path: &Path) -> Result<Truth, Diagnostic> {
    let text = input::read_text(path, input::PAGE).map_err(|e| {
        Diagnostic::io(path, e, "record the specimen on the virtual bench again; a real one has no truth file")
    })?;
    parse(&text, path)
}

/// The truth in a text; `path` appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] when the text is no truth.
pub fn parse(text: &str, path: &Path) -> Result<Truth, Diagnostic> {
    toml::from_str(text).map_err(|e| toml_error(text, path, &e, SEE))
}

/// The text of `truth.toml`.
pub fn write(truth: &Truth) -> String {
    let body = toml::to_string(truth).expect("a truth has only tables, numbers and words");
    format!("# Hidden truth of the virtual bench: SI units. Only the recovery at the very end may read it.\n{body}")
}
