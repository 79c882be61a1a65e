//! Settings of the force instruments: load cell, amplifier, tank, and the two recordings of the fixture alone.

use std::collections::BTreeMap;

use serde::Deserialize;
use si::{Hertz, Kilogram, Metre, Newton, Second};

/// The load cell on its fixture, and the amplifier behind it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Range of the fixture's mass, kg.
    pub mass: [Kilogram; 2],
    /// Range of the fixture's natural frequency, Hz.
    pub frequency: [Hertz; 2],
    /// Range of its damping ratio, no unit.
    pub damping_ratio: [f64; 2],
    /// Sampling rates of the fast and the slow setting.
    pub rates: [Hertz; 2],
    /// Whether the fast one is set.
    pub fast: bool,
    /// Greatest drift of its clock, either way, no unit.
    pub clock_drift: f64,
    /// Range of the time by which it starts before the camera, s.
    pub offset: [Second; 2],
    /// Range of the noise's standard deviation in air, N.
    pub noise_in_air: [Newton; 2],
    /// The same in water, N.
    pub noise_in_water: [Newton; 2],
    /// Greatest linear drift of the zero in a run, either way, N.
    pub ramp: Newton,
    /// Greatest deviation of the zero from that drift, N.
    pub wander: Newton,
    /// Resolution of the stored values, N.
    pub quantum: Newton,
}

/// The tank and its standing waves.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tank {
    /// m.
    pub length: Metre,
    /// Of the water, m.
    pub depth: Metre,
    /// Damping ratio of its waves, no unit.
    pub damping_ratio: f64,
    /// Range of a wave's amplitude a second after a run, N.
    pub amplitude: [Newton; 2],
}

/// The static force, which depends on pressure without any motion.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buoyancy {
    /// Total delay after the pressure, s.
    pub lag: Second,
    /// Part of the delay that is a first-order lag, the time constant of the inflation, s.
    pub slow: Second,
    /// Ratio of the force in air to that in water, no unit.
    pub air: f64,
    /// Force in water (N) by rising pressure (Pa) for each tail; piecewise linear from (0, 0), constant beyond.
    pub water: BTreeMap<String, Vec<[f64; 2]>>,
}

/// The hammer, and its taps on the fixture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hammer {
    /// Number of taps.
    pub taps: usize,
    /// Interval between taps, s.
    pub every: Second,
    /// Contact time, s.
    pub contact: Second,
    /// Range of the peak force, N.
    pub peak: [Newton; 2],
    /// Sampling rate of its log.
    pub rate: Hertz,
    /// Standard deviation of its noise, N.
    pub noise: Newton,
}

/// The recording of the tank's waves after a run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StillWater {
    /// Duration of the run, s.
    pub run: Second,
    /// Frequency of the run, Hz.
    pub frequency: Hertz,
    /// Amplitude of its force, N.
    pub force: Newton,
    /// Time between its end and the log, s.
    pub wait: Second,
    /// Duration of the log, s.
    pub length: Second,
}
