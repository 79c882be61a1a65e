//! Comparisons of the load cell: fixture, sampling, noise, drift, resolution, waves of the tank, static force and its delay.

use std::f64::consts::TAU;

use lab::ForceLog;
use lab::card::Medium;
use lab::truth::{TrueForce, TrueWave};
use si::{MILLIBAR, Pascal, Second};

use super::{Comparison, range_of};
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

pub(super) fn cell_comparisons(set: &Settings) -> Vec<Comparison> {
    let frequency = |seed| fixture::draw_fixture(&set.cell, &mut RandomStream::new(seed, "fixture")).omega() / TAU;
    let mut comparisons =
        vec![Comparison::new("fixture: natural frequency (Hz)", [10.0, 20.0], range_of((0..SEEDS).map(frequency)))];
    comparisons.extend(amplifier_comparisons(&set.cell));
    comparisons.extend(wave_comparisons(set));
    for (name, mbar, [low, high]) in STATIC_FORCES {
        let quantity = format!("{name}: static force in water at {mbar} mbar (N)");
        let bench = static_force_after_hold(&set.buoyancy, name, Medium::Water, mbar * MILLIBAR);
        comparisons.push(Comparison::new(quantity, [low - DIGIT, high + DIGIT], [bench; 2]));
    }
    let air =
        STATIC_FORCES.map(|(name, mbar, _)| static_force_after_hold(&set.buoyancy, name, Medium::Air, mbar * MILLIBAR));
    comparisons.push(Comparison::new("any tail: static force in air (N)", [0.0, 0.02], range_of(air)));
    comparisons.push(Comparison::new(
        "delay of the static force after the pressure (s)",
        [0.275, 0.285],
        [ramp_delay(&set.buoyancy); 2],
    ));
    comparisons
}

/// Comparisons of the amplifier, from logs without a force.
fn amplifier_comparisons(set: &settings::Cell) -> Vec<Comparison> {
    let logs =
        |set: &settings::Cell, medium| (0..SEEDS).map(|seed| unloaded_log(set, medium, seed)).collect::<Vec<_>>();
    let (air, water) = (logs(&settings::Cell { fast: true, ..set.clone() }, Medium::Air), logs(set, Medium::Water));
    let slow = unloaded_log(&settings::Cell { fast: false, ..set.clone() }, Medium::Air, 0).0;
    let noise =
        |logs: &[(ForceLog, TrueForce)]| range_of(logs.iter().map(|(log, _)| 1e3 * noise_deviation(&log.force)));
    let drifts = range_of(air.iter().chain(&water).map(|(_, truth)| 1e3 * truth.drift.abs()));
    vec![
        Comparison::new("fast setting: sampling rate (Hz)", [79.9, 80.1], [air[0].0.rate(); 2]),
        Comparison::new("slow setting: sampling rate (Hz)", [10.465, 10.475], [slow.rate(); 2]),
        Comparison::new("noise mounted in air (mN)", [0.5, 2.0], noise(&air)),
        Comparison::new("noise in water (mN)", [1.0, 3.0], noise(&water)),
        Comparison::new("drift of the zero in a run (mN)", [0.0, 45.0], drifts),
        Comparison::new("resolution (mN)", [0.999, 1.001], [1e3 * smallest_step(&air[0].0.force); 2]),
    ]
}

fn unloaded_log(set: &settings::Cell, medium: Medium, seed: u64) -> (ForceLog, TrueForce) {
    let mut random = RandomStream::new(seed, "quiet");
    let clock = cell::draw_clock(set, &mut random);
    let fixture = fixture::draw_fixture(set, &mut random);
    let run = Run { id: "quiet", fixture, clock, pull: &|_| 0.0, beside: &|_| 0.0, medium, end: LONG };
    cell::record_run(set, &run, &mut random)
}

/// Standard deviation from successive differences, which drift does not affect.
fn noise_deviation(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|v| (v[1] - v[0]).powi(2)).sum();
    (0.5 * squares / (values.len() - 1) as f64).sqrt()
}

fn smallest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|v| (v[1] - v[0]).abs());
    steps.filter(|step| *step > 1e-9).fold(f64::INFINITY, f64::min)
}

/// Waves one second after runs of different lengths.
fn wave_comparisons(set: &Settings) -> Vec<Comparison> {
    let run = &set.still_water;
    let force = |t: Second| run.force * (TAU * run.frequency * t).sin();
    let waves_after_run = |seed: u64| {
        let length = run.run + 0.01 * seed as f64;
        FreeWaves::after_run(&set.tank, length, &force, &mut RandomStream::new(seed, "tank")).truth_at(run.wait)
    };
    let waves_after_run: Vec<Vec<TrueWave>> = (0..SEEDS).map(waves_after_run).collect();
    let each = range_of(waves_after_run.iter().flatten().map(|wave| 1e3 * wave.amplitude));
    let both = range_of(waves_after_run.iter().map(|waves| 1e3 * waves[0].amplitude.hypot(waves[1].amplitude)));
    vec![
        Comparison::new("tank: first wave (Hz)", [1.0, 1.2], [tank::mode_frequency(&set.tank, 1); 2]),
        Comparison::new("tank: second wave (Hz)", [1.8, 2.0], [tank::mode_frequency(&set.tank, 2); 2]),
        Comparison::new("tank: one wave a second after a run (mN)", [1.0, 3.0], each),
        Comparison::new("tank: both waves together (mN)", [1.4, 3.9], both),
    ]
}

/// Static force after 5 s at `pressure` (Pa), N.
fn static_force_after_hold(set: &settings::Buoyancy, name: &str, medium: Medium, pressure: Pascal) -> f64 {
    let delayed = DelayedPressure::of_pressure(set, [0.0, 5.0], &|t| if t < 0.0 { 0.0 } else { pressure });
    buoyancy::static_force(set, name, medium, delayed.pressure_at(5.0))
}

/// Delay of a linear ramp, s.
fn ramp_delay(set: &settings::Buoyancy) -> Second {
    3.0 - DelayedPressure::of_pressure(set, [0.0, 3.0], &|t: Second| t.max(0.0)).pressure_at(3.0)
}
