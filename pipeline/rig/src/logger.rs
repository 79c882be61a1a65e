//! The pressure logger: samples both sides and the lamp on a clock of its own.
//!
//! log time = offset + scale × video time. A sample of the lamp is its mean over one sampling interval around it.
//!
//! Stands on: `lab` (the log), the script, the valve's traces. Never knows: a film.

use lab::PressureLog;
use lab::card::Side;
use lab::pressure::Channel;
use si::Second;

use crate::draw::Draw;
use crate::script::Script;
use crate::settings::{self, Port};
use crate::valve::{Trace, commanded};

/// The logger's clock against the video's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Log time at the video's first frame, s.
    pub offset: Second,
    /// Log seconds a video second.
    pub scale: f64,
}

impl Clock {
    /// A clock within the settings' ranges.
    pub fn drawn(set: &settings::Log, draw: &mut Draw) -> Self {
        Self { offset: draw.between(set.offset), scale: 1.0 + draw.between([-set.drift, set.drift]) }
    }
}

/// How long the logger runs on after the camera, s.
const AFTERWARDS: Second = 0.4;
/// Digits that a logger prints: a tenth of a millisecond, a hundredth of a millibar (1 Pa), a thousandth of the lamp.
const LAMP_DIGITS: f64 = 1e3;

/// What the logger writes of a trial.
pub fn record(set: &settings::Log, clock: Clock, script: &Script, sides: [&Trace; 2], draw: &mut Draw) -> PressureLog {
    let samples = ((clock.offset + clock.scale * (script.length + AFTERWARDS)) * set.rate) as usize;
    let mut log = PressureLog::default();
    for i in 0..samples {
        let time = i as f64 / set.rate;
        let video = (time - clock.offset) / clock.scale;
        log.time.push(time);
        for (side, trace) in [(Side::Left, sides[0]), (Side::Right, sides[1])] {
            let pressure = match set.port {
                Port::Chamber => trace.at(video),
                Port::Valve => trace.at_valve(video),
            };
            let measured = (pressure + set.noise * draw.normal()).round();
            let channel = channel(&mut log, side);
            channel.command.push(commanded(script.side(side), video));
            channel.measured.push(measured);
        }
        let lamp = script.lamp(video, 0.5 / (set.rate * clock.scale));
        log.led.push((lamp * LAMP_DIGITS).round() / LAMP_DIGITS);
    }
    log
}

fn channel(log: &mut PressureLog, side: Side) -> &mut Channel {
    match side {
        Side::Left => &mut log.left,
        Side::Right => &mut log.right,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::{script, valve};
    use lab::card::Experiment;

    #[test]
    fn a_log_is_what_lab_reads_and_its_lamp_lights_at_the_start_on_its_own_clock() {
        let set = Settings::built_in();
        let flaps = Experiment::Flapping { side: Side::Left, amplitude: 2e4, frequency: 2.0, cycles: 2 };
        let script = script::write(&flaps, 0.5123, 0.5);
        let mut draw = Draw::new(1, "valve");
        let [left, right] =
            [&script.left, &script.right].map(|c| valve::follow(&set.valve, c, valve::Unrest::default(), &mut draw));
        let clock = Clock { offset: 1.75, scale: 1.00002 };
        let log = record(&set.log, clock, &script, [&left, &right], &mut Draw::new(1, "log"));
        let text = lab::pressure::write(&log, lab::VIRTUAL_BENCH);
        let read = lab::pressure::parse(&text, std::path::Path::new("pressure.csv")).unwrap();
        let k = read.led.iter().position(|led| *led > 0.0).unwrap();
        let edge = read.time[k] + 0.5 / set.log.rate - read.led[k] / set.log.rate;
        assert!((edge - (clock.offset + clock.scale * script.led_on)).abs() < 1e-5, "edge at {edge} s");
    }
}
