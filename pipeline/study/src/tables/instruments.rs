//! Properties of the instruments from their logs: noise of a load cell, ranges.

use si::Newton;

/// Standard deviation of a log from differences of neighbours, which drift does not affect, N.
pub(super) fn log_scatter(log: &[Newton]) -> Newton {
    let squares: f64 = log.windows(2).map(|v| (v[1] - v[0]).powi(2)).sum();
    (0.5 * squares / log.len().saturating_sub(1).max(1) as f64).sqrt()
}

/// Lowest and highest; nothing when there is none.
pub(super) fn finite_range(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let wider = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
    let bounds = values.into_iter().filter(|v| v.is_finite()).fold([f64::INFINITY, f64::NEG_INFINITY], wider);
    bounds[0].is_finite().then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_does_not_count_as_scatter() {
        let drifting: Vec<f64> = (0..100).map(|i| 1e-6 * f64::from(i)).collect();
        assert!(log_scatter(&drifting) < 1e-6);
        let alternating: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
        assert!((log_scatter(&alternating) - 1.414e-3).abs() < 1e-5);
    }
}
