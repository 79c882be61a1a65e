//! Settings of the valve, its hose and the pressure logger.

use serde::Deserialize;
use si::{Hertz, Pascal, Second};

/// A proportional valve with its hose.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Valve {
    /// Dead time before filling (s) by commanded pressure (Pa): two points, linear between them, constant beyond.
    pub dead_fill: [[f64; 2]; 2],
    /// Dead time before emptying, s.
    pub dead_exhaust: Second,
    /// Time constant of filling, s.
    pub fill: Second,
    /// Range of the overshoot at the port, relative to the step.
    pub overshoot: [f64; 2],
    /// Time constants of the overshoot's rise and decay, s.
    pub burst: [Second; 2],
    /// Time constant of emptying: the first (s) and the second (s/Pa) times the pressure at which it starts.
    pub exhaust: [f64; 2],
    /// Steady difference below the command, Pa.
    pub droop: Pascal,
    /// Further difference at f fills a second: this (s) times f times the command.
    pub sag: Second,
}

/// The pressure logger.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// Sampling rate on its own clock.
    pub rate: Hertz,
    /// Standard deviation of a measured pressure, Pa.
    pub noise: Pascal,
    /// Position of its gauges.
    pub port: Port,
    /// Range of the time by which it starts before the camera, s.
    pub offset: [Second; 2],
    /// Greatest drift of its clock, either way, no unit.
    pub drift: f64,
}

/// Position of a pressure gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Port {
    /// At the chamber's end of the hose.
    Chamber,
    /// At the valve's end, where a fill overshoots briefly.
    Valve,
}
