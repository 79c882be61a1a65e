//! The instrumented hammer: half-sine blows, and its own fast log of them on the amplifier's clock.
//!
//! Stands on: chance, `lab` (the log). Never knows: what the blows set swinging.

use std::f64::consts::{FRAC_2_PI, PI};

use lab::ForceLog;
use lab::truth::TrueTap;
use si::{Newton, Second};

use crate::draw::Draw;
use crate::logger::Clock;
use crate::settings;

/// Blows between beginning and end, s after the period's: people are not metronomes.
const UNEVEN: Second = 0.2;

/// The blows of one run.
#[derive(Debug, Clone)]
pub struct Blows {
    contact: Second,
    /// When each begins (s) and its greatest force (N).
    blows: Vec<(Second, Newton)>,
}

impl Blows {
    /// As a person gives them.
    pub fn drawn(set: &settings::Hammer, draw: &mut Draw) -> Self {
        let mut blow =
            |i: usize| ((i + 1) as f64 * set.every + draw.between([-UNEVEN, UNEVEN]), draw.between(set.peak));
        Self { contact: set.contact, blows: (0..set.taps).map(&mut blow).collect() }
    }

    /// Force on the fixture at `t` (s), N.
    pub fn at(&self, t: Second) -> Newton {
        let force = |(begin, peak): &(Second, Newton)| {
            let share = (t - begin) / self.contact;
            if (0.0..=1.0).contains(&share) { peak * (PI * share).sin() } else { 0.0 }
        };
        self.blows.iter().map(force).sum()
    }

    /// What was hidden: when each begins, and its impulse 2/π × peak × contact.
    pub fn truth(&self) -> Vec<TrueTap> {
        let tap = |(time, peak): &(Second, Newton)| TrueTap { time: *time, impulse: FRAC_2_PI * peak * self.contact };
        self.blows.iter().map(tap).collect()
    }

    /// The hammer's log until true time `end` (s), on the amplifier's `clock`.
    pub fn log(&self, set: &settings::Hammer, clock: Clock, end: Second, draw: &mut Draw) -> ForceLog {
        let samples = ((clock.offset + clock.scale * end) * set.rate) as usize;
        let time: Vec<Second> = (0..samples).map(|i| i as f64 / set.rate).collect();
        let mut force = |t: &Second| self.at((t - clock.offset) / clock.scale) + set.noise * draw.normal();
        let force = time.iter().map(|t| (force(t) * 1e3).round() / 1e3).collect();
        ForceLog { time, force, led: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn the_log_holds_the_impulses_that_were_given() {
        let set = settings::Hammer { noise: 0.0, ..Settings::built_in().hammer };
        let blows = Blows::drawn(&set, &mut Draw::new(5, "hammer"));
        let end = set.every * (set.taps + 1) as f64;
        let log = blows.log(&set, Clock { offset: 0.5, scale: 1.0 }, end, &mut Draw::new(5, "log"));
        let sum = log.force.iter().sum::<f64>() / set.rate;
        let given = blows.truth().iter().map(|tap| tap.impulse).sum::<f64>();
        // a half-sine of six samples is summed to a few percent
        assert!(blows.truth().len() == set.taps && (sum / given - 1.0).abs() < 0.05, "{sum} for {given} N s");
    }
}
