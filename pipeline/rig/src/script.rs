//! A trial's script: what is commanded on each side, and when the lamp shines, on the video's clock.
//!
//! Stands on: the card's experiments. Never knows: what the valve makes of it.

use lab::card::{Experiment, Side};
use si::{Pascal, Second};

use crate::valve::Command;

/// Commands and lamp of one trial; time 0 is the video's first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Script {
    /// Commands to the left side, rising in time.
    pub left: Vec<Command>,
    /// Commands to the right side, rising in time.
    pub right: Vec<Command>,
    /// When the lamp lights, which is when the first command is given, s.
    pub led_on: Second,
    /// When it goes out, which is when the last command ends, s.
    pub led_off: Second,
    /// How long the camera runs, s.
    pub length: Second,
}

/// The script of `experiment`, whose first command comes at `start` (s) and after whose end the camera runs on for
/// `rest` (s).
pub fn write(experiment: &Experiment, start: Second, rest: Second) -> Script {
    let mut script = Script { left: Vec::new(), right: Vec::new(), led_on: start, led_off: start, length: start };
    match experiment {
        Experiment::Staircase { side, levels, hold, pause } => {
            for level in levels {
                script.pulse(*side, *level, *hold);
                script.led_off += pause;
            }
        }
        Experiment::Flapping { side, amplitude, frequency, cycles } => {
            for _ in 0..*cycles {
                script.pulse(*side, *amplitude, 0.5 / frequency);
                script.pulse(side.other(), *amplitude, 0.5 / frequency);
            }
        }
    }
    script.length = script.led_off + rest;
    script
}

impl Script {
    /// The commands of a side.
    pub fn side(&self, side: Side) -> &[Command] {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// Share of the interval from − half to + half around `t` (all s) during which the lamp shines, 0 to 1.
    pub fn lamp(&self, t: Second, half: Second) -> f64 {
        let lit = (t + half).min(self.led_off) - (t - half).max(self.led_on);
        (lit / (2.0 * half)).clamp(0.0, 1.0)
    }

    /// Commands `pressure` on `side` for `time` s from where the script ends now, then ambient.
    fn pulse(&mut self, side: Side, pressure: Pascal, time: Second) {
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
    use crate::valve::commanded;

    #[test]
    fn a_square_wave_fills_one_side_at_a_time() {
        let flaps = Experiment::Flapping { side: Side::Left, amplitude: 2e4, frequency: 2.0, cycles: 3 };
        let script = write(&flaps, 0.5, 0.25);
        let both = |t| (commanded(&script.left, t), commanded(&script.right, t));
        assert_eq!((both(0.4), both(0.6), both(0.8), both(2.1)), ((0.0, 0.0), (2e4, 0.0), (0.0, 2e4), (0.0, 0.0)));
        assert!((script.led_off - 2.0).abs() < 1e-12 && (script.length - 2.25).abs() < 1e-12);
    }

    #[test]
    fn a_lamp_that_lights_in_mid_exposure_is_collected_by_its_share() {
        let stairs = Experiment::Staircase { side: Side::Left, levels: vec![1e4], hold: 1.0, pause: 0.5 };
        let script = write(&stairs, 0.5, 0.5);
        assert!((script.lamp(0.502, 0.008) - 0.625).abs() < 1e-9);
        assert_eq!((script.lamp(0.4, 0.008), script.lamp(1.0, 0.008), script.lamp(2.2, 0.008)), (0.0, 1.0, 0.0));
    }
}
