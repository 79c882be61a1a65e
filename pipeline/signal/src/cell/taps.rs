//! The fixture from hammer taps: in the frequency domain with coherence, and in the time domain.
//!
//! Frequency: Yᵢ(f) = g H(f) Xᵢ(f) of every tap i at once, white noise in Y (so each frequency counts by |X|²).
//! Time: what the cell would feel of the hammer's force, read at the cell's own samples, plus a drifting zero.
//!
//! Stands on: spectrum, squares. Never knows: which fixture.

use si::{Hertz, Second, Series};

use super::Cell;
use crate::spectrum::{self, Phasor};
use crate::squares::{self, FitFailed};

/// A tap begins where the hammer's force passes this part of its greatest.
const TAP: f64 = 0.2;
/// Two taps are further apart, s.
const APART: Second = 0.5;
/// A tap is looked at from so long before its begin, s.
const BEFORE: Second = 0.05;
/// Degree of the drift of the zero through a whole recording.
const DRIFT: usize = 5;
/// Between the frequencies of the response, Hz.
const STEP: Hertz = 0.25;

/// The measured response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Hz.
    pub frequency: Hertz,
    /// Σ Y X* / Σ |X|² over the taps; no unit.
    pub transfer: Phasor,
    /// |Σ Y X*|² / (Σ |X|² Σ |Y|²), 0 to 1.
    pub coherence: f64,
}

/// A fixture as it was found in one domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The fixture.
    pub cell: Cell,
    /// Standard deviation of the natural frequency, Hz.
    pub frequency_sigma: Hertz,
    /// Standard deviation of the damping ratio.
    pub damping_sigma: f64,
    /// Cell's newtons for a newton of the hammer's.
    pub gain: f64,
}

/// What taps say of a fixture.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// From the time domain, where noise is white: the one to use.
    pub in_time: Estimate,
    /// From the frequency domain.
    pub in_frequency: Estimate,
    /// The measured response, rising in frequency.
    pub response: Vec<Response>,
    /// How many taps.
    pub taps: usize,
    /// Standard deviation of the log before the first tap, about a line; where that is too short, of what the model leaves; N.
    pub noise: f64,
}

/// The fixture from a hammer's force and what the cell felt of it, both in N and on one clock, looked at from `low` to
/// `high` (Hz).
///
/// # Errors
/// [`FitFailed`] when there is no tap, the response has no peak in the band, or a fit does not settle.
pub fn from_taps(hammer: &Series, felt: &Series, [low, high]: [Hertz; 2]) -> Result<Identified, FitFailed> {
    let begins = begins(hammer);
    let nyquist = 0.5 * felt.rate();
    if begins.is_empty() || !(0.0 < low && low < high && high < nyquist) {
        let why = format!("{} taps were found; the band is {low} to {high} Hz, under {nyquist} Hz", begins.len());
        return Err(failed(why));
    }
    let frequencies: Vec<Hertz> = (0..).map(|i| low + STEP * f64::from(i)).take_while(|f| *f <= high).collect();
    let pairs = transforms(hammer, felt, &begins, &frequencies);
    let response = responses(&frequencies, &pairs);
    let peak = response.iter().max_by(|a, b| a.transfer.norm().total_cmp(&b.transfer.norm()));
    let peak = peak.ok_or_else(|| failed("the band holds no frequency".into()))?;
    let start = [peak.frequency, (0.5 / peak.transfer.norm()).clamp(5e-3, 0.3), 1.0];
    let in_frequency = in_frequency(&frequencies, &pairs, &start).ok_or_else(|| unsettled("frequency"))?;
    let start = [in_frequency.cell.natural_frequency, in_frequency.cell.damping_ratio, 1.0];
    let (in_time, noise) = in_time(hammer, felt, &start).ok_or_else(|| unsettled("time"))?;
    let noise = quiet(felt, begins[0]).unwrap_or(noise);
    Ok(Identified { in_time, in_frequency, response, taps: begins.len(), noise })
}

fn failed(why: String) -> FitFailed {
    FitFailed {
        what: "the load cell's fixture",
        why,
        remedy: "tap the fixture five times, two seconds apart, and record both logs on one clock",
    }
}

fn unsettled(domain: &str) -> FitFailed {
    failed(format!("the fit in the {domain} domain does not settle"))
}

/// Standard deviation of a log about a line until shortly before `until` (s); none of fewer than 20 samples.
fn quiet(felt: &Series, until: Second) -> Option<f64> {
    let count = ((until - BEFORE - felt.start()) * felt.rate()).max(0.0) as usize;
    let values = felt.values().get(..count).filter(|v| v.len() >= 20)?;
    let line = squares::drift(count, 1);
    let fit = squares::sum(&line, &squares::linear(&line, values)?);
    let square: f64 = values.iter().zip(fit).map(|(v, f)| (v - f).powi(2)).sum();
    Some((square / (count - 2) as f64).sqrt())
}

