//! Comparisons of the valve: dead times, overshoot, settling, emptying, and the pressure reached in a square wave.

use si::{MILLIBAR, Pascal, Second};

use super::{Comparison, range_of};
use crate::random::RandomStream;
use crate::settings::Valve;
use crate::valve::{Command, Trace, ValveDisturbance, valve_response};

/// Resolution of the times, s.
const STEP: Second = 1e-4;
/// Change of a pressure that counts as the end of the dead time, Pa.
const CHANGE: Pascal = 1.0;
/// Number of seeds.
const SEEDS: u64 = 200;
/// Pressure reached in a square wave of 300 mbar: Hz, mbar. No range was measured; the five values scatter by 6 mbar about a straight line,
/// which is taken as the tolerance.
const REACHED: [(f64, f64); 5] = [(1.0, 276.0), (2.0, 265.0), (3.0, 258.0), (3.5, 245.0), (4.0, 237.0)];
const SCATTER: f64 = 6.0;
/// Initial pressure, mbar, and the measured range of the time constant of emptying, ms.
const EXHAUST: [(f64, [f64; 2]); 3] = [(90.0, [25.0, 29.0]), (190.0, [38.0, 40.0]), (240.0, [44.0, 48.0])];

pub(super) fn valve_comparisons(valve: &Valve) -> Vec<Comparison> {
    let single_value = |quantity: &str, measured, bench: f64| Comparison::new(quantity, measured, [bench; 2]);
    let mut comparisons = vec![
        single_value(
            "fill of 100 mbar: dead time (ms)",
            [70.0, 85.0],
            1e3 * dead_time(&pulse_trace(valve, 100.0, 0), 0.0),
        ),
        single_value(
            "fill of 200 mbar: dead time (ms)",
            [40.0, 45.0],
            1e3 * dead_time(&pulse_trace(valve, 200.0, 0), 0.0),
        ),
        Comparison::new("fill of 100 to 250 mbar: within 5 % after (s)", [0.15, 0.23], fill_times(valve)),
        Comparison::new("fill: overshoot at the valve's port (%)", [0.0, 70.0], overshoot_range(valve)),
        Comparison::new(
            "staircase to 250 mbar: steady difference below the command (mbar)",
            [5.0, 15.0],
            steady_differences(valve),
        ),
        single_value(
            "exhaust of 200 mbar: dead time (ms)",
            [38.0, 58.0],
            1e3 * dead_time(&pulse_trace(valve, 200.0, 0), 5.0),
        ),
    ];
    for (from, measured) in EXHAUST {
        comparisons.push(single_value(
            &format!("exhaust from {from} mbar: time constant (ms)"),
            measured,
            1e3 * exhaust_time_constant(valve, from),
        ));
    }
    for (frequency, mbar) in REACHED {
        let quantity = format!("square wave of 300 mbar at {frequency} Hz: pressure reached (mbar)");
        comparisons.push(single_value(&quantity, [mbar - SCATTER, mbar + SCATTER], reached_pressure(valve, frequency)));
    }
    comparisons
}

/// A command of `mbar` from 0 s to 5 s.
fn pulse_trace(valve: &Valve, mbar: f64, seed: u64) -> Trace {
    let commands = [Command { time: 0.0, pressure: mbar * MILLIBAR }, Command { time: 5.0, pressure: 0.0 }];
    valve_response(valve, &commands, ValveDisturbance::default(), &mut RandomStream::new(seed, "valve"))
}

/// Time after `from` (s) at which a condition holds first, s.
fn first_time(from: Second, holds: impl Fn(Second) -> bool) -> Second {
    (0..50_000).map(|i| STEP * f64::from(i)).find(|t| holds(from + t)).unwrap_or(f64::NAN)
}

fn dead_time(trace: &Trace, from: Second) -> Second {
    let initial_pressure = trace.at(from);
    first_time(from, |t| (trace.at(t) - initial_pressure).abs() > CHANGE)
}

fn fill_times(valve: &Valve) -> [Second; 2] {
    range_of([100.0, 150.0, 200.0, 250.0].map(|mbar| {
        let trace = pulse_trace(valve, mbar, 0);
        first_time(0.0, |t| trace.at(t) > 0.95 * trace.at(4.9))
    }))
}

fn overshoot_range(valve: &Valve) -> [f64; 2] {
    range_of((0..SEEDS).map(|seed| {
        let trace = pulse_trace(valve, 200.0, seed);
        let peak = (0..3000).map(|i| trace.at_valve(STEP * f64::from(i))).fold(0.0, f64::max);
        100.0 * (peak / trace.at(4.9) - 1.0)
    }))
}

/// 50 to 250 mbar in steps of 50, 5 s each, 3 s pauses.
fn steady_differences(valve: &Valve) -> [f64; 2] {
    let levels = [50.0, 100.0, 150.0, 200.0, 250.0];
    let begin = |i: usize| 8.0 * i as f64;
    let step = |(i, mbar): (usize, &f64)| {
        [Command { time: begin(i), pressure: mbar * MILLIBAR }, Command { time: begin(i) + 5.0, pressure: 0.0 }]
    };
    let commands: Vec<Command> = levels.iter().enumerate().flat_map(step).collect();
    let trace = valve_response(valve, &commands, ValveDisturbance::default(), &mut RandomStream::new(0, "valve"));
    range_of(levels.iter().enumerate().map(|(i, mbar)| mbar - trace.at(begin(i) + 4.9) / MILLIBAR))
}

/// Time from `mbar` to 1/e of it.
fn exhaust_time_constant(valve: &Valve, mbar: f64) -> Second {
    let trace = pulse_trace(valve, mbar + valve.droop / MILLIBAR, 0);
    let (full, dead) = (trace.at(5.0), dead_time(&trace, 5.0));
    first_time(5.0 + dead, |t| trace.at(t) < full / std::f64::consts::E)
}

/// Pressure at the end of the last of ten half cycles of one side, mbar.
fn reached_pressure(valve: &Valve, frequency: f64) -> f64 {
    let half =
        |i: u32| Command { time: f64::from(i) * 0.5 / frequency, pressure: f64::from((i + 1) % 2) * 300.0 * MILLIBAR };
    let commands: Vec<Command> = (0..20).map(half).collect();
    let trace = valve_response(valve, &commands, ValveDisturbance::default(), &mut RandomStream::new(0, "valve"));
    trace.at(commands[19].time + valve.dead_exhaust - STEP) / MILLIBAR
}
