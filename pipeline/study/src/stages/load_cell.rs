//! Load cell: hammer taps give the transfer function of its fixture; its inverse is applied to an example. Paper: appendix, load cell dynamics.
//!
//! The example is a non-negative thrust whose measurement goes below zero through the fixture's ringing, as in the paper.

use std::path::Path;

use lab::card::{Fixture, FixtureOf};
use serde::{Deserialize, Serialize};
use si::{Hertz, Newton, Second, Series};
use signal::cell::{Cell, Regularisation, identify_from_taps};

use super::tank::read_force;
use crate::records::{self, DeconvolutionExample};
use crate::subject::Specimen;
use diagnostics::{Diagnostic, Result};
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct LoadCell;

/// `[load_cell]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Lowest and highest frequency of the fitted response, Hz.
    band: [Hertz; 2],
    /// Regularisation weight of the inverse: noise power over signal power, no unit.
    weight: f64,
    /// Cut-off frequency: forces are assumed to be slower, Hz.
    cutoff: Hertz,
    /// Flapping frequency of the example thrust, Hz.
    example_frequency: Hertz,
    /// Its peak, N.
    example_peak: Newton,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    /// Number of taps, where the card has it.
    count: Option<usize>,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        let count = |fixture: &Fixture| match fixture.of {
            FixtureOf::Taps { count, .. } => Some(count),
            FixtureOf::StillWater => None,
        };
        Self { count: of.card.fixture.iter().find_map(count).flatten() }
    }
}

impl Stage for LoadCell {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::LoadCell;
    const DESCRIPTION: &'static str = "hammer taps give the transfer function of the load cell's fixture";
    const VERSION: u32 = 4;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let name = &of.card.name;
        let taps = of.card.fixture.iter().filter_map(|f| match &f.of {
            FixtureOf::Taps { hammer, .. } => {
                Some([RawFile::new("taps", name, &f.force), RawFile::new("hammer", name, hammer)])
            }
            FixtureOf::StillWater => None,
        });
        taps.take(1).flatten().collect()
    }

    fn run(card: &Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::LoadCell> {
        let (measured, hammer) = (read_force("taps", context)?, read_force("hammer", context)?);
        let place = context.display_path("taps");
        let found = identify_from_taps(&hammer.series(), &measured.series(), set.band)
            .map_err(|e| Diagnostic::from(e).in_file(Path::new(&place)))?;
        if let Some(count) = card.count.filter(|count| *count != found.taps) {
            let what = format!("{} taps are found in the hammer's log", found.taps);
            let why = format!("the card has count = {count}; a log that was cut has fewer");
            return Err(Diagnostic::file(Path::new(&place), what, why, "copy the logs again, or correct the card"));
        }
        let example = example(found.in_time.cell, measured.rate(), found.noise, set)?;
        Ok(records::LoadCell {
            in_time: found.in_time.into(),
            in_frequency: found.in_frequency.into(),
            taps: found.taps,
            noise: found.noise,
            response: found.response,
            example,
        })
    }
}

/// Samples of the fine thrust for one sample of the cell.
const FINE: usize = 25;
/// Fraction of its period for which a pulse lasts.
const PUSHES: f64 = 0.4;
/// Signal over noise at 40 dB, at which the inverse is evaluated independently of the log's own noise.
const FAINT: f64 = 100.0;
/// Duration of the example, s.
const LONG: Second = 8.0;
/// End of its pulses, s: as in a trial, the log continues until the ringing has decayed.
const PUSHED: Second = 6.0;
/// Duration of the ramps at both ends, s.
const RAMP: Second = 0.5;

/// Two pulses a cycle, each the square of a sine over a fraction of the period: never negative.
fn push(t: Second, set: &Settings) -> Newton {
    let part = (2.0 * set.example_frequency * t).fract();
    let ramp = (t / RAMP).clamp(0.0, 1.0) * ((PUSHED - t) / RAMP).clamp(0.0, 1.0);
    if part < PUSHES { ramp * set.example_peak * (std::f64::consts::PI * part / PUSHES).sin().powi(2) } else { 0.0 }
}

fn example(cell: Cell, rate: Hertz, noise: Newton, set: &Settings) -> Result<DeconvolutionExample> {
    let samples = (LONG * rate) as usize;
    let time: Vec<Second> = (0..samples).map(|i| i as f64 / rate).collect();
    let fine = (0..samples * FINE).map(|i| push(i as f64 / (rate * FINE as f64), set)).collect();
    let fine = Series::new(0.0, rate * FINE as f64, fine)?;
    let clean = cell.simulate(&fine, &time);
    let noisy = |noise: Newton| clean.iter().enumerate().map(|(i, f)| f + noise * crooked(i)).collect::<Vec<_>>();
    let deconvolve = |measured: Vec<Newton>, noise: Newton| -> Result<_> {
        let series = Series::new(0.0, rate, measured)?;
        Ok(cell.deconvolve(&series, noise, Regularisation { weight: set.weight, corner: set.cutoff }))
    };
    let faint = rms(clean.iter().copied()) / FAINT;
    let measured = noisy(noise);
    let (deconvolved, quiet) = (deconvolve(measured.clone(), noise)?, deconvolve(noisy(faint), faint)?);
    let thrust: Vec<Newton> = time.iter().map(|&t| push(t, set)).collect();
    let off = |of: &[f64]| rms(of.iter().zip(&thrust).map(|(a, b)| a - b));
    let mean = thrust.iter().sum::<f64>() / samples as f64;
    let spread = rms(thrust.iter().map(|t| t - mean));
    let nrmse = [&measured[..], deconvolved.force.values(), quiet.force.values()].map(|of| off(of) / spread);
    Ok(DeconvolutionExample {
        time,
        thrust,
        measured,
        deconvolved: deconvolved.force.values().to_vec(),
        sigma: deconvolved.sigma,
        nrmse,
    })
}

/// Deterministic noise of unit size: the example needs no random numbers.
fn crooked(i: usize) -> f64 {
    1.4 * (((i * i) % 97) as f64 * 0.61 + i as f64 * 2.4).sin()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
