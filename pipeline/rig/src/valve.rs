//! The valve and its hose: the pressure in a chamber for a sequence of commands.
//!
//! After a dead time the pressure follows the command as a first-order lag, p' = (target − p) / τ. It settles below the command, and the
//! more often the side is filled the lower, because the supply pressure drops. The time constant of emptying grows with the pressure.
//! During a fill a gauge at the valve's port also reads the pressure loss of the hose: a burst that overshoots for a few milliseconds
//! and does not reach the chamber. Commands are piecewise constant, so every piece is a sum of exponentials in closed form; the burst
//! term is present at the port only:
//!
//! p(t) = target + (begin − target) exp(−s/τ) + burst (exp(−s/fall) − exp(−s/rise)),  s = t − start

use si::{Pascal, Second};

use crate::random::RandomStream;
use crate::settings::Valve;

/// From `time` on, `pressure` is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// s.
    pub time: Second,
    /// Pa.
    pub pressure: Pascal,
}

/// The pressure in a chamber during a trial, in closed form.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace(Vec<Piece>);

/// From `start` on, until the next piece.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: Second,
    begin: Pascal,
    target: Pascal,
    lag: Second,
    burst: Pascal,
    rise: Second,
    fall: Second,
}

impl Piece {
    fn pressure_at(&self, t: Second) -> Pascal {
        self.target + (self.begin - self.target) * (-(t - self.start) / self.lag).exp()
    }

    fn at_valve(&self, t: Second) -> Pascal {
        let s = t - self.start;
        self.pressure_at(t) + self.burst * ((-s / self.fall).exp() - (-s / self.rise).exp())
    }
}

/// Deviations of the valve from its nominal behaviour in one run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ValveDisturbance {
    /// Relative error of the regulated pressure, no unit.
    pub supply: f64,
    /// Greatest timing error of each switching, either way, s.
    pub jitter: Second,
}

/// The chamber pressure under `commands` (in ascending time, from ambient pressure) in a run with `disturbance`; `random` draws the
/// overshoot of each fill and the timing error of each switching.
pub fn valve_response(
    valve: &Valve,
    commands: &[Command],
    disturbance: ValveDisturbance,
    random: &mut RandomStream,
) -> Trace {
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut previous_command, mut filled) = (0.0, f64::NEG_INFINITY);
    for command in commands {
        let fills = command.pressure > previous_command;
        let dead = if fills { dead_fill(valve, command.pressure) } else { valve.dead_exhaust };
        let last = pieces.last().map_or(f64::NEG_INFINITY, |p| p.start);
        let late = random.uniform([-disturbance.jitter, disturbance.jitter]);
        // a short pulse must not end before it has begun: pieces stay in ascending order
        let start = (command.time + dead + late).max(last);
        let begin = pieces.last().map_or(0.0, |p| p.pressure_at(start));
        if fills {
            let regulated = command.pressure * (1.0 + disturbance.supply);
            let target = settled_pressure(valve, regulated, 1.0 / (command.time - filled));
            pieces.push(fill_piece(valve, start, [begin, target], random.uniform(valve.overshoot)));
            filled = command.time;
        } else {
            pieces.push(exhaust_piece(valve, start, [begin, settled_pressure(valve, command.pressure, 0.0)]));
        }
        previous_command = command.pressure;
    }
    Trace(pieces)
}

/// A fill that overshoots by the fraction `overshoot` of its step. The burst peaks at s = ln(fall/rise) / (1/rise − 1/fall); it is
/// scaled so that lag and burst together reach the overshoot there. The maximum of the sum differs from that by less than 1 %.
fn fill_piece(valve: &Valve, start: Second, [begin, target]: [Pascal; 2], overshoot: f64) -> Piece {
    let [rise, fall] = valve.burst;
    let peak = (fall / rise).ln() / (1.0 / rise - 1.0 / fall);
    let height = (-peak / fall).exp() - (-peak / rise).exp();
    let burst = (target - begin) * (overshoot + (-peak / valve.fill).exp()) / height;
    Piece { start, begin, target, lag: valve.fill, burst, rise, fall }
}

