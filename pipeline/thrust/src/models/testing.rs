//! Synthetic runs for the tests of this crate and of those above it: a flapping beam with the force of theory and a little noise.

#![allow(clippy::unwrap_used)] // for tests alone 

use hydro::{Stations, Tail};
use optimize::network::Training;
use std::f64::consts::TAU;

use super::TrainingSettings;
use crate::run::{self, Run};

/// A tail of 0.1 m with three markers.
pub fn tail() -> Tail {
    Tail::new(1000.0, &Stations { clamp: 0.01, marks: &[0.05, 0.07, 0.09], edge: 0.105, end: 0.105 }, 16, &|_| 0.04)
        .expect("stations rise from the clamp to the edge")
}

/// 5 s of a run at `frequency` (Hz) and `amplitude` (Pa), a little different for each seed.
pub fn run(frequency: f64, amplitude: f64, seed: u64) -> Run {
    let (rate, phase) = (80.0, 0.7 * seed as f64);
    let size = 0.02 * amplitude / 2e4 / (1.0 + 0.2 * frequency) * (1.0 + 0.02 * (seed % 5) as f64);
    let time: Vec<f64> = (0..400).map(|i| f64::from(i) / rate).collect();
    let marker_position = |fraction: f64, t: f64| {
        let y = size * fraction * (TAU * frequency * t + phase - fraction).sin();
        [-8.0 * y * y, y]
    };
    let moved: Vec<Vec<[f64; 2]>> =
        time.iter().map(|&t| [0.3, 0.6, 1.0].map(|s| marker_position(s, t)).to_vec()).collect();
    let speed = |t: f64| {
        [0.3, 0.6, 1.0]
            .map(|s| [0, 1].map(|k| (marker_position(s, t + 1e-5)[k] - marker_position(s, t - 1e-5)[k]) / 2e-5))
            .to_vec()
    };
    let speed: Vec<Vec<[f64; 2]>> = time.iter().map(|&t| speed(t)).collect();
    let terms = run::theory_terms(&tail(), &moved, &speed, rate);
    let noise = |i: usize| 1e-3 * ((i * i + seed as usize) as f64 * 0.37).sin();
    let force = terms
        .iter()
        .enumerate()
        .map(|(i, t)| 0.8 * t.edge_flux + 0.9 * t.momentum_rate + 1.3 * t.drag + noise(i))
        .collect();
    let side_pressures = |t: f64| {
        [0.0, 0.5].map(|phase_shift| amplitude * (TAU * (frequency * t + phase_shift) + phase).sin().max(0.0)).to_vec()
    };
    let pressure: Vec<Vec<f64>> = time.iter().map(|&t| side_pressures(t)).collect();
    let pressure_rate = vec![vec![0.0; 2]; time.len()];
    let id = format!("run {seed}");
    Run { id, amplitude, frequency, split: None, rate, time, force, moved, speed, pressure, pressure_rate, terms }
}

/// A short training for a small network.
pub fn training() -> TrainingSettings {
    let training = Training { hidden: vec![40, 40], step: 3e-3, batch: 64, epochs: 40, patience: 40, seed: 5 };
    TrainingSettings { training, validation_fraction: 0.2, residual_hidden_layers: vec![16, 16] }
}
