//! The pressure logger: it samples both sides and the lamp on a clock of its own.
//!
//! log time = offset + scale × video time. A sample of the lamp is its mean over one sampling interval around the sample's time.

use lab::PressureLog;
use si::Second;

use crate::random::RandomStream;
use crate::script::Pneumatics;
use crate::settings::{self, Port};
use crate::side::{Side, channel_names};
use crate::valve::commanded_pressure;

/// The logger's clock against the video's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Clock {
    /// Log time at the video's first frame, s.
    pub(crate) offset: Second,
    /// Log seconds a video second.
    pub(crate) scale: f64,
}

impl Clock {
    /// A clock within the settings' ranges.
    pub(crate) fn drawn(set: &settings::Log, random: &mut RandomStream) -> Self {
        Self { offset: random.uniform(set.offset), scale: 1.0 + random.uniform([-set.drift, set.drift]) }
    }
}

/// Time for which the logger runs on after the film, s.
const AFTERWARDS: Second = 0.4;
/// Digits that a logger prints: a tenth of a millisecond, a hundredth of a millibar (1 Pa), a thousandth of the lamp.
const LAMP_DIGITS: f64 = 1e3;

/// The pressure log of a trial.
pub(crate) fn record_pressures(
    set: &settings::Log,
    clock: Clock,
    pneumatics: &Pneumatics,
    random: &mut RandomStream,
) -> PressureLog {
    let Pneumatics { script, sides } = pneumatics;
    let samples = ((clock.offset + clock.scale * (script.length + AFTERWARDS)) * set.rate) as usize;
    let mut log = PressureLog::of(&channel_names());
    for i in 0..samples {
        let time = i as f64 / set.rate;
        let video = (time - clock.offset) / clock.scale;
        log.time.push(time);
        for (k, (side, trace)) in Side::BOTH.into_iter().zip(sides).enumerate() {
            let pressure = match set.port {
                Port::Chamber => trace.at(video),
                Port::Valve => trace.at_valve(video),
            };
            let measured = (pressure + set.noise * random.normal()).round();
            log.channels[k].command.push(commanded_pressure(script.side_commands(side), video));
            log.channels[k].measured.push(measured);
        }
        let lamp = script.lamp_share(video, 0.5 / (set.rate * clock.scale));
        log.led.push((lamp * LAMP_DIGITS).round() / LAMP_DIGITS);
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script;
    use crate::settings::Settings;
    use crate::valve::ValveDisturbance;
    use lab::card::Experiment;

    #[test]
    fn the_lamp_edge_in_a_parsed_log_is_the_start_on_the_log_s_clock() {
        let set = Settings::built_in();
        let flaps =
            Experiment::Flapping { channels: channel_names().to_vec(), amplitude: 2e4, frequency: 2.0, cycles: 2 };
        let script = script::write_script(&flaps, 0.5123, 0.5);
        let mut random = RandomStream::new(1, "valve");
        let pneumatics = Pneumatics::of_valve(&set.valve, script, ValveDisturbance::default(), &mut random);
        let clock = Clock { offset: 1.75, scale: 1.00002 };
        let log = record_pressures(&set.log, clock, &pneumatics, &mut RandomStream::new(1, "log"));
        let text = lab::pressure::write(&log, lab::VIRTUAL_BENCH);
        let read = lab::pressure::parse(&text, std::path::Path::new("pressure.csv"), &channel_names()).unwrap();
        let k = read.led.iter().position(|led| *led > 0.0).unwrap();
        let edge = read.time[k] + 0.5 / set.log.rate - read.led[k] / set.log.rate;
        assert!((edge - (clock.offset + clock.scale * pneumatics.script.led_on)).abs() < 1e-5, "edge at {edge} s");
    }
}
