//! Buoyancy in the load cell: a static force that depends on pressure.
//!
//! An inflated tail displaces more water, and a component of that lift acts along the cell's axis: it has the same sign left and right, grows
//! faster than pressure and is delayed by 0.28 s. Part of the delay is a first-order lag of the inflation, the rest a dead time. In air
//! little of it remains.

use lab::card::Medium;
use si::{Newton, Pascal, Second};

use crate::settings;

/// Sampling interval of the delayed pressure, over which the pressure is constant, s.
const STEP: Second = 1e-3;

/// The static force (N) at `pressure` (Pa) on one side of the tail `name` in `medium`; zero for a tail without measurements.
pub(crate) fn static_force(set: &settings::Buoyancy, name: &str, medium: Medium, pressure: Pascal) -> Newton {
    let scale = match medium {
        Medium::Water => 1.0,
        Medium::Air => set.air,
    };
    scale * set.water.get(name).map_or(0.0, |points| interpolate_points(points, pressure))
}

/// Piecewise linear from (0, 0), constant beyond the last point.
fn interpolate_points(points: &[[f64; 2]], x: f64) -> f64 {
    let mut previous = [0.0, 0.0];
    for point in points {
        if x < point[0] {
            return previous[1] + (point[1] - previous[1]) * ((x - previous[0]) / (point[0] - previous[0])).max(0.0);
        }
        previous = *point;
    }
    previous[1]
}

/// The delayed and low-pass filtered pressure that determines buoyancy, sampled at 1 kHz of true time.
#[derive(Debug, Clone)]
pub(crate) struct DelayedPressure {
    start: Second,
    pressures: Vec<Pascal>,
}

impl DelayedPressure {
    /// Delays `pressure` (Pa at any time in s) from `start` to `end` (s); it is constant before `start`.
    pub(crate) fn of_pressure(
        set: &settings::Buoyancy,
        [start, end]: [Second; 2],
        pressure: &dyn Fn(Second) -> Pascal,
    ) -> Self {
        let (gain, delay) = (1.0 - (-STEP / set.slow).exp(), set.lag - set.slow);
        let mut delayed = 0.0;
        let mut next = |i: usize| {
            delayed += gain * (pressure(start + (i as f64 - 0.5) * STEP - delay) - delayed);
            delayed
        };
        Self { start, pressures: (0..=((end - start) / STEP).ceil() as usize).map(&mut next).collect() }
    }

    /// At time `t` (s), linear between samples, constant beyond them; Pa.
    pub(crate) fn pressure_at(&self, t: Second) -> Pascal {
        let last = self.pressures.len() - 1;
        let index = ((t - self.start) / STEP).clamp(0.0, last as f64);
        let first = (index as usize).min(last.saturating_sub(1));
        let fraction = index - first as f64;
        self.pressures[first] * (1.0 - fraction) + self.pressures[(first + 1).min(last)] * fraction
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
    fn a_ramp_of_pressure_is_delayed_by_0_28_s() {
        let late = DelayedPressure::of_pressure(&set(), [0.0, 4.0], &|t: Second| 5000.0 * t.max(0.0));
        assert!((late.pressure_at(3.5) / 5000.0 - (3.5 - 0.28)).abs() < 1e-5, "{}", late.pressure_at(3.5));
    }

    #[test]
    fn a_step_gives_an_exponential_after_its_dead_time() {
        let set = set();
        let late = DelayedPressure::of_pressure(&set, [0.0, 4.0], &|t: Second| if t < 0.0 { 0.0 } else { 1.0 });
        let since = 0.5 - (set.lag - set.slow);
        assert!((late.pressure_at(0.5) - (1.0 - (-since / set.slow).exp())).abs() < 1e-2);
        assert_eq!(late.pressure_at(0.2), 0.0);
    }

    #[test]
    fn points_are_interpolated_and_constant_beyond() {
        let points = [[1.0, 2.0], [3.0, 10.0]];
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 9.0].map(|x| interpolate_points(&points, x)), [0.0, 1.0, 2.0, 6.0, 10.0]);
        assert_eq!(static_force(&set(), "a tail without measurements", Medium::Water, 2e4), 0.0);
    }
}
