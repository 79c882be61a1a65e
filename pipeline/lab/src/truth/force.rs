//! The hidden truth of the force instruments: the fixture, the tank, and what drifted in each log.

use serde::{Deserialize, Serialize};
use si::{Hertz, Kilogram, Metre, Newton, Second};

/// The load cell's fixture, a mass on a damped spring, and the tank that it stands over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueCell {
    /// m, kg.
    pub mass: Kilogram,
    /// b, N s/m.
    pub damping: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// Of the tank, m.
    pub tank_length: Metre,
    /// Of the water, m.
    pub tank_depth: Metre,
    /// Of its first two standing waves, Hz.
    pub tank_frequencies: [Hertz; 2],
}

/// What was hidden in one force log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueForce {
    /// The trial's or the fixture's id.
    pub id: String,
    /// log time = offset + scale × true time, which is video time in a trial: the offset, s.
    pub clock_offset: Second,
    /// The scale, no unit.
    pub clock_scale: f64,
    /// The zero at the first sample, N.
    pub zero: Newton,
    /// How far the zero went until the last sample, N.
    pub drift: Newton,
    /// Standard deviation of the noise, N.
    pub noise: Newton,
    /// Where the true forces of a trial lie, relative to the truth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forces: Option<String>,
    /// Blows of the hammer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taps: Vec<TrueTap>,
    /// Standing waves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waves: Vec<TrueWave>,
}

/// One blow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueTap {
    /// When it begins, true time, s.
    pub time: Second,
    /// ∫ F dt, N s.
    pub impulse: f64,
}

/// One standing wave, as the log begins: a cos(2π f t + φ), decaying.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueWave {
    /// f, Hz.
    pub frequency: Hertz,
    /// a, N.
    pub amplitude: Newton,
    /// φ, rad.
    pub phase: f64,
}
