//! Stations: a monotone interpolation of measured values, which has no overshoot.

use si::Metre;

/// A monotone cubic through stations, with the slopes of Fritsch and Butland [fritsch1984].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    at: Vec<(Metre, Metre)>,
    slopes: Vec<f64>,
}

impl Curve {
    /// A curve through at least two stations (place, value) in rising order of place.
    pub fn new(stations: Vec<(Metre, Metre)>) -> Self {
        let rise = |i: usize| (stations[i + 1].1 - stations[i].1) / (stations[i + 1].0 - stations[i].0);
        let last = stations.len() - 1;
        let inner = |i: usize| {
            mean_slope(stations[i].0 - stations[i - 1].0, stations[i + 1].0 - stations[i].0, rise(i - 1), rise(i))
        };
        let slope = |i: usize| match i {
            0 => end_slope(
                stations[1].0 - stations[0].0,
                rise(0),
                (last > 1).then(|| (stations[2].0 - stations[1].0, rise(1))),
            ),
            i if i == last => {
                let neighbour = (last > 1).then(|| (stations[last - 1].0 - stations[last - 2].0, rise(last - 2)));
                end_slope(stations[last].0 - stations[last - 1].0, rise(last - 1), neighbour)
            }
            i => inner(i),
        };
        let slopes = (0..stations.len()).map(slope).collect();
        Self { at: stations, slopes }
    }

    /// The value at `x`, m; held before the first and after the last station.
    pub fn value(&self, x: Metre) -> Metre {
        let last = self.at.len() - 1;
        let i = self.at.partition_point(|s| s.0 <= x).clamp(1, last) - 1;
        let ((x0, y0), (x1, y1)) = (self.at[i], self.at[i + 1]);
        let (step, t) = (x1 - x0, ((x - x0) / (x1 - x0)).clamp(0.0, 1.0));
        let s = 1.0 - t;
        // cubic Hermite form
        y0 * s * s * (1.0 + 2.0 * t)
            + y1 * t * t * (3.0 - 2.0 * t)
            + step * t * s * (self.slopes[i] * s - self.slopes[i + 1] * t)
    }
}

fn mean_slope(h0: f64, h1: f64, d0: f64, d1: f64) -> f64 {
    if d0 * d1 <= 0.0 {
        return 0.0;
    }
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / d0 + w1 / d1)
}

/// Slope at an end from its own piece and, when there is one, the next; kept monotone.
fn end_slope(h: f64, d: f64, next: Option<(f64, f64)>) -> f64 {
    let Some((h1, d1)) = next else { return d };
    let slope = ((2.0 * h + h1) * d - h * d1) / (h + h1);
    match slope {
        s if s * d <= 0.0 => 0.0,
        s if d * d1 <= 0.0 && s.abs() > 3.0 * d.abs() => 3.0 * d,
        s => s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_its_stations_and_stays_between_them() {
        let curve = Curve::new(vec![(0.0, 0.0), (1.0, 1.0), (2.0, 1.1), (4.0, 0.0)]);
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (2.0, 1.1), (4.0, 0.0)] {
            assert!((curve.value(x) - y).abs() < 1e-12);
        }
        assert!((0..=400).all(|i| (0.0..=1.1 + 1e-12).contains(&curve.value(f64::from(i) / 100.0))));
        assert_eq!(curve.value(9.0), 0.0);
    }

    #[test]
    fn uneven_stations_have_the_slopes_of_the_weighted_harmonic_mean() {
        let curve = Curve::new(vec![(0.0, 0.0), (1.0, 1.0), (3.0, 2.0)]);
        // by hand: 7/6 at the first, 9 / (5/1 + 4/0.5) at the middle and 1/6 at the last station
        for (x, y) in [(0.5, 0.5 + (7.0 / 6.0 - 9.0 / 13.0) / 8.0), (2.0, 1.5 + (9.0 / 13.0 - 1.0 / 6.0) / 4.0)] {
            assert!((curve.value(x) - y).abs() < 1e-12, "{} instead of {y}", curve.value(x));
        }
    }

    #[test]
    fn the_slope_at_an_end_before_a_fall_is_at_most_three_times_the_mean_slope() {
        assert_eq!(end_slope(1.0, 1.0, Some((1.0, -4.0))), 3.0);
        assert_eq!(end_slope(1.0, 1.0, Some((1.0, -2.0))), 2.5);
        assert_eq!(end_slope(1.0, 1.0, Some((1.0, 4.0))), 0.0);
    }
}
