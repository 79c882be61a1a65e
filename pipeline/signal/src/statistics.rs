//! Statistics of a curve or of pairs of numbers: minima that stand out, ranks, correlation, the negative part of an impulse.

/// The part of the impulse, without sign, that is negative, 0 to 1.
pub fn negative_share(force: &[f64]) -> f64 {
    let total: f64 = force.iter().map(|f| f.abs()).sum();
    force.iter().map(|f| (-f).max(0.0)).sum::<f64>() / total.max(f64::MIN_POSITIVE)
}

/// Minima of a profile, each separated from the next by a rise and a fall of more than `rise`; a flat minimum counts once.
pub fn minima(values: &[f64], rise: f64) -> usize {
    let (mut count, mut falling, mut extreme) = (0, true, f64::INFINITY);
    for &value in values {
        extreme = if falling { extreme.min(value) } else { extreme.max(value) };
        if (value - extreme).abs() > rise {
            count += usize::from(falling);
            (falling, extreme) = (!falling, value);
        }
    }
    count + usize::from(falling)
}

/// Ranks in rising order; ties have the mean rank.
pub fn ranks(values: &[f64]) -> Vec<f64> {
    let lower_count = |v: f64| values.iter().filter(|w| **w < v).count() as f64;
    let equal_count = |v: f64| values.iter().filter(|w| **w <= v).count() as f64 - lower_count(v);
    values.iter().map(|&v| lower_count(v) + 0.5 * (equal_count(v) - 1.0)).collect()
}

/// Pearson's correlation; 0 where one of both is constant.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let (ma, mb) = (mean(a), mean(b));
    let covariance_sum =
        |x: &[f64], mx: f64, y: &[f64], my: f64| -> f64 { x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum() };
    let scale = (covariance_sum(a, ma, a, ma) * covariance_sum(b, mb, b, mb)).sqrt();
    if scale > 0.0 { covariance_sum(a, ma, b, mb) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bowl_has_one_minimum_and_two_bowls_have_two() {
        let along = |f: fn(f64) -> f64| minima(&(0..41).map(|i| f(f64::from(i) / 20.0 - 1.0)).collect::<Vec<_>>(), 1.0);
        assert_eq!(along(|x| 100.0 * x * x), 1);
        assert_eq!(along(|x| 100.0 * (x * x - 0.4).powi(2)), 2);
    }

    #[test]
    fn ripples_in_a_valley_and_ends_of_a_slope_are_no_second_minimum() {
        let along = |f: fn(f64) -> f64| minima(&(0..41).map(|i| f(f64::from(i) / 20.0 - 1.0)).collect::<Vec<_>>(), 1.0);
        assert_eq!(along(|x| 100.0 * x * x + 0.3 * (40.0 * x).cos()), 1);
        assert_eq!((along(|x| 10.0 * x), along(|x| -10.0 * x), along(|_| 0.0)), (1, 1, 1));
    }

    #[test]
    fn what_rises_together_is_fully_correlated_in_rank() {
        let rank = |values: &[f64]| ranks(values);
        assert!((correlation(&rank(&[1.0, 2.0, 5.0]), &rank(&[0.1, 0.2, 9.0])) - 1.0).abs() < 1e-12);
        assert!((correlation(&rank(&[1.0, 2.0, 5.0]), &rank(&[3.0, 2.0, 1.0])) + 1.0).abs() < 1e-12);
        assert_eq!(rank(&[2.0, 2.0, 1.0]), [1.5, 1.5, 0.0]);
    }

    #[test]
    fn the_negative_share_of_a_force_is_that_of_its_impulse() {
        assert!((negative_share(&[3.0, -1.0]) - 0.25).abs() < 1e-12);
    }
}
