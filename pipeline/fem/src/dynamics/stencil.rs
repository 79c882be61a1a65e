//! Backward differences: the rate of a quantity from its current and past values.
//!
//! ẋ = γ x + Σ wⱼ xₙ₋ⱼ. Implicit Euler: γ = 1/h, w = −1/h.
//! BDF2 with r = hₙ/hₙ₋₁: γ = (1+2r)/(1+r)h, w = −(1+r)/h, r²/(1+r)h;
//! of equal steps 3/2h, −4/2h, 1/2h.     [hairer1993], section III.5

use crate::dynamics::settings::Scheme;
use si::{Hertz, Second};

/// Weights of one step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stencil {
    /// γ
    pub gamma: Hertz,
    /// w, newest first.
    pub weights: Vec<Hertz>,
}

impl Stencil {
    /// Of a step of length `step`, after one of length `before` if there was one.
    pub fn new(scheme: Scheme, step: Second, before: Option<Second>) -> Self {
        match (scheme, before) {
            (Scheme::Bdf2, Some(before)) => {
                let r = step / before;
                let gamma = (1.0 + 2.0 * r) / ((1.0 + r) * step);
                Self { gamma, weights: vec![-(1.0 + r) / step, r * r / ((1.0 + r) * step)] }
            }
            (Scheme::QuasiStatic, _) => Self { gamma: 0.0, weights: Vec::new() },
            _ => Self { gamma: 1.0 / step, weights: vec![-1.0 / step] },
        }
    }

    /// Of the step that ends at the last of `times` (s, ascending).
    pub fn ending(scheme: Scheme, times: &[Second]) -> Self {
        let count = times.len();
        let previous_step = count.checked_sub(3).map(|at| times[at + 1] - times[at]);
        Self::new(scheme, times[count - 1] - times[count - 2], previous_step)
    }

    /// Σ wⱼ xₙ₋ⱼ over `past`, newest first.
    pub fn history<'a>(&self, past: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
        let mut sum = Vec::new();
        for (weight, values) in self.weights.iter().zip(past) {
            sum.resize(values.len(), 0.0);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }

    /// γ x + Σ wⱼ xₙ₋ⱼ
    pub fn rate<'a>(&self, now: &[f64], past: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
        let mut rate = self.history(past);
        rate.resize(now.len(), 0.0);
        rate.iter_mut().zip(now).for_each(|(rate, now)| *rate += self.gamma * now);
        rate
    }
}

/// Lagrange weights at `now` of the polynomial through `times`.
pub(crate) fn extrapolation_weights(times: &[Second], now: Second) -> Vec<f64> {
    let weight = |i: usize| {
        let other_times = (0..times.len()).filter(|&j| j != i);
        other_times.map(|j| (now - times[j]) / (times[i] - times[j])).product()
    };
    (0..times.len()).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_order_stencil_is_exact_for_parabolas_over_unequal_steps() {
        let times = [0.3, 0.5, 0.9];
        let parabola = |t: f64| [1.0 - 2.0 * t + 3.0 * t * t];
        let stencil = Stencil::ending(Scheme::Bdf2, &times);
        let past = [parabola(0.5), parabola(0.3)];
        let rate = stencil.rate(&parabola(0.9), past.iter().map(<[f64; 1]>::as_slice));
        assert!((rate[0] - (-2.0 + 6.0 * 0.9)).abs() < 1e-13);
    }

    #[test]
    fn equal_steps_give_the_textbook_weights() {
        let stencil = Stencil::new(Scheme::Bdf2, 0.1, Some(0.1));
        assert!((stencil.gamma - 15.0).abs() < 1e-12);
        assert!((stencil.weights[0] + 20.0).abs() < 1e-12 && (stencil.weights[1] - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_cubic_is_extrapolated_exactly_from_four_uneven_times() {
        let times = [0.4, 0.3, 0.1, 0.0];
        let cubic = |t: f64| 2.0 + t - t * t * t;
        let value: f64 = extrapolation_weights(&times, 0.5).iter().zip(times).map(|(w, t)| w * cubic(t)).sum();
        assert!((value - cubic(0.5)).abs() < 1e-13);
    }
}