/// When each tap begins, s.
fn begins(hammer: &Series) -> Vec<Second> {
    let most = hammer.values().iter().copied().fold(0.0, f64::max);
    let mut found: Vec<Second> = Vec::new();
    for (i, force) in hammer.values().iter().enumerate() {
        let free = found.last().is_none_or(|last| hammer.time(i) - last > APART);
        if *force > TAP * most && most > 0.0 && free {
            found.push(hammer.time(i));
        }
    }
    found
}

/// X and Y of each tap at each frequency, from a tap's begin to the next one's: taps × frequencies.
fn transforms(hammer: &Series, felt: &Series, begins: &[Second], frequencies: &[Hertz]) -> Vec<Vec<[Phasor; 2]>> {
    let shortest = begins.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let length = shortest.min(felt.end() - begins[begins.len() - 1]).min(4.0) - BEFORE;
    let tap = |begin: &Second| {
        let (x, y) = (cut(hammer, begin - BEFORE, length), cut(felt, begin - BEFORE, length));
        let both = |f: &Hertz| [&x, &y].map(|s| spectrum::at(s.values(), s.start() - begin, s.rate(), *f));
        frequencies.iter().map(both).collect()
    };
    begins.iter().map(tap).collect()
}

/// A piece of a series, less the mean of its last fifth, where nothing moves any more.
fn cut(series: &Series, from: Second, length: Second) -> Series {
    let index =
        |t: Second| (((t - series.start()) * series.rate()).ceil().max(0.0) as usize).min(series.values().len() - 1);
    let (first, last) = (index(from), index(from + length));
    let values = &series.values()[first..=last];
    let tail = &values[values.len() - values.len().div_ceil(5)..];
    let rest = tail.iter().sum::<f64>() / tail.len() as f64;
    let values = values.iter().map(|v| v - rest).collect();
    Series::new(series.time(first), series.rate(), values).expect("finite values less a finite mean")
}

fn responses(frequencies: &[Hertz], pairs: &[Vec<[Phasor; 2]>]) -> Vec<Response> {
    let at = |(k, &frequency): (usize, &Hertz)| {
        let cross: Phasor = pairs.iter().map(|tap| tap[k][1] * tap[k][0].conj()).sum();
        let [xx, yy] = [0, 1].map(|which| pairs.iter().map(|tap| tap[k][which].norm_sqr()).sum::<f64>());
        Response { frequency, transfer: cross / xx, coherence: cross.norm_sqr() / (xx * yy) }
    };
    frequencies.iter().enumerate().map(at).collect()
}

fn estimate(fit: &squares::Fitted) -> Estimate {
    let cell = Cell { natural_frequency: fit.at[0], damping_ratio: fit.at[1] };
    Estimate { cell, frequency_sigma: fit.sigma[0], damping_sigma: fit.sigma[1], gain: fit.at[2] }
}

const TURNS: [f64; 3] = [1e-4, 1e-6, 1e-5];

fn cell_of(p: &[f64]) -> Option<Cell> {
    let sound = p[0] > 0.0 && p[1] > 0.0 && p[1] < 0.9;
    sound.then_some(Cell { natural_frequency: p[0], damping_ratio: p[1] })
}

fn in_frequency(frequencies: &[Hertz], pairs: &[Vec<[Phasor; 2]>], start: &[f64; 3]) -> Option<Estimate> {
    let residuals = |p: &[f64]| {
        let cell = cell_of(p)?;
        let transfer: Vec<Phasor> = frequencies.iter().map(|f| p[2] * cell.transfer(*f)).collect();
        let off = pairs.iter().flat_map(|tap| tap.iter().zip(&transfer).map(|([x, y], h)| h * x - y));
        Some(off.flat_map(|d| [d.re, d.im]).collect())
    };
    squares::nonlinear(start, &TURNS, 0, &residuals).map(|fit| estimate(&fit))
}

