//! What is built into the force instruments: the load cell, its amplifier, the tank, and the two runs of the fixture alone.
//!
//! Stands on: `si`. Never knows: what is drawn from its ranges.

use std::collections::BTreeMap;

use serde::Deserialize;
use si::{Hertz, Kilogram, Metre, Newton, Second};

/// The load cell on its fixture, and the amplifier behind it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Range of the mass that hangs on the cell's spring, kg.
    pub mass: [Kilogram; 2],
    /// Range of the fixture's natural frequency, Hz.
    pub frequency: [Hertz; 2],
    /// Range of its damping ratio, no unit.
    pub damping_ratio: [f64; 2],
    /// Samples a second, at the fast and at the slow setting.
    pub rates: [Hertz; 2],
    /// Which of the two is set.
    pub fast: bool,
    /// Greatest drift of its clock, either way, no unit.
    pub clock_drift: f64,
    /// How much earlier than the camera it starts, s.
    pub offset: [Second; 2],
    /// Range of the noise's standard deviation in air, N.
    pub noise_in_air: [Newton; 2],
    /// The same in water, N.
    pub noise_in_water: [Newton; 2],
    /// Greatest ramp of the zero in a run, either way, N.
    pub ramp: Newton,
    /// Greatest wandering of the zero about that ramp, N.
    pub wander: Newton,
    /// Stored to this, N.
    pub quantum: Newton,
}

/// The tank, and how its waves reach the cell.
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

/// The force that follows pressure although nothing moves.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buoyancy {
    /// How much later than the pressure it comes, in all, s.
    pub lag: Second,
    /// How much of that is slow rather than late: the time constant of the inflation, s.
    pub slow: Second,
    /// How much of it is left in air, no unit.
    pub air: f64,
    /// Force in water (N) by pressure (Pa), rising, for each tail; straight between, from (0, 0), held beyond.
    pub water: BTreeMap<String, Vec<[f64; 2]>>,
}

/// The hammer, and its taps on the fixture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hammer {
    /// Blows.
    pub taps: usize,
    /// Between them, s.
    pub every: Second,
    /// How long one lasts, s.
    pub contact: Second,
    /// Range of a blow's greatest force, N.
    pub peak: [Newton; 2],
    /// Samples a second of its log.
    pub rate: Hertz,
    /// Standard deviation of its noise, N.
    pub noise: Newton,
}

/// The run whose waves are left, and how long they are listened to.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StillWater {
    /// How long the run before lasted, s.
    pub run: Second,
    /// Its beats a second, Hz.
    pub frequency: Hertz,
    /// Amplitude of its force, N.
    pub force: Newton,
    /// Between its end and the log, s.
    pub wait: Second,
    /// Of the log, s.
    pub length: Second,
}
