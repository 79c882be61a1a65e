//! Limited-memory BFGS (L-BFGS), a quasi-Newton update of the inverse that a factor stands for [nocedal1980].
//!
//! Pairs of step s and gradient change y since the last factorisation correct the inverse, so that one lagged factor
//! serves many iterations.

use crate::dot;
use std::collections::VecDeque;

/// Pairs in the history. A pair costs four passes over a vector, far less than a solve with the factor.
const PAIRS: usize = 16;

/// Steps and gradient changes since the last factorisation.
#[derive(Debug, Default)]
pub struct LbfgsHistory {
    pairs: VecDeque<Pair>,
}

#[derive(Debug)]
struct Pair {
    step: Vec<f64>,
    gradient_change: Vec<f64>,
    /// s · y
    curvature: f64,
}

impl LbfgsHistory {
    /// Empties the history, as after a new factorisation.
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    /// Appends a pair; a pair without positive curvature is discarded.
    pub fn push(&mut self, step: Vec<f64>, gradient_change: Vec<f64>) {
        let curvature = dot(&step, &gradient_change);
        let threshold = 1e-10 * (dot(&step, &step) * dot(&gradient_change, &gradient_change)).sqrt();
        // Without s · y > 0 the updated inverse would not stay positive definite, and its direction might ascend.
        if curvature.is_nan() || curvature <= threshold {
            return;
        }
        if self.pairs.len() == PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back(Pair { step, gradient_change, curvature });
    }

    /// x ← H x by the two-loop recursion, with `solve` as the initial inverse.
    pub fn apply(&self, x: &mut [f64], solve: impl FnOnce(&mut [f64])) {
        let mut parts = Vec::with_capacity(self.pairs.len());
        for Pair { step, gradient_change, curvature } in self.pairs.iter().rev() {
            let part = dot(step, x) / curvature;
            x.iter_mut().zip(gradient_change).for_each(|(x, y)| *x -= part * y);
            parts.push(part);
        }
        solve(x);
        for (Pair { step, gradient_change, curvature }, part) in self.pairs.iter().zip(parts.iter().rev()) {
            let change = part - dot(gradient_change, x) / curvature;
            x.iter_mut().zip(step).for_each(|(x, s)| *x += change * s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_pairs_as_dimensions_reproduce_the_inverse_of_a_quadratic() {
        let diagonal = [1.0, 4.0, 0.5];
        let mut history = LbfgsHistory::default();
        for axis in 0..3 {
            let s: Vec<f64> = (0..3).map(|n| f64::from(u8::from(n == axis))).collect();
            let y = s.iter().zip(diagonal).map(|(s, d)| s * d).collect();
            history.push(s, y);
        }
        let mut x = vec![2.0, 2.0, 2.0];
        history.apply(&mut x, |_| {});
        assert!(x.iter().zip([2.0, 0.5, 4.0]).all(|(x, exact)| (x - exact).abs() < 1e-14));
    }
}
