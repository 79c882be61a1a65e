//! Adam's update rule [kingma2015, algorithm 1], for the optimiser (f64) and for a network's weights (f32).
//!
//! m ← β₁ m + (1 − β₁) g,  v ← β₂ v + (1 − β₂) g²,  θ ← θ − α m̂ / (√v̂ + ε) with m̂ = m / (1 − β₁ᵏ) and v̂ = v / (1 − β₂ᵏ).

use std::ops::{Add, Div, Mul, Sub};

/// A floating-point number of either width.
pub(crate) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;
    /// ε: a gradient of zero does not lead to a division by zero. The published value.
    const EPSILON: Self;
    fn sqrt(self) -> Self;
    fn powi(self, power: i32) -> Self;
}

macro_rules! real {
    ($float:ty) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = 1e-8;
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            fn powi(self, power: i32) -> Self {
                <$float>::powi(self, power)
            }
        }
    };
}
real!(f32);
real!(f64);

/// Where the corrections 1 − βᵏ of the first steps are applied. Both are the same formula; they differ in rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BiasCorrection {
    /// To each moment, as the algorithm is published.
    OfMoments,
    /// To α and, as a factor, to v: one division a step instead of two a weight. A network has some 120 000 weights.
    OfStep,
}

/// Running moments of a gradient.
#[derive(Debug, Clone)]
pub(crate) struct Adam<T> {
    mean: Vec<T>,
    square: Vec<T>,
    decay: [T; 2],
    correction: BiasCorrection,
}

impl<T: Real> Adam<T> {
    /// Moments of a gradient of `size` components that decay by `decay` = [β₁, β₂] a step.
    pub(crate) fn new(size: usize, decay: [T; 2], correction: BiasCorrection) -> Self {
        Self { mean: vec![T::ZERO; size], square: vec![T::ZERO; size], decay, correction }
    }

    /// Moves `parameters` by step `number` (from 1) of length `alpha` against the gradient.
    pub(crate) fn update_parameters(&mut self, parameters: &mut [T], gradient: &[T], alpha: T, number: i32) {
        let [beta1, beta2] = self.decay;
        let corrections = [beta1, beta2].map(|beta| T::ONE - beta.powi(number));
        let [first, second] = [alpha / corrections[0], T::ONE / corrections[1]];
        let moments = self.mean.iter_mut().zip(&mut self.square);
        let updated_moments = moments.zip(parameters).zip(gradient).map(|(((m, v), x), &g)| {
            *m = beta1 * *m + (T::ONE - beta1) * g;
            *v = beta2 * *v + (T::ONE - beta2) * g * g;
            (*m, *v, x)
        });
        match self.correction {
            BiasCorrection::OfMoments => updated_moments.for_each(|(m, v, x)| {
                let (m, v) = (m / corrections[0], v / corrections[1]);
                *x = *x - alpha * m / (v.sqrt() + T::EPSILON);
            }),
            BiasCorrection::OfStep => {
                updated_moments.for_each(|(m, v, x)| *x = *x - first * m / ((second * v).sqrt() + T::EPSILON));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_has_the_given_length_against_the_gradient() {
        for correction in [BiasCorrection::OfMoments, BiasCorrection::OfStep] {
            let (mut adam, mut weights) = (Adam::new(2, [0.9_f32, 0.999], correction), [1.0, 1.0]);
            adam.update_parameters(&mut weights, &[3.0, -0.2], 1e-3, 1);
            assert!((weights[0] - 0.999).abs() < 1e-6 && (weights[1] - 1.001).abs() < 1e-6);
        }
    }

    #[test]
    fn both_corrections_are_the_same_formula() {
        let path = |correction| {
            let (mut adam, mut at) = (Adam::new(1, [0.9_f64, 0.999], correction), [1.0]);
            (1..50).for_each(|k| adam.update_parameters(&mut at, &[f64::from(k).sin()], 1e-2, k));
            at[0]
        };
        // a few roundings of 1e-16 a step
        assert!((path(BiasCorrection::OfMoments) - path(BiasCorrection::OfStep)).abs() < 1e-13);
    }
}
