//! The valve and its hose: what pressure arrives in a chamber when a pressure is commanded.
//!
//! After a dead time the pressure follows the command like a first-order lag, p' = (target − p) / τ. It settles under the
//! command, and the lower the oftener the side is filled, because the supply sags. The higher the pressure, the slower it
//! empties. While air rushes in, a gauge at the valve's port reads the hose's loss as well: a burst that overshoots for an
//! instant and that the chamber never sees. A command is constant between steps, so every piece is a sum of exponentials
//! in closed form, the burst at the port alone:
//!
//! p(t) = target + (begin − target) exp(−s/τ) + burst (exp(−s/fall) − exp(−s/rise)),  s = t − start
//!
//! Stands on: the settings, chance. Never knows: a chamber, a log. FACTS: pneumatics.

use si::{Pascal, Second};

use crate::draw::Draw;
use crate::settings::Valve;

/// From `time` on, `pressure` is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// s.
    pub time: Second,
    /// Pa.
    pub pressure: Pascal,
}

/// The pressure in a chamber through a trial.
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
    fn at(&self, t: Second) -> Pascal {
        self.target + (self.begin - self.target) * (-(t - self.start) / self.lag).exp()
    }

    fn at_valve(&self, t: Second) -> Pascal {
        let s = t - self.start;
        self.at(t) + self.burst * ((-s / self.fall).exp() - (-s / self.rise).exp())
    }
}

/// What is off about the valve in one run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Unrest {
    /// By how much the regulated pressure is off, as a share, no unit.
    pub supply: f64,
    /// Greatest time by which it is early or late, each time it switches, s.
    pub jitter: Second,
}

/// What arrives in the chamber when `commands` (in rising time, from ambient pressure) are given to `valve` in a run with
/// `unrest`; `draw` says how far each fill overshoots, and how late each switching is.
pub fn follow(valve: &Valve, commands: &[Command], unrest: Unrest, draw: &mut Draw) -> Trace {
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut before, mut filled) = (0.0, f64::NEG_INFINITY);
    for command in commands {
        let fills = command.pressure > before;
        let dead = if fills { dead_fill(valve, command.pressure) } else { valve.dead_exhaust };
        let last = pieces.last().map_or(f64::NEG_INFINITY, |p| p.start);
        let late = draw.between([-unrest.jitter, unrest.jitter]);
        let start = (command.time + dead + late).max(last);
        let begin = pieces.last().map_or(0.0, |p| p.at(start));
        if fills {
            let asked = command.pressure * (1.0 + unrest.supply);
            let target = settled(valve, asked, 1.0 / (command.time - filled));
            pieces.push(fill(valve, start, begin, target, draw.between(valve.overshoot)));
            filled = command.time;
        } else {
            pieces.push(exhaust(valve, start, begin, settled(valve, command.pressure, 0.0)));
        }
        before = command.pressure;
    }
    Trace(pieces)
}

/// A fill that overshoots by `overshoot` of its step. The burst peaks at s = ln(fall/rise) / (1/rise − 1/fall), and is as
/// high as the lag leaves room for then; the sum peaks within a hundredth of that.
fn fill(valve: &Valve, start: Second, begin: Pascal, target: Pascal, overshoot: f64) -> Piece {
    let [rise, fall] = valve.burst;
    let peak = (fall / rise).ln() / (1.0 / rise - 1.0 / fall);
    let height = (-peak / fall).exp() - (-peak / rise).exp();
    let burst = (target - begin) * (overshoot + (-peak / valve.fill).exp()) / height;
    Piece { start, begin, target, lag: valve.fill, burst, rise, fall }
}

fn exhaust(valve: &Valve, start: Second, begin: Pascal, target: Pascal) -> Piece {
    let [rise, fall] = valve.burst;
    let lag = valve.exhaust[0] + valve.exhaust[1] * begin.max(0.0);
    Piece { start, begin, target, lag, burst: 0.0, rise, fall }
}

