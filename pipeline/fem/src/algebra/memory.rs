//! What past steps taught about the curvature: limited-memory BFGS around a factor.
//!
//! Pairs of step s and change of gradient y correct the inverse that an older factor stands for, so that one factor
//! serves many iterations.        [nocedal1980]
//!
//! Stands on: nothing. Never knows: a body, what the factor is.

use crate::algebra::vectors::dot;
use std::collections::VecDeque;

/// Pairs that are kept: each costs four passes over a vector, far less than a solve.
const PAIRS: usize = 16;

/// Steps and changes of gradient since the last factor.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    pairs: VecDeque<(Vec<f64>, Vec<f64>, f64)>,
}

impl Memory {
    /// Forgets everything: a new factor knows better.
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    /// Remembers that the gradient changed by `y` along the step `s`; pairs without positive curvature are passed over.
    pub fn learn(&mut self, s: Vec<f64>, y: Vec<f64>) {
        let curvature = dot(&s, &y);
        let least = 1e-10 * (dot(&s, &s) * dot(&y, &y)).sqrt();
        if curvature.is_nan() || curvature <= least {
            return;
        }
        if self.pairs.len() == PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back((s, y, curvature));
    }

    /// x ← H x by the two-loop recursion, with `solve` as the inverse to start from.
    pub fn apply(&self, x: &mut [f64], solve: impl FnOnce(&mut [f64])) {
        let mut parts = Vec::with_capacity(self.pairs.len());
        for (s, y, curvature) in self.pairs.iter().rev() {
            let part = dot(s, x) / curvature;
            x.iter_mut().zip(y).for_each(|(x, y)| *x -= part * y);
            parts.push(part);
        }
        solve(x);
        for ((s, y, curvature), part) in self.pairs.iter().zip(parts.iter().rev()) {
            let change = part - dot(y, x) / curvature;
            x.iter_mut().zip(s).for_each(|(x, s)| *x += change * s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enough_pairs_of_a_quadratic_give_its_inverse() {
        let diagonal = [1.0, 4.0, 0.5];
        let mut memory = Memory::default();
        for axis in 0..3 {
            let s: Vec<f64> = (0..3).map(|n| f64::from(u8::from(n == axis))).collect();
            let y = s.iter().zip(diagonal).map(|(s, d)| s * d).collect();
            memory.learn(s, y);
        }
        let mut x = vec![2.0, 2.0, 2.0];
        memory.apply(&mut x, |_| {});
        assert!(x.iter().zip([2.0, 0.5, 4.0]).all(|(x, exact)| (x - exact).abs() < 1e-14));
    }
}
