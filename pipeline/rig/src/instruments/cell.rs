//! The load cell: from the forces on fixture and cell to the force log.
//!
//! log time = offset + scale × true time. A sample is the force on the cell at its time; the force on the fixture is piecewise linear over steps
//! of a quarter of a millisecond.

use lab::ForceLog;
use lab::card::Medium;
use lab::truth::TrueForce;
use si::{Newton, Second};

use super::amplifier::Amplifier;
use super::fixture::Fixture;
use super::oscillator::Oscillator;
use crate::pressure_log::Clock;
use crate::random::RandomStream;
use crate::script::Script;
use crate::settings;

/// Longest interval over which the force on the fixture is linear, s.
const STEP: Second = 2.5e-4;
/// Digits of time in the log.
const TIME_DIGITS: f64 = 1e6;
/// And of the lamp.
const LAMP_DIGITS: f64 = 1e3;

/// One run of the load cell.
pub(crate) struct Run<'a> {
    /// The trial's or the fixture's id.
    pub(crate) id: &'a str,
    /// The fixture on the cell.
    pub(crate) fixture: Oscillator,
    /// The amplifier's clock.
    pub(crate) clock: Clock,
    /// Force on the fixture at a true time (s), N, positive forwards.
    pub(crate) pull: &'a dyn Fn(Second) -> Newton,
    /// Force on the cell that does not act through the fixture, N: waves, buoyancy.
    pub(crate) beside: &'a dyn Fn(Second) -> Newton,
    /// Air or water.
    pub(crate) medium: Medium,
    /// End of the log in true time, s.
    pub(crate) end: Second,
}

/// The amplifier's clock, drawn within the settings' ranges.
pub(crate) fn draw_clock(set: &settings::Cell, random: &mut RandomStream) -> Clock {
    let scale = 1.0 + random.uniform([-set.clock_drift, set.clock_drift]);
    Clock { offset: random.uniform(set.offset), scale }
}

/// The log of `run`, and its ground truth.
pub(crate) fn record_run(set: &settings::Cell, run: &Run, random: &mut RandomStream) -> (ForceLog, TrueForce) {
    let clock = run.clock;
    let rate = set.rates[usize::from(!set.fast)];
    let samples = ((clock.offset + clock.scale * run.end) * rate) as usize;
    let noise = if run.medium == Medium::Air { set.noise_in_air } else { set.noise_in_water };
    let amplifier = Amplifier::draw_amplifier(set, noise, samples, random);
    let mut log = ForceLog::default();
    let (mut fixture, mut before) = (Fixture::at_rest(run.fixture), -clock.offset / clock.scale);
    for i in 0..samples {
        let now = (i as f64 / rate - clock.offset) / clock.scale;
        let force = transmitted_force(&mut fixture, run.pull, [before, now]) + (run.beside)(now);
        log.time.push((i as f64 / rate * TIME_DIGITS).round() / TIME_DIGITS);
        log.force.push(amplifier.stored_value(i, force, random));
        before = now;
    }
    let (zero, drift) = (amplifier.zero.first().copied().unwrap_or(0.0), amplifier.zero_drift());
    let (id, noise) = (run.id.to_owned(), amplifier.noise);
    let (clock_offset, clock_scale) = (clock.offset, clock.scale);
    let (forces, taps, waves) = (None, Vec::new(), Vec::new());
    (log, TrueForce { id, clock_offset, clock_scale, zero, drift, noise, forces, taps, waves })
}

/// The lamp in the amplifier's second channel at `times` (s, its own clock): the mean over one sampling interval.
pub(crate) fn lamp_channel(set: &settings::Cell, clock: Clock, times: &[Second], script: &Script) -> Vec<f64> {
    let half = 0.5 / (set.rates[usize::from(!set.fast)] * clock.scale);
    let brightness = |t: &Second| script.lamp_share((t - clock.offset) / clock.scale, half);
    times.iter().map(|t| (brightness(t) * LAMP_DIGITS).round() / LAMP_DIGITS).collect()
}

/// The force that the fixture transmits at the end of an interval.
fn transmitted_force(fixture: &mut Fixture, pull: &dyn Fn(Second) -> Newton, [from, to]: [Second; 2]) -> Newton {
    let steps = ((to - from) / STEP).ceil().max(1.0) as usize;
    let step = (to - from).max(1e-9) / steps as f64;
    (1..=steps).fold(0.0, |_, i| fixture.transmit_force(pull(from + step * i as f64), step))
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
        let fixture = Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03);
        let run = Run { id: "run", fixture, clock, pull, beside: &|_| 0.0, medium: Medium::Air, end: 6.0 };
        record_run(set, &run, &mut RandomStream::new(2, "cell")).0
    }

    #[test]
    fn a_tap_excites_a_free_decay_with_the_fixture_s_frequency_and_the_tap_s_impulse() {
        let it = Oscillator::tuned(0.3, std::f64::consts::TAU * 14.0, 0.03);
        // a half-sine of 4 ms about 1.002 s, of 0.01 N s
        let wave = |t: Second| 1.25 * std::f64::consts::PI * (250.0 * std::f64::consts::PI * (t - 1.0)).sin();
        let (tap, begin) = (|t: Second| if (1.0..1.004).contains(&t) { wave(t) } else { 0.0 }, 1.002);
        let log = recorded(&quiet(true), Clock { offset: 0.0, scale: 1.0 }, &tap);
        let (decay, frequency) = it.decay_and_frequency();
        for (t, f) in log.time.iter().zip(&log.force).filter(|(t, _)| **t > 1.01) {
            let (s, speed) = (t - begin, 0.01 / it.mass);
            let (sin, cos) = (frequency * s).sin_cos();
            let [displacement, velocity] = [speed / frequency * sin, speed * (cos - decay / frequency * sin)];
            let free = (-decay * s).exp() * (it.stiffness * displacement + it.damping * velocity);
            // of the first amplitude of 0.88 N: 0.3 % from the finite contact time, 0.3 % from piecewise linear steps
            assert!((f - free).abs() < 0.01 * 0.88, "{f} for {free} at {t} s");
        }
    }

    #[test]
    fn samples_have_the_selected_rate_on_the_amplifier_s_own_clock() {
        let slope = |t: Second| 0.1 * t.max(0.0);
        for (fast, rate) in [(true, 80.0), (false, 10.47)] {
            let log = recorded(&quiet(fast), Clock { offset: 0.5, scale: 1.01 }, &slope);
            assert!((log.rate() - rate).abs() < 1e-3, "{}", log.rate());
            let (t, f) = (log.time[log.time.len() - 1], log.force[log.force.len() - 1]);
            // a ramp is transmitted unchanged once the transient has decayed: (b s + k)/(m s² + b s + k) is 1 + O(s²)
            assert!((f - slope((t - 0.5) / 1.01)).abs() < 1e-4, "{f} N at {t} s");
        }
    }

    #[test]
    fn a_log_is_reproducible_and_depends_on_the_seed() {
        let set = Settings::built_in().cell;
        let clock = Clock { offset: 0.5, scale: 1.0 };
        let fixture = Oscillator::tuned(0.3, 88.0, 0.03);
        let run = Run { id: "run", fixture, clock, pull: &|_| 0.0, beside: &|_| 0.0, medium: Medium::Water, end: 3.0 };
        let log = |seed| record_run(&set, &run, &mut RandomStream::new(seed, "cell")).0;
        assert_eq!(log(4), log(4));
        assert_ne!(log(4), log(5));
    }
}
