//! The instrumented hammer: half-sine taps on the fixture, and their log on the amplifier's clock.

use std::f64::consts::{FRAC_2_PI, PI};

use lab::ForceLog;
use lab::truth::TrueTap;
use si::{Newton, Second};

use crate::pressure_log::Clock;
use crate::random::RandomStream;
use crate::settings;

/// Greatest deviation of a tap from the regular interval, s: the taps are given by hand.
const JITTER: Second = 0.2;

/// The taps of one run.
#[derive(Debug, Clone)]
pub(crate) struct HammerTaps {
    contact: Second,
    /// Start (s) and peak force (N) of each.
    taps: Vec<(Second, Newton)>,
}

impl HammerTaps {
    /// Taps drawn from the settings' ranges.
    pub(crate) fn draw_taps(set: &settings::Hammer, random: &mut RandomStream) -> Self {
        let mut tap =
            |i: usize| ((i + 1) as f64 * set.every + random.uniform([-JITTER, JITTER]), random.uniform(set.peak));
        Self { contact: set.contact, taps: (0..set.taps).map(&mut tap).collect() }
    }

    /// Force on the fixture at `t` (s), N.
    pub(crate) fn force_at(&self, t: Second) -> Newton {
        let force = |(begin, peak): &(Second, Newton)| {
            let phase = (t - begin) / self.contact;
            if (0.0..=1.0).contains(&phase) { peak * (PI * phase).sin() } else { 0.0 }
        };
        self.taps.iter().map(force).sum()
    }

    /// The start of each tap, and its impulse 2/π × peak × contact time.
    pub(crate) fn true_taps(&self) -> Vec<TrueTap> {
        let tap = |(time, peak): &(Second, Newton)| TrueTap { time: *time, impulse: FRAC_2_PI * peak * self.contact };
        self.taps.iter().map(tap).collect()
    }

    /// The hammer's log until true time `end` (s), on the amplifier's `clock`.
    pub(crate) fn hammer_log(
        &self,
        set: &settings::Hammer,
        clock: Clock,
        end: Second,
        random: &mut RandomStream,
    ) -> ForceLog {
        let samples = ((clock.offset + clock.scale * end) * set.rate) as usize;
        let time: Vec<Second> = (0..samples).map(|i| i as f64 / set.rate).collect();
        let mut force = |t: &Second| self.force_at((t - clock.offset) / clock.scale) + set.noise * random.normal();
        let force = time.iter().map(|t| (force(t) * 1e3).round() / 1e3).collect();
        ForceLog { time, force, led: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn the_log_contains_the_true_impulses() {
        let set = settings::Hammer { noise: 0.0, ..Settings::built_in().hammer };
        let taps = HammerTaps::draw_taps(&set, &mut RandomStream::new(5, "hammer"));
        let end = set.every * (set.taps + 1) as f64;
        let log = taps.hammer_log(&set, Clock { offset: 0.5, scale: 1.0 }, end, &mut RandomStream::new(5, "log"));
        let sum = log.force.iter().sum::<f64>() / set.rate;
        let given = taps.true_taps().iter().map(|tap| tap.impulse).sum::<f64>();
        // a half-sine of six samples is summed to a few percent
        assert!(taps.true_taps().len() == set.taps && (sum / given - 1.0).abs() < 0.05, "{sum} for {given} N s");
    }
}
