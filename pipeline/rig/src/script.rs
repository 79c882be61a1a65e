//! The script of a trial: the pressure commands of each side and the lamp, on the video's clock, and the valve's response to them.

use lab::card::Experiment;
use si::{Pascal, Second};

use crate::random::RandomStream;
use crate::settings;
use crate::side::Side;
use crate::valve::{Command, Trace, ValveDisturbance, valve_response};

/// Commands and lamp of one trial; time 0 is the video's first frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Script {
    /// Commands to the left side, rising in time.
    pub(crate) left: Vec<Command>,
    /// Commands to the right side, rising in time.
    pub(crate) right: Vec<Command>,
    /// Time at which the lamp is switched on, the time of the first command, s.
    pub(crate) led_on: Second,
    /// Time at which it is switched off, the end of the last command, s.
    pub(crate) led_off: Second,
    /// Duration of the film, s.
    pub(crate) length: Second,
}

/// A script and the chamber pressures that result from it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pneumatics {
    /// The commands.
    pub(crate) script: Script,
    /// The pressure in the chambers, left and right.
    pub(crate) sides: [Trace; 2],
}

impl Pneumatics {
    /// The response of `valve` to `script` in a run with `disturbance`.
    pub(crate) fn of_valve(
        valve: &settings::Valve,
        script: Script,
        disturbance: ValveDisturbance,
        random: &mut RandomStream,
    ) -> Self {
        let sides = [&script.left, &script.right].map(|commands| valve_response(valve, commands, disturbance, random));
        Self { script, sides }
    }
}

/// The script of `experiment`: its first command is given at `start` (s), and the film ends `rest` (s) after its last.
pub(crate) fn write_script(experiment: &Experiment, start: Second, rest: Second) -> Script {
    let mut script = Script { left: Vec::new(), right: Vec::new(), led_on: start, led_off: start, length: start };
    let side = Side::first_of(experiment);
    match experiment {
        Experiment::Staircase { levels, hold, pause, .. } => {
            for level in levels {
                script.add_pulse(side, *level, *hold);
                script.led_off += pause;
            }
        }
        Experiment::Flapping { amplitude, frequency, cycles, .. } => {
            for _ in 0..*cycles {
                script.add_pulse(side, *amplitude, 0.5 / frequency);
                script.add_pulse(side.opposite_side(), *amplitude, 0.5 / frequency);
            }
        }
    }
    script.length = script.led_off + rest;
    script
}

impl Script {
    /// The commands of a side.
    pub(crate) fn side_commands(&self, side: Side) -> &[Command] {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// Fraction of the interval from `t` − `half` to `t` + `half` (s) during which the lamp is on, 0 to 1.
    pub(crate) fn lamp_share(&self, t: Second, half: Second) -> f64 {
        let lit = (t + half).min(self.led_off) - (t - half).max(self.led_on);
        (lit / (2.0 * half)).clamp(0.0, 1.0)
    }

    /// Appends a command of `pressure` on `side` for `time` (s), followed by ambient pressure.
    fn add_pulse(&mut self, side: Side, pressure: Pascal, time: Second) {
        let commands = match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
        };
        commands.push(Command { time: self.led_off, pressure });
        self.led_off += time;
        commands.push(Command { time: self.led_off, pressure: 0.0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::valve::commanded_pressure;

    #[test]
    fn a_square_wave_fills_one_side_at_a_time() {
        let flaps = Experiment::Flapping {
            channels: crate::side::channel_names().to_vec(),
            amplitude: 2e4,
            frequency: 2.0,
            cycles: 3,
        };
        let script = write_script(&flaps, 0.5, 0.25);
        let both = |t| (commanded_pressure(&script.left, t), commanded_pressure(&script.right, t));
        assert_eq!((both(0.4), both(0.6), both(0.8), both(2.1)), ((0.0, 0.0), (2e4, 0.0), (0.0, 2e4), (0.0, 0.0)));
        assert!((script.led_off - 2.0).abs() < 1e-12 && (script.length - 2.25).abs() < 1e-12);
    }

    #[test]
    fn a_lamp_switched_on_during_an_exposure_is_seen_by_the_lit_fraction() {
        let stairs = Experiment::Staircase { channels: vec!["left".into()], levels: vec![1e4], hold: 1.0, pause: 0.5 };
        let script = write_script(&stairs, 0.5, 0.5);
        assert!((script.lamp_share(0.502, 0.008) - 0.625).abs() < 1e-9);
        assert_eq!(
            (script.lamp_share(0.4, 0.008), script.lamp_share(1.0, 0.008), script.lamp_share(2.2, 0.008)),
            (0.0, 1.0, 0.0)
        );
    }
}
