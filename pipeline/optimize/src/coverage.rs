//! Coverage: how often the truth lies inside stated intervals, over many independent truths.
//!
//! An interval is honest when its share of truths is its own probability. With errors standardised by their stated deviations the share
//! inside a central interval and the ranks of the truths (their probabilities under what was stated) follow; ranks of honest intervals are
//! uniform \[talts2018\].

use libm::erfc;
use si::Point2;

/// Half of a central interval of probability 0.68 or 0.95 in standard deviations.
pub const HALF_WIDTHS: [(f64, f64); 2] = [(0.68, 0.994_457_883), (0.95, 1.959_963_985)];

/// Standard normal probability below `z`.
fn normal_probability(z: f64) -> f64 {
    0.5 * erfc(-z / std::f64::consts::SQRT_2)
}

/// How many standardised errors lie within ± `half`.
pub fn count_inside(errors: &[f64], half: f64) -> usize {
    errors.iter().filter(|error| error.abs() <= half).count()
}

/// Bounds of the probability (95 %) behind a share counted over `count` independent cases: Wilson's interval \[wilson1927\], which also holds
/// where the share is 0 or 1.
pub fn share_bounds(share: f64, count: usize) -> [f64; 2] {
    let (n, z) = (count.max(1) as f64, HALF_WIDTHS[1].1);
    let centre = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half_width = z / (1.0 + z * z / n) * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    [(centre - half_width).max(0.0), (centre + half_width).min(1.0)]
}

/// Stated probability and observed share: of how many errors the central interval that just reaches them has at most this probability, as the
/// corners of steps from (0, 0) to (1, 1).
pub fn share_by_probability(errors: &[f64]) -> Vec<Point2> {
    let mut probabilities: Vec<f64> = errors.iter().map(|z| 2.0 * normal_probability(z.abs()) - 1.0).collect();
    probabilities.sort_by(f64::total_cmp);
    let count = probabilities.len().max(1) as f64;
    let stair = |(i, p): (usize, f64)| [[p, i as f64 / count], [p, (i + 1) as f64 / count]];
    let steps = probabilities.into_iter().enumerate().flat_map(stair);
    std::iter::once([0.0, 0.0]).chain(steps).chain([[1.0, 1.0]]).collect()
}

/// Counts of ranks in `bins` equal bins from 0 to 1: the probability below the truth under what was stated.
pub fn rank_histogram(errors: &[f64], bins: usize) -> Vec<usize> {
    let mut counts = vec![0; bins];
    for error in errors {
        let rank = normal_probability(-error);
        counts[((rank * bins as f64) as usize).min(bins - 1)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of the standard normal at even probabilities, by bisection.
    fn normal_scores(count: usize) -> Vec<f64> {
        let at = |p: f64| {
            let mut bounds = [-8.0, 8.0];
            for _ in 0..60 {
                let middle = 0.5 * (bounds[0] + bounds[1]);
                bounds[usize::from(normal_probability(middle) > p)] = middle;
            }
            bounds[0]
        };
        (0..count).map(|i| at((i as f64 + 0.5) / count as f64)).collect()
    }

    #[test]
    fn honest_errors_are_inside_as_often_as_stated_and_their_ranks_are_even() {
        let errors = normal_scores(1000);
        let shares = HALF_WIDTHS.map(|(_, half)| count_inside(&errors, half));
        assert_eq!(shares, [680, 950]);
        assert!(rank_histogram(&errors, 10).iter().all(|count| *count == 100));
    }

    #[test]
    fn overconfident_errors_pile_up_at_the_ends() {
        let errors: Vec<f64> = normal_scores(1000).iter().map(|z| 3.0 * z).collect();
        let counts = rank_histogram(&errors, 10);
        assert!(counts[0] > 300 && counts[9] > 300 && counts[5] < 60, "{counts:?}");
        assert!(count_inside(&errors, HALF_WIDTHS[1].1) < 500);
    }

    #[test]
    fn the_curve_rises_by_one_share_an_estimate_to_one() {
        let curve = share_by_probability(&[1.959_963_985, 0.0]);
        assert_eq!(curve[1..3], [[0.0, 0.0], [0.0, 0.5]]);
        assert!((curve[3][0] - 0.95).abs() < 1e-6 && curve[4][1] == 1.0, "{curve:?}");
    }

    #[test]
    fn estimates_above_the_truth_have_low_ranks() {
        assert_eq!(rank_histogram(&[2.5, 3.0], 4), [2, 0, 0, 0]);
    }

    #[test]
    fn the_bounds_of_a_share_are_wilson_s() {
        // of ten, nine inside: published as 0.596 to 0.982 \[newcombe1998\]
        let [low, high] = share_bounds(0.9, 10);
        assert!((low - 0.5958).abs() < 1e-3 && (high - 0.9821).abs() < 1e-3, "{low} {high}");
        assert_eq!(share_bounds(1.0, 20)[1], 1.0);
    }
}
