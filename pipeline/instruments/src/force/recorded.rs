//! The logs of a recording on one clock, that of the force.

use std::path::Path;

use diagnostics::{Diagnostic, Result, input};
use lab::card::LogKind;
use lab::pressure::Layout;
use lab::{Logged, Sampling};
use si::{Pascal, Second, Series};
use signal::clock::Clock;
use signal::edge::{self, Edge, Window};
use signal::resample::Samples;

use super::page::{Page, Recording};

/// Force and pressures on the clock of the force, which is earlier than stamped by the cell's own lag.
pub(super) struct Recorded {
    pub force: Series,
    /// One a channel, Pa; none without a pressure log.
    pub pressures: Vec<Samples>,
    /// How the force was sampled.
    pub sampling: Sampling,
}

/// A log of one force instrument.
///
/// # Errors
/// A [`Diagnostic`] when it cannot be read.
pub(super) fn force_log(page: &Page, file: &Path, kind: LogKind) -> Result<Logged<lab::ForceLog>> {
    lab::force::parse_as(&read_text(file)?, file, (kind, &page.log))
}

/// The load cell's log of taps.
///
/// # Errors
/// As [`force_log`].
pub(super) fn tap_log(page: &Page, file: &Path) -> Result<Logged<lab::ForceLog>> {
    lab::force::parse_taps(&read_text(file)?, file, &page.log)
}

fn read_text(file: &Path) -> Result<String> {
    let bytes = input::read(file, input::LOG)
        .map_err(|e| Diagnostic::io(file, e, "put the log there, or correct its name on the page"))?;
    lab::log::decoded(bytes, file)
}

impl Recorded {
    /// The logs of a recording; files are relative to `folder`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a log cannot be read, or the lamps of both do not belong together.
    pub(super) fn read(page: &Page, recording: &Recording, folder: &Path) -> Result<Self> {
        let Logged { log, sampling } = force_log(page, &folder.join(&recording.force), LogKind::Force)?;
        let lag = page.log.force_lag.unwrap_or(0.0);
        let shifted = Series::new(log.time[0] - lag, log.rate(), log.force.clone())?;
        let file = recording.pressure.as_ref().map(|file| folder.join(file));
        let pressures = file.map_or(Ok(Vec::new()), |file| pressure_samples(page, &file, &log))?;
        Ok(Self { force: shifted, pressures, sampling })
    }

    /// First and last time at which a pressure exceeds a tenth of the highest, s; none without a pressure log.
    pub(super) fn pressed_interval(&self) -> Option<[Second; 2]> {
        let highest = self.pressures.iter().flat_map(Samples::values).copied().fold(0.0, f64::max);
        let pressed_times = |samples: &Samples| -> Vec<Second> {
            let samples_in_time = samples.times().iter().zip(samples.values());
            samples_in_time.filter(|(_, p)| **p > 0.1 * highest && highest > 0.0).map(|(t, _)| *t).collect()
        };
        let times: Vec<Second> = self.pressures.iter().flat_map(pressed_times).collect();
        let first = times.iter().copied().reduce(f64::min)?;
        Some([first, times.iter().copied().reduce(f64::max)?])
    }
}

/// The channels of a pressure log on the clock of a force log: by their lamps where both have one that lights, else on one clock.
fn pressure_samples(page: &Page, file: &Path, force: &lab::ForceLog) -> Result<Vec<Samples>> {
    let log = lab::pressure::parse_measured(
        &read_text(file)?,
        file,
        Layout { channels: &page.channels, lamp: false, log: &page.log },
    )?
    .log;
    let pressure_edges = lamp_edges(&log.led, &log.time);
    let force_edges = lamp_edges(&force.led, &force.time);
    let clock = match (pressure_edges.is_empty(), force_edges.is_empty()) {
        (false, false) => {
            Clock::from_edges(&pressure_edges, &force_edges).map_err(|e| Diagnostic::from(e).in_file(file))?
        }
        _ => Clock::SAME,
    };
    let times: Vec<Second> = log.time.iter().map(|t| clock.there(*t)).collect();
    let channel = |values: &[Pascal]| Samples::new(times.clone(), values.to_vec()).map_err(Diagnostic::from);
    log.channels.iter().map(|entry| channel(&entry.measured)).collect()
}

/// Times of the edges of a lamp, s; none where there is no such column, or it never changes.
fn lamp_edges(led: &[f64], time: &[Second]) -> Vec<Second> {
    if led.is_empty() {
        return Vec::new();
    }
    let edges = edge::edges_at(time, led, |_| Window::INSTANT).unwrap_or_default();
    edges.iter().map(|edge: &Edge| edge.time).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed_interval(channels: &[&[f64]]) -> Option<[Second; 2]> {
        let samples = |values: &&[f64]| {
            let times = (0..values.len()).map(|i| 0.5 * i as f64).collect();
            Samples::new(times, values.to_vec()).unwrap()
        };
        let force = Series::new(0.0, 1.0, vec![0.0; 2]).unwrap();
        Recorded { force, pressures: channels.iter().map(samples).collect(), sampling: Sampling::default() }
            .pressed_interval()
    }

    #[test]
    fn a_run_lasts_while_a_pressure_exceeds_a_tenth_of_the_highest() {
        // one channel at a tenth does not exceed it; the other one rises later and falls last
        let (left, right) = ([0.0, 1e3, 5e3, 0.0, 0.0, 0.0, 1e3], [0.0, 0.0, 0.0, 0.0, 1e4, 1.1e3, 0.0]);
        assert_eq!(pressed_interval(&[&left, &right]), Some([1.0, 2.5]));
        assert_eq!(pressed_interval(&[&left]), Some([0.5, 3.0]), "a fifth of what is then the highest");
        assert_eq!(pressed_interval(&[&[0.0, 0.0]]), None, "no pressure rises");
        assert_eq!(pressed_interval(&[]), None);
    }
}
