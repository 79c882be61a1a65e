//! The valve and its hose: what pressure arrives in a chamber when a pressure is commanded.
//!
//! After a dead time the pressure follows the command like a first-order lag, p' = (target − p) / τ, with one dead time
//! and time constant for filling and another for emptying; filled, it settles a little under the command. A command is
//! constant between steps, so every piece is an exponential in closed form.
//!
//! Stands on: `si`. Never knows: a chamber, a log. FACTS: pneumatics.

use si::{Pascal, Second};

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

/// From `start` on, p(t) = target + (begin − target) exp(−(t − start) / lag).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start: Second,
    begin: Pascal,
    target: Pascal,
    lag: Second,
}

impl Piece {
    fn at(&self, t: Second) -> Pascal {
        self.target + (self.begin - self.target) * (-(t - self.start) / self.lag).exp()
    }
}

/// What arrives in the chamber when `commands` (in rising time, from ambient pressure) are given to `valve`.
pub fn follow(valve: &Valve, commands: &[Command]) -> Trace {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut before = 0.0;
    for command in commands {
        let fills = command.pressure > before;
        let dead = if fills { valve.dead_fill } else { valve.dead_exhaust };
        let last = pieces.last().map_or(f64::NEG_INFINITY, |p| p.start);
        let start = (command.time + dead).max(last);
        let begin = pieces.last().map_or(0.0, |p| p.at(start));
        let target = settled(valve, command.pressure);
        pieces.push(Piece { start, begin, target, lag: if fills { valve.fill } else { valve.exhaust } });
        before = command.pressure;
    }
    Trace(pieces)
}

/// Where the pressure settles under a command of `pressure`, Pa.
pub fn settled(valve: &Valve, pressure: Pascal) -> Pascal {
    (pressure - valve.droop).max(0.0)
}

impl Trace {
    /// Pressure at time `t` (s), Pa over ambient.
    pub fn at(&self, t: Second) -> Pascal {
        let begun = self.0.partition_point(|piece| piece.start <= t);
        begun.checked_sub(1).map_or(0.0, |i| self.0[i].at(t))
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

    /// 200 mbar from 0 s to 1 s.
    fn pulse() -> Trace {
        let commands = [Command { time: 0.0, pressure: 20_000.0 }, Command { time: 1.0, pressure: 0.0 }];
        follow(&Settings::built_in().valve, &commands)
    }

    /// First time at which `reached` holds, to a tenth of a millisecond.
    fn first(from: Second, reached: impl Fn(Second) -> bool) -> Second {
        (0..20_000).map(|i| from + 1e-4 * f64::from(i)).find(|t| reached(*t)).unwrap()
    }

    #[test]
    fn filling_starts_after_40_to_45_ms_and_is_within_5_percent_after_150_to_230_ms() {
        let trace = pulse();
        let moves = first(0.0, |t| trace.at(t) > 1.0);
        let there = first(0.0, |t| trace.at(t) > 0.95 * trace.at(0.99));
        assert!((0.040..0.046).contains(&moves), "moves after {moves} s");
        assert!((0.15..0.23).contains(&there), "there after {there} s");
    }

    #[test]
    fn it_settles_5_to_15_mbar_under_the_command() {
        let under = 20_000.0 - pulse().at(0.99);
        assert!((500.0..1500.0).contains(&under), "{under} Pa under");
    }

    #[test]
    fn emptying_from_190_mbar_starts_after_38_to_58_ms_with_a_time_constant_of_38_to_40_ms() {
        let trace = pulse();
        let full = trace.at(1.0);
        let moves = first(1.0, |t| trace.at(t) < full - 1.0) - 1.0;
        let lag = first(1.0, |t| trace.at(t) < full / std::f64::consts::E) - 1.0 - moves;
        assert!((0.038..0.058).contains(&moves), "moves after {moves} s");
        assert!((0.038..0.040).contains(&lag), "time constant {lag} s");
    }

    #[test]
    fn the_pressure_never_jumps() {
        let trace = pulse();
        let jump = (0..15_000).map(|i| (trace.at(1e-4 * f64::from(i + 1)) - trace.at(1e-4 * f64::from(i))).abs());
        assert!(jump.fold(0.0, f64::max) < 60.0);
    }
}
