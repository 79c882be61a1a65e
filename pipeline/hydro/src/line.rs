//! The centre line of a tail from a few markers: a cubic spline of displacements, clamped at the root.
//!
//! d(a) is a cubic spline with d = 0, d' = 0 at the clamp, through the markers' displacements, with d'' = 0 at the last marker
//! and linear beyond. It is linear in the displacements, so each place has constant weights.

use si::{Metre, Point2};

/// A spline's places: the clamp, then the marks.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreLine {
    knots: Vec<Metre>,
}

/// Weights of the markers at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// For the displacement, no unit.
    pub value: Vec<f64>,
    /// For the slope of the displacement along the tail, 1/m.
    pub slope: Vec<f64>,
}

impl CentreLine {
    /// A line from `clamp` (m) through marks at `marks` (m, rising behind the clamp); none when they do not rise.
    pub fn new(clamp: Metre, marks: &[Metre]) -> Option<Self> {
        let knots: Vec<Metre> = std::iter::once(clamp).chain(marks.iter().copied()).collect();
        let rises = knots.len() > 1 && knots.windows(2).all(|w| w[1] > w[0]);
        rises.then_some(Self { knots })
    }

    /// The weights of the place `a` (m).
    pub fn at(&self, a: Metre) -> Weights {
        let marks = self.knots.len() - 1;
        let unit_response = |k: usize| {
            let values: Vec<f64> = (0..=marks).map(|i| f64::from(u8::from(i == k + 1))).collect();
            self.value_and_slope(&values, &self.knot_slopes(&values), a)
        };
        let (value, slope) = (0..marks).map(unit_response).unzip();
        Weights { value, slope }
    }

    /// The place on the deflected line that is `a` (m) along it at rest, on y = 0, and the unit normal to its left there; `displacements` are the
    /// displacements of the marks, m.
    pub fn normal(&self, a: Metre, displacements: &[Point2]) -> [Point2; 2] {
        let Weights { value, slope } = self.at(a);
        let weighted_sum = |weights: &[f64], k: usize| {
            weights.iter().zip(displacements).map(|(w, displacement)| w * displacement[k]).sum::<f64>()
        };
        let [x, y] = [1.0 + weighted_sum(&slope, 0), weighted_sum(&slope, 1)];
        let length = x.hypot(y);
        [[a + weighted_sum(&value, 0), weighted_sum(&value, 1)], [-y / length, x / length]]
    }

    /// Places from the clamp to the last mark, at most `spacing` (m) from each other.
    pub fn stations(&self, spacing: Metre) -> Vec<Metre> {
        let [clamp, last] = [self.knots[0], self.knots[self.knots.len() - 1]];
        let count = ((last - clamp) / spacing).ceil();
        (0..=count as usize).map(|i| clamp + (last - clamp) * i as f64 / count).collect()
    }

    /// d' at the knots: d'₀ = 0, d'' continuous between, d'' = 0 at the last (Thomas algorithm).
    fn knot_slopes(&self, values: &[f64]) -> Vec<f64> {
        let count = self.knots.len();
        let (mut diagonal, mut right_side, mut upper) = (vec![1.0; count], vec![0.0; count], vec![0.0; count]);
        for i in 1..count {
            let previous_length = self.knots[i] - self.knots[i - 1];
            let rise = (values[i] - values[i - 1]) / previous_length;
            let (lower, centre, coupling, load) = match self.knots.get(i + 1) {
                // A natural end: no moment acts on the free end. With a slope prescribed there, the last interval would
                // bend to an assumption.
                None => (1.0, 2.0, 0.0, 3.0 * rise),
                Some(next) => {
                    let next_length = next - self.knots[i];
                    let curvature_load =
                        rise / previous_length + (values[i + 1] - values[i]) / (next_length * next_length);
                    (
                        1.0 / previous_length,
                        2.0 / previous_length + 2.0 / next_length,
                        1.0 / next_length,
                        3.0 * curvature_load,
                    )
                }
            };
            // No pivoting: the diagonal of each row but the first, which is 1 alone, is twice the sum of its other entries.
            let factor = lower / diagonal[i - 1];
            diagonal[i] = centre - factor * upper[i - 1];
            right_side[i] = load - factor * right_side[i - 1];
            upper[i] = coupling;
        }
        let mut slopes = vec![0.0; count];
        for i in (1..count).rev() {
            let known_term = if i + 1 < count { upper[i] * slopes[i + 1] } else { 0.0 };
            slopes[i] = (right_side[i] - known_term) / diagonal[i];
        }
        slopes
    }

