//! Adam for a network's many weights: as the optimiser of that name, but in f32 and in place.
//!
//! m ← β₁m + (1−β₁)g,  v ← β₂v + (1−β₂)g²,  θ ← θ − α m̂/(√v̂ + ε)      [kingma2015], algorithm 1; α = 1e-3 in the paper
//!
//! Stands on: nothing. Never knows: what a weight does.

/// β₁, β₂ and ε, as published and as in PyTorch.
const MEMORY: [f32; 2] = [0.9, 0.999];
const EPSILON: f32 = 1e-8;

/// The running means of one list of weights.
#[derive(Debug, Clone)]
pub(super) struct Adam {
    mean: Vec<f32>,
    square: Vec<f32>,
}

impl Adam {
    pub fn new(weights: usize) -> Self {
        Self { mean: vec![0.0; weights], square: vec![0.0; weights] }
    }

    /// Step `number` (from 1) of length `step`.
    pub fn step(&mut self, weights: &mut [f32], gradient: &[f32], step: f32, number: i32) {
        let [b1, b2] = MEMORY;
        let first = step / (1.0 - b1.powi(number));
        let second = 1.0 / (1.0 - b2.powi(number));
        let both = self.mean.iter_mut().zip(&mut self.square).zip(weights).zip(gradient);
        for (((m, v), w), g) in both {
            *m = b1 * *m + (1.0 - b1) * g;
            *v = b2 * *v + (1.0 - b2) * g * g;
            *w -= first * *m / ((second * *v).sqrt() + EPSILON);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_is_as_long_as_was_said_against_the_gradient() {
        let (mut adam, mut weights) = (Adam::new(2), vec![1.0, 1.0]);
        adam.step(&mut weights, &[3.0, -0.2], 1e-3, 1);
        assert!((weights[0] - 0.999).abs() < 1e-6 && (weights[1] - 1.001).abs() < 1e-6);
    }
}
