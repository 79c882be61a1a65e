//! What is built into the valve, its hose and the pressure logger.
//!
//! Stands on: `si`. Never knows: what they make of a command.

use serde::Deserialize;
use si::{Hertz, Pascal, Second};

/// A proportional valve with its hose.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Valve {
    /// Dead time before filling (s) by the pressure commanded (Pa): two points, straight between, held beyond.
    pub dead_fill: [[f64; 2]; 2],
    /// Dead time before emptying, s.
    pub dead_exhaust: Second,
    /// Time constant of filling, s.
    pub fill: Second,
    /// Range of how far a fill overshoots for an instant, as a share of its step.
    pub overshoot: [f64; 2],
    /// Time constants of that instant's rise and fall, s.
    pub burst: [Second; 2],
    /// Time constant of emptying: the first (s) and the second (s/Pa) times the pressure at which it starts.
    pub exhaust: [f64; 2],
    /// How far it settles under the command, Pa.
    pub droop: Pascal,
    /// Filled f times a second, it settles lower still by this (s) times f times the command.
    pub sag: Second,
}

/// The pressure logger.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// Samples a second on its own clock.
    pub rate: Hertz,
    /// Standard deviation of a measured pressure, Pa.
    pub noise: Pascal,
    /// Where its gauges sit.
    pub port: Port,
    /// How much earlier than the camera it starts, s.
    pub offset: [Second; 2],
    /// Greatest drift of its clock, either way, no unit.
    pub drift: f64,
}

/// Where a pressure gauge sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Port {
    /// At the chamber's end of the hose.
    Chamber,
    /// At the valve's, where a fill overshoots for an instant.
    Valve,
}
