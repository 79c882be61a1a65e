//! The load cell's figures: fixture, sampling, noise, drift, steps, the tank's waves, buoyancy and its lag.
//!
//! Stands on: the instruments. Never knows: how they make their logs.

use std::f64::consts::TAU;

use lab::ForceLog;
use lab::card::Medium;
use lab::truth::{TrueForce, TrueWave};
use si::{MILLIBAR, Pascal, Second};

use super::{Figure, range};
use crate::draw::Draw;
use crate::instruments::buoyancy::{self, Late};
use crate::instruments::cell::{self, Run};
use crate::instruments::fixture;
use crate::instruments::tank::{self, Waves};
use crate::settings::{self, Settings};

/// Seeds over which chance is looked at.
const SEEDS: u64 = 100;
/// How long each quiet log is, s.
const LONG: Second = 20.0;
/// Forces of FACTS have three digits, N.
const DIGIT: f64 = 0.0005;
/// Tail, mbar, N after 5 s in water; one number where one was measured.
const STILL: [(&str, f64, [f64; 2]); 8] = [
    ("nemo", 100.0, [0.017, 0.017]),
    ("nemo", 200.0, [0.056, 0.056]),
    ("nemo", 250.0, [0.163, 0.232]),
    ("dory", 300.0, [0.035, 0.035]),
    ("dory", 400.0, [0.070, 0.070]),
    ("dory", 500.0, [0.157, 0.157]),
    ("bruce", 500.0, [0.071, 0.071]),
    ("bruce", 590.0, [0.088, 0.088]),
];

pub(super) fn figures(set: &Settings) -> Vec<Figure> {
    let frequency = |seed| fixture::drawn(&set.cell, &mut Draw::new(seed, "fixture")).omega() / TAU;
    let mut figures =
        vec![Figure::new("fixture: natural frequency (Hz)", [10.0, 20.0], range((0..SEEDS).map(frequency)))];
    figures.extend(amplifier(&set.cell));
    figures.extend(waves(set));
    for (name, mbar, [low, high]) in STILL {
        let quantity = format!("{name} still in water at {mbar} mbar (N)");
        let ours = held(&set.buoyancy, name, Medium::Water, mbar * MILLIBAR);
        figures.push(Figure::new(quantity, [low - DIGIT, high + DIGIT], [ours; 2]));
    }
    let air = STILL.map(|(name, mbar, _)| held(&set.buoyancy, name, Medium::Air, mbar * MILLIBAR));
    figures.push(Figure::new("any tail still in air (N)", [0.0, 0.02], range(air)));
    figures.push(Figure::new("force behind pressure (s)", [0.275, 0.285], [lag(&set.buoyancy); 2]));
    figures
}

/// Logs of nothing, and what is read off them.
fn amplifier(set: &settings::Cell) -> Vec<Figure> {
    let logs = |set: &settings::Cell, medium| (0..SEEDS).map(|seed| quiet(set, medium, seed)).collect::<Vec<_>>();
    let (air, water) = (logs(&settings::Cell { fast: true, ..set.clone() }, Medium::Air), logs(set, Medium::Water));
    let slow = quiet(&settings::Cell { fast: false, ..set.clone() }, Medium::Air, 0).0;
    let noise = |logs: &[(ForceLog, TrueForce)]| range(logs.iter().map(|(log, _)| 1e3 * scatter(&log.force)));
    let drifts = range(air.iter().chain(&water).map(|(_, truth)| 1e3 * truth.drift.abs()));
    vec![
        Figure::new("fast setting: samples a second (Hz)", [79.9, 80.1], [air[0].0.rate(); 2]),
        Figure::new("slow setting: samples a second (Hz)", [10.465, 10.475], [slow.rate(); 2]),
        Figure::new("noise mounted in air (mN)", [0.5, 2.0], noise(&air)),
        Figure::new("noise in water (mN)", [1.0, 3.0], noise(&water)),
        Figure::new("drift of the zero in a run (mN)", [0.0, 45.0], drifts),
        Figure::new("stored to (mN)", [0.999, 1.001], [1e3 * smallest_step(&air[0].0.force); 2]),
    ]
}

fn quiet(set: &settings::Cell, medium: Medium, seed: u64) -> (ForceLog, TrueForce) {
    let mut draw = Draw::new(seed, "quiet");
    let run = Run { id: "quiet", pull: &|_| 0.0, beside: &|_| 0.0, medium, end: LONG };
    let clock = cell::clock(set, &mut draw);
    cell::record(set, fixture::drawn(set, &mut draw), &run, clock, &mut draw)
}

/// Standard deviation from neighbours' differences, which drift does not touch.
fn scatter(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|v| (v[1] - v[0]).powi(2)).sum();
    (0.5 * squares / (values.len() - 1) as f64).sqrt()
}

fn smallest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|v| (v[1] - v[0]).abs());
    steps.filter(|step| *step > 1e-9).fold(f64::INFINITY, f64::min)
}

/// What runs of many lengths leave in the tank, a second later.
fn waves(set: &Settings) -> Vec<Figure> {
    let before = &set.still_water;
    let force = |t: Second| before.force * (TAU * before.frequency * t).sin();
    let left = |seed: u64| {
        let length = before.run + 0.01 * seed as f64;
        Waves::left_by(&set.tank, length, &force, &mut Draw::new(seed, "tank")).true_at(before.wait)
    };
    let left: Vec<Vec<TrueWave>> = (0..SEEDS).map(left).collect();
    let each = range(left.iter().flatten().map(|wave| 1e3 * wave.amplitude));
    let both = range(left.iter().map(|waves| 1e3 * waves[0].amplitude.hypot(waves[1].amplitude)));
    vec![
        Figure::new("tank: first wave (Hz)", [1.0, 1.2], [tank::frequency(&set.tank, 1); 2]),
        Figure::new("tank: second wave (Hz)", [1.8, 2.0], [tank::frequency(&set.tank, 2); 2]),
        Figure::new("tank: a wave a second after a run (mN)", [1.0, 3.0], each),
        Figure::new("tank: both waves together (mN)", [1.4, 3.9], both),
    ]
}

/// After 5 s at `pressure` (Pa), N.
fn held(set: &settings::Buoyancy, name: &str, medium: Medium, pressure: Pascal) -> f64 {
    let late = Late::of(set, [0.0, 5.0], &|t| if t < 0.0 { 0.0 } else { pressure });
    buoyancy::still(set, name, medium, late.at(5.0))
}

/// How much later a steady ramp is seen, s.
fn lag(set: &settings::Buoyancy) -> Second {
    3.0 - Late::of(set, [0.0, 3.0], &|t: Second| t.max(0.0)).at(3.0)
}
