//! Backtracking line search on the energy: sufficient decrease [armijo1966], approximate near the minimum [hager2005].

use crate::newton::potential::Energy;

/// Trials along one direction before it is given up.
pub(crate) const MAX_TRIALS: usize = 25;
/// Sufficient decrease: fraction of the linear prediction.
// An exact Newton step of a quadratic lowers it by half of the linear prediction; the factor must only lie well below
// that.
const ARMIJO: f64 = 1e-4;
/// Energy differences below this fraction of the energy's terms are rounding.
pub(crate) const ROUNDING: f64 = 1e-13;

/// A direction of descent from the current iterate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LineSearch {
    /// Energy at the iterate.
    pub start: Energy,
    /// Directional derivative there, J; negative.
    pub slope: f64,
}

impl LineSearch {
    /// Whether the step of length `part` to the energy `end`, with the directional derivative `end_slope` there, is
    /// accepted.
    pub(crate) fn accepts(&self, part: f64, end: Energy, end_slope: f64) -> bool {
        if !end.value.is_finite() {
            return false;
        }
        let change = end.value - self.start.value;
        if change <= ARMIJO * part * self.slope {
            return true;
        }
        // Near the minimum the differences of energy are rounding, and Armijo's test would reject every step. There the
        // derivative decides instead, which keeps its digits.
        change.abs() <= ROUNDING * self.start.size.max(end.size) && end_slope <= -0.8 * self.slope
    }

    /// Factor by which to shorten a rejected step: to the minimum of a parabola, between a tenth and a half.
    pub(crate) fn shorten(&self, part: f64, end: Energy) -> f64 {
        let curvature = end.value - self.start.value - part * self.slope;
        if curvature.is_finite() && curvature > 0.0 {
            // Bounded: an energy that is almost infinite would end the step, and a parabola beyond one half hardly
            // shorten it.
            (-part * self.slope / (2.0 * curvature)).clamp(0.1, 0.5)
        } else {
            0.5
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The energy 10 − 4 s + 8 s², whose minimum is at a quarter of the step.
    fn parabola(s: f64) -> Energy {
        Energy { value: 10.0 - 4.0 * s + 8.0 * s * s, size: 10.0 }
    }

    #[test]
    fn a_rejected_step_is_shortened_to_the_minimum_of_its_parabola() {
        let search = LineSearch { start: parabola(0.0), slope: -4.0 };
        assert!(!search.accepts(1.0, parabola(1.0), 12.0) && search.accepts(0.25, parabola(0.25), 0.0));
        assert!((search.shorten(1.0, parabola(1.0)) - 0.25).abs() < 1e-12);
        assert!((search.shorten(0.6, parabola(0.6)) - 0.25 / 0.6).abs() < 1e-12);
        // not below a tenth nor above a half; by half where there is no parabola
        assert_eq!(search.shorten(4.0, parabola(4.0)), 0.1);
        assert_eq!(search.shorten(0.3, parabola(0.3)), 0.5);
        let infinite = Energy { value: f64::INFINITY, size: 10.0 };
        assert_eq!(search.shorten(1.0, infinite), 0.5);
        assert!(!search.accepts(1.0, infinite, 0.0));
    }

    #[test]
    fn where_energies_are_rounding_the_slope_decides() {
        let search = LineSearch { start: Energy { value: 10.0, size: 1e3 }, slope: -1e-12 };
        let same = Energy { value: 10.0, size: 1e3 };
        assert!(search.accepts(1.0, same, 0.7e-12) && !search.accepts(1.0, same, 0.9e-12));
    }
}
