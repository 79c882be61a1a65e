//! The load cell: from the force on the fixture, and what comes beside it, to the force log.
//!
//! log time = offset + scale × true time. A sample is what the cell feels at its instant; the force is straight between
//! steps of a quarter of a millisecond.
//!
//! Stands on: the fixture, the amplifier, `lab` (the log). Never knows: whose force it is.

use lab::ForceLog;
use lab::card::Medium;
use lab::truth::TrueForce;
use si::{Newton, Second};

use super::amplifier::Amplifier;
use super::fixture::Fixture;
use super::oscillator::Oscillator;
use crate::draw::Draw;
use crate::logger::Clock;
use crate::script::Script;
use crate::settings;

/// The force on the fixture is taken as straight over at most this, s.
const STEP: Second = 2.5e-4;
/// Digits that the log has of time.
const TIME_DIGITS: f64 = 1e6;
/// And of the lamp.
const LAMP_DIGITS: f64 = 1e3;

/// What acts during a run.
pub struct Run<'a> {
    /// The trial's or the fixture's id.
    pub id: &'a str,
    /// Force on the fixture at a true time (s), N, positive forwards.
    pub pull: &'a dyn Fn(Second) -> Newton,
    /// What reaches the cell and not through the mass, N: waves, buoyancy.
    pub beside: &'a dyn Fn(Second) -> Newton,
    /// Where.
    pub medium: Medium,
    /// When the log ends, true time, s.
    pub end: Second,
}

/// The amplifier's clock, drawn within the settings' ranges.
pub fn clock(set: &settings::Cell, draw: &mut Draw) -> Clock {
    let scale = 1.0 + draw.between([-set.clock_drift, set.clock_drift]);
    Clock { offset: draw.between(set.offset), scale }
}

/// The log of `run`, and what is hidden in it.
pub fn record(
    set: &settings::Cell,
    fixture: Oscillator,
    run: &Run,
    clock: Clock,
    draw: &mut Draw,
) -> (ForceLog, TrueForce) {
    let rate = set.rates[usize::from(!set.fast)];
    let samples = ((clock.offset + clock.scale * run.end) * rate) as usize;
    let noise = if run.medium == Medium::Air { set.noise_in_air } else { set.noise_in_water };
    let amplifier = Amplifier::drawn(set, noise, samples, draw);
    let mut log = ForceLog::default();
    let (mut fixture, mut before) = (Fixture::at_rest(fixture), -clock.offset / clock.scale);
    for i in 0..samples {
        let now = (i as f64 / rate - clock.offset) / clock.scale;
        let felt = felt(&mut fixture, run.pull, [before, now]) + (run.beside)(now);
        log.time.push((i as f64 / rate * TIME_DIGITS).round() / TIME_DIGITS);
        log.force.push(amplifier.store(i, felt, draw));
        before = now;
    }
    let (zero, drift) = (amplifier.zero.first().copied().unwrap_or(0.0), amplifier.drift());
    let (id, noise) = (run.id.to_owned(), amplifier.noise);
    let (clock_offset, clock_scale) = (clock.offset, clock.scale);
    let (forces, taps, waves) = (None, Vec::new(), Vec::new());
    (log, TrueForce { id, clock_offset, clock_scale, zero, drift, noise, forces, taps, waves })
}

/// What the amplifier's second channel says of the lamp at `times` (s, its own clock): the mean over one sampling interval.
pub fn lamp(set: &settings::Cell, clock: Clock, times: &[Second], script: &Script) -> Vec<f64> {
    let half = 0.5 / (set.rates[usize::from(!set.fast)] * clock.scale);
    let drive = |t: &Second| script.lamp((t - clock.offset) / clock.scale, half);
    times.iter().map(|t| (drive(t) * LAMP_DIGITS).round() / LAMP_DIGITS).collect()
}

/// What the fixture hands on at the end of an interval.
fn felt(fixture: &mut Fixture, pull: &dyn Fn(Second) -> Newton, [from, to]: [Second; 2]) -> Newton {
    let steps = ((to - from) / STEP).ceil().max(1.0) as usize;
    let step = (to - from).max(1e-9) / steps as f64;
    (1..=steps).fold(0.0, |_, i| fixture.feel(pull(from + step * i as f64), step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn quiet(fast: bool) -> settings::Cell {
        let set = Settings::built_in().cell;
        settings::Cell { ramp: 0.0, wander: 0.0, noise_in_air: [0.0; 2], quantum: 1e-9, fast, ..set }
    }

    fn recorded(set: &settings::Cell, clock: Clock, pull: &dyn Fn(Second) -> Newton) -> ForceLog {
        let run = Run { id: "run", pull, beside: &|_| 0.0, medium: Medium::Air, end: 6.0 };
        let fixture = Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03);
        record(set, fixture, &run, clock, &mut Draw::new(2, "cell")).0
    }

    #[test]
    fn a_blow_rings_on_with_the_fixture_s_frequency_and_impulse() {
        let it = Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03);
        // a half-sine of 4 ms about 1.002 s, of 0.01 N s
        let wave = |t: Second| 1.25 * std::f64::consts::PI * (250.0 * std::f64::consts::PI * (t - 1.0)).sin();
        let (blow, begin) = (|t: Second| if (1.0..1.004).contains(&t) { wave(t) } else { 0.0 }, 1.002);
        let log = recorded(&quiet(true), Clock { offset: 0.0, scale: 1.0 }, &blow);
        let (decay, beat) = it.decay_and_beat();
        for (t, f) in log.time.iter().zip(&log.force).filter(|(t, _)| **t > 1.01) {
            let (s, speed) = (t - begin, 0.01 / it.mass);
            let (sin, cos) = (beat * s).sin_cos();
            let [place, quick] = [speed / beat * sin, speed * (cos - decay / beat * sin)];
            let free = (-decay * s).exp() * (it.stiffness * place + it.damping * quick);
            // of the first swing of 0.88 N: 0.3 % because a blow is no instant, 0.3 % because steps are straight
            assert!((f - free).abs() < 0.01 * 0.88, "{f} for {free} at {t} s");
        }
    }

    #[test]
    fn samples_come_at_the_rate_that_is_set_and_on_the_amplifier_s_own_clock() {
        let slope = |t: Second| 0.1 * t.max(0.0);
        for (fast, rate) in [(true, 80.0), (false, 10.47)] {
            let log = recorded(&quiet(fast), Clock { offset: 0.5, scale: 1.01 }, &slope);
            assert!((log.rate() - rate).abs() < 1e-3, "{}", log.rate());
            let (t, f) = (log.time[log.time.len() - 1], log.force[log.force.len() - 1]);
            // a ramp is handed on as it is once the start has rung down: (b s + k)/(m s² + b s + k) is 1 + O(s²)
            assert!((f - slope((t - 0.5) / 1.01)).abs() < 1e-4, "{f} N at {t} s");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_log_and_another_another() {
        let set = Settings::built_in().cell;
        let clock = Clock { offset: 0.5, scale: 1.0 };
        let run = Run { id: "run", pull: &|_| 0.0, beside: &|_| 0.0, medium: Medium::Water, end: 3.0 };
        let log = |seed| record(&set, Oscillator::tuned(0.3, 88.0, 0.03), &run, clock, &mut Draw::new(seed, "cell")).0;
        assert_eq!(log(4), log(4));
        assert_ne!(log(4), log(5));
    }
}
