//! The square wave of pressure, with its derivatives by amplitude and frequency.

use std::f64::consts::TAU;

use si::{Hertz, Pascal, Second};

/// Alternating pressure of two sides: p = A σ(±k sin 2πft), a square wave with smooth edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareWave {
    /// A, Pa.
    pub amplitude: Pascal,
    /// f, Hz.
    pub frequency: Hertz,
    /// k: 1 is a sine, 20 a square.
    pub sharpness: f64,
}

/// A pressure, its rate, and the derivatives of both by amplitude and frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PressureValue {
    pub(crate) value: Pascal,
    pub(crate) rate: f64,
    pub(crate) by_amplitude: [f64; 2],
    pub(crate) by_frequency: [f64; 2],
}

impl SquareWave {
    /// Pressures of two sides at time `t` (s), Pa.
    pub fn at(&self, t: Second) -> Vec<Pascal> {
        [1.0, -1.0].iter().map(|side| self.value_at(*side, t).value).collect()
    }

    pub(crate) fn value_at(&self, side: f64, t: Second) -> PressureValue {
        let (omega, k) = (TAU * self.frequency, side * self.sharpness);
        let (sin, cos) = (omega * t).sin_cos();
        let sigmoid = 1.0 / (1.0 + (-k * sin).exp());
        let sigmoid_slope = sigmoid * (1.0 - sigmoid);
        // σ' = σ(1−σ), σ'' = σ'(1 − 2σ); z = k sin ωt
        let (rate_z, by_f_z) = (k * omega * cos, k * TAU * t * cos);
        let by_f_rate_z = k * TAU * cos - k * omega * TAU * t * sin;
        let by_f_rate = sigmoid_slope * (1.0 - 2.0 * sigmoid) * by_f_z * rate_z + sigmoid_slope * by_f_rate_z;
        let a = self.amplitude;
        PressureValue {
            value: a * sigmoid,
            rate: a * sigmoid_slope * rate_z,
            by_amplitude: [sigmoid, sigmoid_slope * rate_z],
            by_frequency: [a * sigmoid_slope * by_f_z, a * by_f_rate],
        }
    }
}
