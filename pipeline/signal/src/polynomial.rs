//! Polynomials of time as regression columns, and the error of an estimation.

/// Columns 1, τ, … τ^degree with τ from −1 to 1 over `samples`: the drift of an amplifier's zero.
pub(crate) fn basis_columns(samples: usize, degree: usize) -> Vec<Vec<f64>> {
    let tau = |i: usize| 2.0 * i as f64 / (samples.max(2) - 1) as f64 - 1.0;
    (0..=degree).map(|d| (0..samples).map(|i| tau(i).powi(d as i32)).collect()).collect()
}

/// Why a model of a signal could not be estimated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} cannot be estimated\n  why: {why}\n  do:  {action}")]
pub struct EstimationError {
    /// What was to be estimated.
    pub what: &'static str,
    /// Why not.
    pub why: String,
    /// The next move.
    pub action: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_powers_of_a_time_from_minus_one_to_one() {
        let columns = basis_columns(5, 2);
        assert_eq!(columns[1], [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(columns[2], [1.0, 0.25, 0.0, 0.25, 1.0]);
    }
}
