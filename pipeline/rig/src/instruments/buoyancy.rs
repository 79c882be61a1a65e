//! Buoyancy that crosses into the cell: a force that follows pressure although nothing moves.
//!
//! An inflated tail displaces more water, and some of that lift tilts into the cell's axis: the same sign left and right,
//! growing faster than pressure, late by 0.28 s. Part of the lateness is the slowness of the inflation, the rest is a pure
//! delay. In air next to nothing is left.
//!
//! Stands on: the settings. Never knows: a valve, thrust.

use lab::card::Medium;
use si::{Newton, Pascal, Second};

use crate::settings;

/// Pressure is taken as constant over such intervals when it is slowed, s.
const STEP: Second = 1e-3;

/// The force while nothing moves (N) under `pressure` (Pa) on one side, in `medium`, of the tail `name`; none for a tail that
/// was never measured.
pub fn still(set: &settings::Buoyancy, name: &str, medium: Medium, pressure: Pascal) -> Newton {
    let left = match medium {
        Medium::Water => 1.0,
        Medium::Air => set.air,
    };
    left * set.water.get(name).map_or(0.0, |points| between(points, pressure))
}

/// Straight between points, from (0, 0), held beyond the last.
fn between(points: &[[f64; 2]], x: f64) -> f64 {
    let mut before = [0.0, 0.0];
    for point in points {
        if x < point[0] {
            return before[1] + (point[1] - before[1]) * ((x - before[0]) / (point[0] - before[0])).max(0.0);
        }
        before = *point;
    }
    before[1]
}

/// Pressure as buoyancy sees it: late and slow, 1000 samples a second from `start` (s) to `end` (s) of the true clock.
#[derive(Debug, Clone)]
pub struct Late {
    start: Second,
    pressures: Vec<Pascal>,
}

impl Late {
    /// What is seen of `pressure` (Pa at any time in s), which is at rest before `start`.
    pub fn of(set: &settings::Buoyancy, [start, end]: [Second; 2], pressure: &dyn Fn(Second) -> Pascal) -> Self {
        let (share, delay) = (1.0 - (-STEP / set.slow).exp(), set.lag - set.slow);
        let mut seen = 0.0;
        let mut next = |i: usize| {
            seen += share * (pressure(start + (i as f64 - 0.5) * STEP - delay) - seen);
            seen
        };
        Self { start, pressures: (0..=((end - start) / STEP).ceil() as usize).map(&mut next).collect() }
    }

    /// At time `t` (s), straight between samples, held beyond them; Pa.
    pub fn at(&self, t: Second) -> Pascal {
        let last = self.pressures.len() - 1;
        let place = ((t - self.start) / STEP).clamp(0.0, last as f64);
        let first = (place as usize).min(last.saturating_sub(1));
        let share = place - first as f64;
        self.pressures[first] * (1.0 - share) + self.pressures[(first + 1).min(last)] * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn set() -> settings::Buoyancy {
        Settings::built_in().buoyancy
    }

    #[test]
    fn a_ramp_of_pressure_comes_0_28_s_late() {
        let late = Late::of(&set(), [0.0, 4.0], &|t: Second| 5000.0 * t.max(0.0));
        assert!((late.at(3.5) / 5000.0 - (3.5 - 0.28)).abs() < 1e-5, "{}", late.at(3.5));
    }

    #[test]
    fn a_step_is_slow_after_its_delay_as_an_exponential_says() {
        let set = set();
        let late = Late::of(&set, [0.0, 4.0], &|t: Second| if t < 0.0 { 0.0 } else { 1.0 });
        let since = 0.5 - (set.lag - set.slow);
        assert!((late.at(0.5) - (1.0 - (-since / set.slow).exp())).abs() < 1e-2);
        assert_eq!(late.at(0.2), 0.0);
    }

    #[test]
    fn points_are_met_and_held_beyond() {
        let points = [[1.0, 2.0], [3.0, 10.0]];
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 9.0].map(|x| between(&points, x)), [0.0, 1.0, 2.0, 6.0, 10.0]);
        assert_eq!(still(&set(), "a tail that was never measured", Medium::Water, 2e4), 0.0);
    }
}
