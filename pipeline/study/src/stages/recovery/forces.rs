//! Errors of the force instruments: the load cell's frequency and the waves left in a log.

use lab::truth;
use si::Second;

use super::Virtual;
use records::{CorrectedForce, LoadCell, Recovered, Tank};
use workflow::needs::Every;

/// Updates the largest errors with those of a specimen's force instruments.
pub(super) fn judge_forces(
    recovered: &mut Recovered,
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(cells), Every(tanks), Every(pulls)): &(Every<LoadCell>, Every<Tank>, Every<CorrectedForce>),
) {
    let worse = |old: Option<f64>, new: f64| Some(old.map_or(new, |old| old.max(new)));
    for ((_, cell), hidden) in cells.iter().filter(|(s, _)| s.0 == specimen.name).zip(&truth.cell) {
        let frequency = (hidden.stiffness / hidden.mass).sqrt() / std::f64::consts::TAU;
        let error = 100.0 * (cell.in_time.natural_frequency_hz / frequency - 1.0).abs();
        recovered.load_cell_frequency_error_percent = worse(recovered.load_cell_frequency_error_percent, error);
    }
    for (_, tank) in tanks.iter().filter(|(s, _)| s.0 == specimen.name) {
        let still = specimen.still_water.as_ref();
        let Some(hidden) = still.and_then(|id| truth.force.iter().find(|t| t.id == *id)) else { continue };
        for (found, real) in wave_pairs(tank, &hidden.waves) {
            let part = |turn: fn(f64) -> f64| found.amplitude * turn(found.phase) - real.amplitude * turn(real.phase);
            let residual = part(f64::cos).hypot(part(f64::sin));
            recovered.wave_residual_mn = worse(recovered.wave_residual_mn, 1e3 * residual);
        }
        for (trial, pull) in pulls.iter() {
            let Some(id) = specimen.trials.iter().find(|id| specimen.trial_subject(id) == *trial) else { continue };
            let waves = truth.force.iter().find(|t| t.id == *id).map_or(&[][..], |t| &t.waves);
            if !waves.is_empty() {
                let residual = 1e3 * wave_residual(pull, waves, tank);
                recovered.wave_residual_mn = worse(recovered.wave_residual_mn, residual);
            }
        }
    }
}

/// Each wave that was found, with the true one nearest to its frequency.
fn wave_pairs<'a>(
    tank: &'a Tank,
    real: &'a [truth::TrueWave],
) -> impl Iterator<Item = (&'a signal::wave::Wave, &'a truth::TrueWave)> {
    let frequency_difference = |found: f64, wave: &truth::TrueWave| (wave.frequency - found).abs();
    tank.waves.iter().filter_map(move |found| {
        let by_frequency = |a: &&truth::TrueWave, b: &&truth::TrueWave| {
            frequency_difference(found.frequency, a).total_cmp(&frequency_difference(found.frequency, b))
        };
        real.iter().min_by(by_frequency).map(|real| (found, real))
    })
}

/// Root mean square residual of a trial's standing waves after their removal, N. The decay of a true wave is taken as identified.
fn wave_residual(pull: &CorrectedForce, waves: &[truth::TrueWave], tank: &Tank) -> f64 {
    let first = pull.time[0];
    let real = |t: Second| -> f64 {
        let decaying_wave = |(found, real): (&signal::wave::Wave, &truth::TrueWave)| {
            let angle = std::f64::consts::TAU * real.frequency * t + real.phase;
            real.amplitude * (-found.decay * t).exp() * angle.cos()
        };
        wave_pairs(tank, waves).map(decaying_wave).sum()
    };
    let squares = pull.time.iter().zip(&pull.waves).map(|(t, found)| (found - real(t - first)).powi(2));
    (squares.sum::<f64>() / pull.time.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(frequency: f64, decay: f64) -> signal::wave::Wave {
        let (amplitude, phase) = (0.0, 0.0);
        signal::wave::Wave { frequency, frequency_sigma: 0.01, decay, decay_sigma: 0.01, amplitude, phase }
    }

    fn tank(waves: Vec<signal::wave::Wave>) -> Tank {
        let (noise, suppression_db, sampling) = (0.0, 0.0, lab::Sampling::default());
        Tank { waves, evidence: Vec::new(), level: 0.01, noise, suppression_db, size_m: [1.0, 0.5], sampling }
    }

    /// A log from 3 s on with these waves in it.
    fn pull(waves: Vec<f64>) -> CorrectedForce {
        let time: Vec<f64> = (0..waves.len()).map(|i| 3.0 + 0.01 * i as f64).collect();
        let none = vec![0.0; waves.len()];
        let (raw, zero, sampling) = (none.clone(), none, lab::Sampling::default());
        let (commanded, lag, warnings) = ([0.0; 2], [0.0; 2], Vec::new());
        CorrectedForce { time, raw, waves, zero, offset: 0.0, commanded, lag, sampling, warnings }
    }

    #[test]
    fn waves_that_were_removed_as_they_are_leave_nothing() {
        let real = [(0.9, 2e-3, 0.4), (1.9, 1e-3, -1.0)].map(|(f, a, p)| truth::TrueWave {
            frequency: f,
            amplitude: a,
            phase: p,
        });
        let tank = tank(vec![wave(0.91, 0.05), wave(1.88, 0.1)]);
        let hidden = |i: usize| {
            let t = 0.01 * i as f64;
            let one = |(w, decay): (&truth::TrueWave, f64)| {
                w.amplitude * (-decay * t).exp() * (std::f64::consts::TAU * w.frequency * t + w.phase).cos()
            };
            real.iter().zip([0.05, 0.1]).map(one).sum::<f64>()
        };
        let exact: Vec<f64> = (0..400).map(hidden).collect();
        assert!(wave_residual(&pull(exact.clone()), &real, &tank) < 1e-15);
        let off: Vec<f64> = exact.iter().enumerate().map(|(i, w)| w + if i % 2 == 0 { 3e-4 } else { -3e-4 }).collect();
        assert!((wave_residual(&pull(off), &real, &tank) - 3e-4).abs() < 1e-15);
    }
}