fn in_time(hammer: &Series, felt: &Series, start: &[f64; 3]) -> Option<(Estimate, f64)> {
    let times: Vec<Second> = (0..felt.values().len()).map(|i| felt.time(i)).collect();
    let drift = squares::drift(times.len(), DRIFT);
    let residuals = |p: &[f64]| {
        let ring = cell_of(p)?.feels(hammer, &times);
        let off: Vec<f64> = ring.iter().zip(felt.values()).map(|(r, f)| f - p[2] * r).collect();
        let zero = squares::sum(&drift, &squares::linear(&drift, &off)?);
        Some(off.iter().zip(zero).map(|(o, z)| o - z).collect())
    };
    let fit = squares::nonlinear(start, &TURNS, DRIFT + 1, &residuals)?;
    Some((estimate(&fit), fit.noise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Noise;
    use std::f64::consts::PI;

    /// Six half-sines of 6 ms and 3 to 6 N, and what a cell at 80 Hz feels of them with noise at `decibel` under its ring.
    fn tapped(cell: Cell, decibel: f64, seed: u64) -> (Series, Series) {
        let mut noise = Noise::new(seed);
        let blows: Vec<(f64, f64)> =
            (1..=6).map(|i| (2.0 * f64::from(i) + 0.1 * noise.unit(), 3.0 + 3.0 * noise.unit())).collect();
        let force = |t: f64| {
            blows
                .iter()
                .filter(|(b, _)| (0.0..6e-3).contains(&(t - b)))
                .map(|(b, p)| p * (PI * (t - b) / 6e-3).sin())
                .sum()
        };
        // four times as fine as the hammer's log: what the cell feels is not made from the log
        let fine = Series::new(0.0, 4000.0, (0..56_000).map(|i| force(f64::from(i) / 4000.0)).collect()).unwrap();
        let times: Vec<f64> = (0..1120).map(|i| f64::from(i) / 80.0).collect();
        let clean = cell.feels(&fine, &times);
        let rms = (clean.iter().map(|v| v * v).sum::<f64>() / clean.len() as f64).sqrt();
        let sigma = rms * 10f64.powf(-decibel / 20.0);
        let felt = clean.iter().zip(&times).map(|(v, t)| v + 0.01 + 2e-3 * t + sigma * noise.normal()).collect();
        let hammer = (0..14_000).map(|i| force(f64::from(i) * 1e-3)).collect();
        (Series::new(0.0, 1000.0, hammer).unwrap(), Series::new(0.0, 80.0, felt).unwrap())
    }

    #[test]
    fn frequency_and_damping_come_back_at_40_decibel_over_a_hundred_seeds() {
        let (mut worst, mut outside) = ([0.0_f64; 4], 0);
        for seed in 0..100 {
            let mut draw = Noise::new(seed + 1000);
            let cell = Cell { natural_frequency: 12.0 + 5.0 * draw.unit(), damping_ratio: 0.02 + 0.02 * draw.unit() };
            let (hammer, felt) = tapped(cell, 40.0, seed);
            let found = from_taps(&hammer, &felt, [3.0, 30.0]).unwrap();
            for (i, it) in [found.in_time, found.in_frequency].iter().enumerate() {
                let frequency = (it.cell.natural_frequency / cell.natural_frequency - 1.0).abs();
                let damping = (it.cell.damping_ratio / cell.damping_ratio - 1.0).abs();
                worst[2 * i] = worst[2 * i].max(frequency);
                worst[2 * i + 1] = worst[2 * i + 1].max(damping);
            }
            let off = (found.in_time.cell.natural_frequency - cell.natural_frequency).abs();
            outside += usize::from(off > 3.0 * found.in_time.frequency_sigma + 1e-3);
        }
        assert!(worst[0] < 0.005 && worst[2] < 0.005, "frequencies in time and frequency: {worst:?}");
        assert!(worst[1] < 0.05 && worst[3] < 0.05, "damping in time and frequency: {worst:?}");
        // 0.3 % lie beyond three standard deviations; a millihertz is what half-sines between samples of 1 ms cost
        assert!(outside <= 3, "{outside} of 100 beyond three standard deviations");
    }

    #[test]
    fn coherence_is_near_one_where_the_fixture_answers_and_falls_with_noise() {
        let cell = Cell { natural_frequency: 14.0, damping_ratio: 0.03 };
        let at_peak = |decibel: f64| {
            let (hammer, felt) = tapped(cell, decibel, 5);
            let found = from_taps(&hammer, &felt, [3.0, 30.0]).unwrap();
            found.response.iter().find(|r| r.frequency == 14.0).unwrap().coherence
        };
        let (hammer, felt) = tapped(cell, 40.0, 5);
        let found = from_taps(&hammer, &felt, [3.0, 30.0]).unwrap();
        let ring = felt.values().iter().map(|v| v * v).sum::<f64>() / felt.values().len() as f64;
        // 40 dB under the ring; 150 samples tell a spread to 6 %
        assert!((found.noise / (0.01 * ring.sqrt()) - 1.0).abs() < 0.25, "{}", found.noise);
        assert!(at_peak(60.0) > 0.999 && at_peak(0.0) < at_peak(60.0));
    }

    #[test]
    fn a_log_without_a_tap_is_refused() {
        let none = Series::new(0.0, 100.0, vec![0.0; 100]).unwrap();
        assert!(from_taps(&none, &none, [3.0, 30.0]).unwrap_err().why.starts_with("0 taps"));
    }
}
