//! Comparisons of the load cell: fixture, sampling, noise, drift, resolution, waves of the tank, static force and its delay.

use std::f64::consts::TAU;

use lab::ForceLog;
use lab::card::Medium;
use lab::truth::{TrueForce, TrueWave};
use si::{MILLIBAR, Pascal, Second};

use super::{Comparison, range};
use crate::instruments::buoyancy::{self, DelayedPressure};
use crate::instruments::cell::{self, Run};
use crate::instruments::fixture;
use crate::instruments::tank::{self, FreeWaves};
use crate::random::RandomStream;
use crate::settings::{self, Settings};

/// Number of seeds.
const SEEDS: u64 = 100;
/// Duration of a log without force, s.
const LONG: Second = 20.0;
/// Half a unit of the last digit of the measured forces, N.
const DIGIT: f64 = 0.0005;
/// Tail, mbar, range of the static force after 5 s in water, N.
const STATIC_FORCES: [(&str, f64, [f64; 2]); 8] = [
    ("nemo", 100.0, [0.017, 0.017]),
    ("nemo", 200.0, [0.056, 0.056]),
    ("nemo", 250.0, [0.163, 0.232]),
    ("dory", 300.0, [0.035, 0.035]),
    ("dory", 400.0, [0.070, 0.070]),
    ("dory", 500.0, [0.157, 0.157]),
    ("bruce", 500.0, [0.071, 0.071]),
    ("bruce", 590.0, [0.088, 0.088]),
];

pub(super) fn comparisons(set: &Settings) -> Vec<Comparison> {
    let frequency = |seed| fixture::drawn(&set.cell, &mut RandomStream::new(seed, "fixture")).omega() / TAU;
    let mut comparisons =
        vec![Comparison::new("fixture: natural frequency (Hz)", [10.0, 20.0], range((0..SEEDS).map(frequency)))];
    comparisons.extend(amplifier(&set.cell));
    comparisons.extend(waves(set));
    for (name, mbar, [low, high]) in STATIC_FORCES {
        let quantity = format!("{name}: static force in water at {mbar} mbar (N)");
        let bench = held(&set.buoyancy, name, Medium::Water, mbar * MILLIBAR);
        comparisons.push(Comparison::new(quantity, [low - DIGIT, high + DIGIT], [bench; 2]));
    }
    let air = STATIC_FORCES.map(|(name, mbar, _)| held(&set.buoyancy, name, Medium::Air, mbar * MILLIBAR));
    comparisons.push(Comparison::new("any tail: static force in air (N)", [0.0, 0.02], range(air)));
    comparisons.push(Comparison::new(
        "delay of the static force after the pressure (s)",
        [0.275, 0.285],
        [lag(&set.buoyancy); 2],
    ));
    comparisons
}

/// Comparisons of the amplifier, from logs without a force.
fn amplifier(set: &settings::Cell) -> Vec<Comparison> {
    let logs = |set: &settings::Cell, medium| (0..SEEDS).map(|seed| unloaded(set, medium, seed)).collect::<Vec<_>>();
    let (air, water) = (logs(&settings::Cell { fast: true, ..set.clone() }, Medium::Air), logs(set, Medium::Water));
    let slow = unloaded(&settings::Cell { fast: false, ..set.clone() }, Medium::Air, 0).0;
    let noise = |logs: &[(ForceLog, TrueForce)]| range(logs.iter().map(|(log, _)| 1e3 * scatter(&log.force)));
    let drifts = range(air.iter().chain(&water).map(|(_, truth)| 1e3 * truth.drift.abs()));
    vec![
        Comparison::new("fast setting: sampling rate (Hz)", [79.9, 80.1], [air[0].0.rate(); 2]),
        Comparison::new("slow setting: sampling rate (Hz)", [10.465, 10.475], [slow.rate(); 2]),
        Comparison::new("noise mounted in air (mN)", [0.5, 2.0], noise(&air)),
        Comparison::new("noise in water (mN)", [1.0, 3.0], noise(&water)),
        Comparison::new("drift of the zero in a run (mN)", [0.0, 45.0], drifts),
        Comparison::new("resolution (mN)", [0.999, 1.001], [1e3 * smallest_step(&air[0].0.force); 2]),
    ]
}

fn unloaded(set: &settings::Cell, medium: Medium, seed: u64) -> (ForceLog, TrueForce) {
    let mut random = RandomStream::new(seed, "quiet");
    let clock = cell::clock(set, &mut random);
    let fixture = fixture::drawn(set, &mut random);
    let run = Run { id: "quiet", fixture, clock, pull: &|_| 0.0, beside: &|_| 0.0, medium, end: LONG };
    cell::record(set, &run, &mut random)
}

/// Standard deviation from successive differences, which drift does not affect.
fn scatter(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|v| (v[1] - v[0]).powi(2)).sum();
    (0.5 * squares / (values.len() - 1) as f64).sqrt()
}

fn smallest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|v| (v[1] - v[0]).abs());
    steps.filter(|step| *step > 1e-9).fold(f64::INFINITY, f64::min)
}

/// Waves one second after runs of different lengths.
fn waves(set: &Settings) -> Vec<Comparison> {
    let before = &set.still_water;
    let force = |t: Second| before.force * (TAU * before.frequency * t).sin();
    let after = |seed: u64| {
        let length = before.run + 0.01 * seed as f64;
        FreeWaves::after_run(&set.tank, length, &force, &mut RandomStream::new(seed, "tank")).truth_at(before.wait)
    };
    let after: Vec<Vec<TrueWave>> = (0..SEEDS).map(after).collect();
    let each = range(after.iter().flatten().map(|wave| 1e3 * wave.amplitude));
    let both = range(after.iter().map(|waves| 1e3 * waves[0].amplitude.hypot(waves[1].amplitude)));
    vec![
        Comparison::new("tank: first wave (Hz)", [1.0, 1.2], [tank::frequency(&set.tank, 1); 2]),
        Comparison::new("tank: second wave (Hz)", [1.8, 2.0], [tank::frequency(&set.tank, 2); 2]),
        Comparison::new("tank: one wave a second after a run (mN)", [1.0, 3.0], each),
        Comparison::new("tank: both waves together (mN)", [1.4, 3.9], both),
    ]
}

/// Static force after 5 s at `pressure` (Pa), N.
fn held(set: &settings::Buoyancy, name: &str, medium: Medium, pressure: Pascal) -> f64 {
    let delayed = DelayedPressure::of(set, [0.0, 5.0], &|t| if t < 0.0 { 0.0 } else { pressure });
    buoyancy::static_force(set, name, medium, delayed.at(5.0))
}

/// Delay of a linear ramp, s.
fn lag(set: &settings::Buoyancy) -> Second {
    3.0 - DelayedPressure::of(set, [0.0, 3.0], &|t: Second| t.max(0.0)).at(3.0)
}
