//! Load cell: hammer taps say how its fixture rings, and the inverse is shown at work. Paper: appendix, load cell dynamics.
//!
//! The inverse is shown on a thrust that is never negative, whose cell goes below zero: the paper's point.
//!
//! Stands on: signal. Never knows: a tail.

use lab::card::FixtureOf;
use serde::{Deserialize, Serialize};
use si::{Hertz, Newton, Second, Series};
use signal::cell::{Cell, Regularised, from_taps};

use super::tank::read_force;
use crate::fault::{Fault, Outcome};
use crate::records::{self, Shown};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct LoadCell;

/// `[load_cell]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Lowest and highest frequency at which the response is looked at, Hz.
    band: [Hertz; 2],
    /// Weight of the inverse: noise power over signal power, no unit.
    weight: f64,
    /// Forces are expected to be slower, Hz.
    smooth: Hertz,
    /// Beats a second of the thrust that the inverse is shown on, Hz.
    shown_beat: Hertz,
    /// Its peak, N.
    shown_peak: Newton,
}

impl Stage for LoadCell {
    type Settings = Settings;
    type Needs = ();
    type Makes = records::LoadCell;
    const STORY: &'static str = "taps say how the load cell's fixture rings, and it is undone";
    const EDITION: u32 = 3;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let name = &of.card.name;
        let taps = of.card.fixture.iter().filter_map(|f| match &f.of {
            FixtureOf::Taps { hammer } => {
                Some([RawFile::new("taps", name, &f.force), RawFile::new("hammer", name, hammer)])
            }
            FixtureOf::StillWater => None,
        });
        taps.take(1).flatten().collect()
    }

    fn run(_: &Specimen, set: &Settings, (): (), desk: &dyn Desk) -> Outcome<records::LoadCell> {
        let (felt, hammer) = (read_force("taps", desk)?, read_force("hammer", desk)?);
        let found = from_taps(&hammer.series(), &felt.series(), set.band)
            .map_err(|e| Fault::from_tool(format!("{}: {e}", desk.place("taps"))))?;
        let shown = shown(found.in_time.cell, felt.rate(), found.noise, set)?;
        Ok(records::LoadCell {
            in_time: found.in_time.into(),
            in_frequency: found.in_frequency.into(),
            taps: found.taps,
            noise: found.noise,
            response: found.response,
            shown,
        })
    }
}

/// Samples of the fine thrust for one of the cell's.
const FINE: usize = 25;
/// Part of its time for which a push lasts.
const PUSHES: f64 = 0.4;
/// Signal over noise at 40 dB, where the inverse is judged apart from the log's own noise.
const FAINT: f64 = 100.0;
/// How long what is shown lasts, s.
const LONG: Second = 8.0;
/// When its pushes end, s: as in a trial, the log runs on until the fixture has rung down.
const PUSHED: Second = 6.0;
/// How long the pushes take to begin and to end, s.
const RAMP: Second = 0.5;

/// Two pushes a beat, each the square of a sine over a part of its time, never negative.
fn push(t: Second, set: &Settings) -> Newton {
    let part = (2.0 * set.shown_beat * t).fract();
    let ramp = (t / RAMP).clamp(0.0, 1.0) * ((PUSHED - t) / RAMP).clamp(0.0, 1.0);
    if part < PUSHES { ramp * set.shown_peak * (std::f64::consts::PI * part / PUSHES).sin().powi(2) } else { 0.0 }
}

fn shown(cell: Cell, rate: Hertz, noise: Newton, set: &Settings) -> Outcome<Shown> {
    let samples = (LONG * rate) as usize;
    let time: Vec<Second> = (0..samples).map(|i| i as f64 / rate).collect();
    let fine = (0..samples * FINE).map(|i| push(i as f64 / (rate * FINE as f64), set)).collect();
    let fine = Series::new(0.0, rate * FINE as f64, fine).map_err(Fault::from_tool)?;
    let clean = cell.feels(&fine, &time);
    let noisy = |noise: Newton| clean.iter().enumerate().map(|(i, f)| f + noise * crooked(i)).collect::<Vec<_>>();
    let undo = |felt: Vec<Newton>, noise: Newton| {
        let series = Series::new(0.0, rate, felt).map_err(Fault::from_tool)?;
        Ok(cell.undo(&series, noise, Regularised { weight: set.weight, smooth: set.smooth }))
    };
    let faint = rms(clean.iter().copied()) / FAINT;
    let felt = noisy(noise);
    let (undone, quiet) = (undo(felt.clone(), noise)?, undo(noisy(faint), faint)?);
    let thrust: Vec<Newton> = time.iter().map(|&t| push(t, set)).collect();
    let off = |of: &[f64]| rms(of.iter().zip(&thrust).map(|(a, b)| a - b));
    let mean = thrust.iter().sum::<f64>() / samples as f64;
    let spread = rms(thrust.iter().map(|t| t - mean));
    let nrmse = [&felt[..], undone.force.values(), quiet.force.values()].map(|of| off(of) / spread);
    Ok(Shown { time, thrust, felt, undone: undone.force.values().to_vec(), sigma: undone.sigma, nrmse })
}

/// Noise of unit size whose signs come from a fixed, crooked rule: a picture needs no draw.
fn crooked(i: usize) -> f64 {
    1.4 * (((i * i) % 97) as f64 * 0.61 + i as f64 * 2.4).sin()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