    /// Value and slope of the spline at `a`.
    fn value_and_slope(&self, values: &[f64], slopes: &[f64], a: Metre) -> (f64, f64) {
        let last = self.knots.len() - 1;
        if a <= self.knots[0] {
            return (0.0, 0.0);
        }
        // The line is linear beyond the last marker, which is its C² continuation as d'' = 0 there; the last cubic
        // continued would let a marker's error grow with the cube of the distance.
        if a >= self.knots[last] {
            return (values[last] + slopes[last] * (a - self.knots[last]), slopes[last]);
        }
        let i = self.knots.partition_point(|k| *k <= a) - 1;
        let length = self.knots[i + 1] - self.knots[i];
        let s = (a - self.knots[i]) / length;
        let (h00, h10) = ((1.0 + 2.0 * s) * (1.0 - s).powi(2), s * (1.0 - s).powi(2));
        let (h01, h11) = (s * s * (3.0 - 2.0 * s), s * s * (s - 1.0));
        let value = h00 * values[i] + h01 * values[i + 1] + length * (h10 * slopes[i] + h11 * slopes[i + 1]);
        let secant_term = 6.0 * s * (1.0 - s) * (values[i + 1] - values[i]) / length;
        let slope = secant_term + (1.0 - s) * (1.0 - 3.0 * s) * slopes[i] + s * (3.0 * s - 2.0) * slopes[i + 1];
        (value, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> CentreLine {
        CentreLine::new(0.01, &[0.05, 0.07, 0.085]).unwrap()
    }

    #[test]
    fn the_spline_interpolates_the_marks_and_has_no_slope_at_the_clamp() {
        for (k, a) in [0.05, 0.07, 0.085].into_iter().enumerate() {
            let weights = line().at(a);
            assert!(weights.value.iter().enumerate().all(|(i, w)| (w - f64::from(u8::from(i == k))).abs() < 1e-12));
        }
        assert!(line().at(0.010001).slope.iter().all(|s| s.abs() < 0.05));
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_value_and_is_continuous() {
        for a in [0.02, 0.05, 0.06, 0.07, 0.08, 0.085, 0.1] {
            let (up, down, at) = (line().at(a + 1e-7), line().at(a - 1e-7), line().at(a));
            for k in 0..3 {
                let difference = (up.value[k] - down.value[k]) / 2e-7;
                assert!((difference - at.slope[k]).abs() < 1e-4 * at.slope[k].abs().max(10.0), "{a}: {difference}");
            }
        }
    }

    #[test]
    fn a_cubic_deflection_is_reproduced_between_the_marks() {
        // d = a²(3L − a): a beam under an end load, cubic, without curvature at the last mark L
        let beam = |a: f64| (a - 0.01).powi(2) * (3.0 * 0.075 - (a - 0.01));
        let marks = [0.05, 0.07, 0.085].map(beam);
        for a in [0.02, 0.04, 0.06, 0.08] {
            let sum: f64 = line().at(a).value.iter().zip(marks).map(|(w, d)| w * d).sum();
            assert!((sum - beam(a)).abs() < 1e-15, "{a}");
        }
    }

    #[test]
    fn normals_of_a_line_bent_to_an_arc_point_to_its_centre() {
        // to the left, the centre 0.1 m above the clamp
        let arc = |a: f64| [0.01 + 0.1 * ((a - 0.01) / 0.1).sin(), 0.1 - 0.1 * ((a - 0.01) / 0.1).cos()];
        let marks = [0.022, 0.037, 0.052, 0.067];
        let moved = marks.map(|a| [arc(a)[0] - a, arc(a)[1]]);
        let line = CentreLine::new(0.01, &marks).unwrap();
        for a in line.stations(0.7e-3) {
            let [at, normal] = line.normal(a, &moved);
            let to_centre = [0.01 - at[0], 0.1 - at[1]];
            // the spline has no slope of x at the clamp, as the arc, and no curvature at the last mark, where the arc has some
            assert!((to_centre[0].hypot(to_centre[1]) - 0.1).abs() < 2e-4, "{a}: {at:?}");
            assert!((normal[0] * to_centre[0] + normal[1] * to_centre[1] - 0.1).abs() < 2e-4, "{a}: {normal:?}");
        }
    }

    #[test]
    fn stations_reach_from_the_clamp_to_the_last_mark() {
        let stations = line().stations(0.0004);
        assert_eq!((stations[0], stations[stations.len() - 1]), (0.01, 0.085));
        assert!(stations.windows(2).all(|w| w[1] - w[0] > 0.0003 && w[1] - w[0] < 0.000_400_1));
    }

    #[test]
    fn marks_that_do_not_rise_make_no_line() {
        assert!(CentreLine::new(0.01, &[0.05, 0.05]).is_none() && CentreLine::new(0.01, &[]).is_none());
    }
}