fn exhaust_piece(valve: &Valve, start: Second, [begin, target]: [Pascal; 2]) -> Piece {
    let [rise, fall] = valve.burst;
    let lag = valve.exhaust[0] + valve.exhaust[1] * begin.max(0.0);
    Piece { start, begin, target, lag, burst: 0.0, rise, fall }
}

/// The dead time before a fill to `pressure` (Pa), s.
fn dead_fill(valve: &Valve, pressure: Pascal) -> Second {
    let [[low, slow], [high, quick]] = valve.dead_fill;
    let fraction = ((pressure - low) / (high - low)).clamp(0.0, 1.0);
    slow + (quick - slow) * fraction
}

/// The steady pressure (Pa) under a command of `pressure` when the side is filled `rate` times a second.
fn settled_pressure(valve: &Valve, pressure: Pascal, rate: f64) -> Pascal {
    (pressure * (1.0 - valve.sag * rate) - valve.droop).max(0.0)
}

impl Trace {
    /// Pressure in the chamber at time `t` (s), Pa over ambient.
    pub fn at(&self, t: Second) -> Pascal {
        self.piece_at(t).map_or(0.0, |piece| piece.pressure_at(t))
    }

    /// Reading of a gauge at the valve's port at time `t` (s), Pa over ambient.
    pub(crate) fn at_valve(&self, t: Second) -> Pascal {
        self.piece_at(t).map_or(0.0, |piece| piece.at_valve(t))
    }

    fn piece_at(&self, t: Second) -> Option<&Piece> {
        self.0.partition_point(|piece| piece.start <= t).checked_sub(1).map(|i| &self.0[i])
    }
}

/// The command at time `t` (s), Pa.
pub(crate) fn commanded_pressure(commands: &[Command], t: Second) -> Pascal {
    let given_commands = commands.partition_point(|c| c.time <= t);
    given_commands.checked_sub(1).map_or(0.0, |i| commands[i].pressure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    /// A square wave of `full` Pa with `frequency` cycles a second, and the chamber pressure.
    fn wave(full: Pascal, frequency: f64, cycles: u32) -> (Vec<Command>, Trace) {
        let half = |i: u32| Command { time: f64::from(i) * 0.5 / frequency, pressure: full * f64::from((i + 1) % 2) };
        let commands: Vec<Command> = (0..2 * cycles).map(half).collect();
        let trace = valve_response(
            &Settings::built_in().valve,
            &commands,
            ValveDisturbance::default(),
            &mut RandomStream::new(3, "valve"),
        );
        (commands, trace)
    }

    #[test]
    fn the_pressure_is_continuous() {
        let (commands, trace) = wave(20_000.0, 3.0, 4);
        for t in commands.iter().map(|c| c.time).chain(trace.0.iter().map(|p| p.start)) {
            assert!((trace.at(t + 1e-9) - trace.at(t - 1e-9)).abs() < 0.1, "in the chamber at {t} s");
            assert!((trace.at_valve(t + 1e-9) - trace.at_valve(t - 1e-9)).abs() < 0.1, "at the port at {t} s");
        }
    }

    #[test]
    fn the_port_pressure_overshoots_by_the_given_fraction_to_one_per_cent() {
        let valve = Settings::built_in().valve;
        for overshoot in [0.2, 0.65] {
            let piece = fill_piece(&valve, 0.0, [0.0, 1.0], overshoot);
            let peak = (0..5000).map(|i| piece.at_valve(1e-5 * f64::from(i))).fold(0.0, f64::max);
            assert!((peak - 1.0 - overshoot).abs() < 0.01, "{peak}");
        }
    }

    #[test]
    fn the_pressure_is_zero_before_the_first_command_and_long_after_the_last() {
        let (_, trace) = wave(20_000.0, 1.0, 2);
        assert_eq!((trace.at(-1.0), trace.at(0.0)), (0.0, 0.0));
        assert!(trace.at(5.0).abs() < 1e-6);
    }

    #[test]
    fn a_first_fill_settles_below_its_command_by_the_droop() {
        let (_, trace) = wave(20_000.0, 1.0, 1);
        let settled: Vec<Pascal> = trace.0.iter().map(|piece| piece.target).collect();
        assert!((settled[0] - 18_800.0).abs() < 1e-9 && settled[1] == 0.0 && settled.len() == 2);
    }
}