/// The dead time before a fill to `pressure` (Pa), s.
fn dead_fill(valve: &Valve, pressure: Pascal) -> Second {
    let [[low, slow], [high, quick]] = valve.dead_fill;
    let share = ((pressure - low) / (high - low)).clamp(0.0, 1.0);
    slow + (quick - slow) * share
}

/// Where the pressure settles (Pa) under a command of `pressure` when the side is filled `rate` times a second.
fn settled(valve: &Valve, pressure: Pascal, rate: f64) -> Pascal {
    (pressure * (1.0 - valve.sag * rate) - valve.droop).max(0.0)
}

impl Trace {
    /// Pressure in the chamber at time `t` (s), Pa over ambient.
    pub fn at(&self, t: Second) -> Pascal {
        self.piece(t).map_or(0.0, |piece| piece.at(t))
    }

    /// What a gauge at the valve's port reads at time `t` (s), Pa over ambient.
    pub fn at_valve(&self, t: Second) -> Pascal {
        self.piece(t).map_or(0.0, |piece| piece.at_valve(t))
    }

    fn piece(&self, t: Second) -> Option<&Piece> {
        self.0.partition_point(|piece| piece.start <= t).checked_sub(1).map(|i| &self.0[i])
    }

    /// Where the pressure settles after each command, Pa over ambient.
    pub fn settled(&self) -> impl Iterator<Item = Pascal> + '_ {
        self.0.iter().map(|piece| piece.target)
    }
}

/// The command at time `t` (s), Pa.
pub fn commanded(commands: &[Command], t: Second) -> Pascal {
    let given = commands.partition_point(|c| c.time <= t);
    given.checked_sub(1).map_or(0.0, |i| commands[i].pressure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    /// A square wave of `full` Pa with `frequency` cycles a second, and what becomes of it.
    fn wave(full: Pascal, frequency: f64, cycles: u32) -> (Vec<Command>, Trace) {
        let half = |i: u32| Command { time: f64::from(i) * 0.5 / frequency, pressure: full * f64::from((i + 1) % 2) };
        let commands: Vec<Command> = (0..2 * cycles).map(half).collect();
        let trace = follow(&Settings::built_in().valve, &commands, Unrest::default(), &mut Draw::new(3, "valve"));
        (commands, trace)
    }

    #[test]
    fn the_pressure_never_jumps() {
        let (commands, trace) = wave(20_000.0, 3.0, 4);
        for t in commands.iter().map(|c| c.time).chain(trace.0.iter().map(|p| p.start)) {
            assert!((trace.at(t + 1e-9) - trace.at(t - 1e-9)).abs() < 0.1, "in the chamber at {t} s");
            assert!((trace.at_valve(t + 1e-9) - trace.at_valve(t - 1e-9)).abs() < 0.1, "at the port at {t} s");
        }
    }

    #[test]
    fn at_the_port_a_fill_overshoots_by_its_share_to_a_hundredth() {
        let valve = Settings::built_in().valve;
        for overshoot in [0.2, 0.65] {
            let piece = fill(&valve, 0.0, 0.0, 1.0, overshoot);
            let peak = (0..5000).map(|i| piece.at_valve(1e-5 * f64::from(i))).fold(0.0, f64::max);
            assert!((peak - 1.0 - overshoot).abs() < 0.01, "{peak}");
        }
    }

    #[test]
    fn before_the_first_command_and_long_after_the_last_there_is_no_pressure() {
        let (_, trace) = wave(20_000.0, 1.0, 2);
        assert_eq!((trace.at(-1.0), trace.at(0.0)), (0.0, 0.0));
        assert!(trace.at(5.0).abs() < 1e-6);
    }

    #[test]
    fn a_trace_names_where_it_settles() {
        let (_, trace) = wave(20_000.0, 1.0, 1);
        let settled: Vec<Pascal> = trace.settled().collect();
        assert!((settled[0] - 18_800.0).abs() < 1e-9 && settled[1] == 0.0 && settled.len() == 2);
    }
}
