//! A multilayer perceptron for scalar regression, trained by Adam on the mean squared error.
//!
//! y = W₃ r(W₂ r(W₁ r(W₀ x̂ + b₀) + b₁) + b₂) + b₃ with r(z) = max(z, 0) and x̂ the standardised inputs; y is returned in its own unit.
//! A batch is a matrix with a column a sample. All numbers are f32, sums run in one order, and the same seed gives the same bytes.
//! Paper, section V, the thrust predictor.

mod file;
mod layer;
mod train;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use layer::Layer;

pub use file::NetworkFileError;
pub use train::{Epoch, Trained, Training, train};

/// Samples: rows of inputs, with one target each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// Inputs a row.
    pub width: usize,
    /// Row after row: rows × width.
    pub inputs: Vec<f32>,
    /// One a row; may be empty where only a prediction is wanted.
    pub targets: Vec<f32>,
}

impl Samples {
    /// Rows.
    pub fn row_count(&self) -> usize {
        self.inputs.len() / self.width.max(1)
    }
}

/// Means and standard deviations by which inputs and target are standardised.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Mean of each input.
    pub input_mean: Vec<f32>,
    /// Standard deviation of each input; 1 where it is constant.
    pub input_spread: Vec<f32>,
    /// Mean of the target.
    pub answer_mean: f32,
    /// Standard deviation of the target.
    pub answer_spread: f32,
}

impl Scale {
    /// The scale of samples.
    pub(crate) fn of_samples(samples: &Samples) -> Self {
        let column = |k: usize| samples.inputs.iter().skip(k).step_by(samples.width).map(|&v| f64::from(v));
        let inputs: Vec<(f32, f32)> =
            (0..samples.width).map(|k| mean_and_deviation(&column(k).collect::<Vec<_>>())).collect();
        let targets: Vec<f64> = samples.targets.iter().map(|&v| f64::from(v)).collect();
        let (answer_mean, answer_spread) = mean_and_deviation(&targets);
        let (input_mean, input_spread) = inputs.into_iter().unzip();
        Self { input_mean, input_spread, answer_mean, answer_spread }
    }
}

fn mean_and_deviation(values: &[f64]) -> (f32, f32) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    (mean as f32, if spread > 0.0 { spread as f32 } else { 1.0 })
}

/// A dense network with its scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    layers: Vec<Layer>,
    scale: Scale,
}

impl Network {
    /// An untrained network for samples of this scale with `hidden` layers, its weights initialised from `seed` as PyTorch draws
    /// them: uniform within ±1/√inputs.
    pub fn new(scale: Scale, hidden: &[usize], seed: u64) -> Self {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let sizes: Vec<usize> = [&[scale.input_mean.len()], hidden, &[1]].concat();
        let layers =
            sizes.windows(2).map(|w| Layer::initialised_layer(w[0], w[1], &mut || uniform_draw(&mut draw))).collect();
        Self { layers, scale }
    }

    /// Inputs of one prediction.
    pub(crate) fn input_width(&self) -> usize {
        self.scale.input_mean.len()
    }

    /// Weights and biases in all.
    pub fn parameter_count(&self) -> usize {
        self.layers.iter().map(|l| l.weight.len() + l.bias.len()).sum()
    }

    /// Predictions for rows of inputs (rows × width), in the target's unit.
    pub fn predict(&self, inputs: &[f32]) -> Vec<f32> {
        let Scale { answer_mean, answer_spread, .. } = self.scale;
        // Chunks bound the memory of the hidden layers; the products of a row do not depend on the chunk.
        let chunk = 1024 * self.input_width();
        let targets = inputs.chunks(chunk).flat_map(|rows| {
            let standardised = self.standardised_rows(rows);
            self.layers.iter().enumerate().fold(standardised, |x, (i, layer)| {
                let mut y = layer.forward_batch(&x, rows.len() / self.input_width());
                if i + 1 < self.layers.len() {
                    layer::rectify_values(&mut y);
                }
                y
            })
        });
        targets.map(|y| y * answer_spread + answer_mean).collect()
    }

    /// The prediction for one row and its derivative by each input (unit of the target per unit of the input), in f64: a gradient
    /// through a simulation is compared with differences.
    pub fn prediction_and_slope(&self, row: &[f64]) -> (f64, Vec<f64>) {
        let Scale { input_mean, input_spread, answer_mean, answer_spread } = &self.scale;
        let standardised = |k: usize| (row[k] - f64::from(input_mean[k])) / f64::from(input_spread[k]);
        let mut states: Vec<Vec<f64>> = vec![(0..row.len()).map(standardised).collect()];
        for (i, layer) in self.layers.iter().enumerate() {
            let is_last = i + 1 == self.layers.len();
            let y = layer.forward_f64(&states[i]).into_iter();
            states.push(y.map(|z| if is_last { z } else { z.max(0.0) }).collect());
        }
        let mut gradient = vec![1.0];
        for (i, layer) in self.layers.iter().enumerate().rev() {
            gradient = layer.backward_f64(&gradient);
            if i > 0 {
                gradient.iter_mut().zip(&states[i]).filter(|(_, y)| **y <= 0.0).for_each(|(p, _)| *p = 0.0);
            }
        }
        let spread = f64::from(*answer_spread);
        let answer = states[self.layers.len()][0] * spread + f64::from(*answer_mean);
        (answer, gradient.iter().zip(input_spread).map(|(p, s)| p * spread / f64::from(*s)).collect())
    }

    /// Standardised rows: width × rows, a column a sample.
    fn standardised_rows(&self, rows: &[f32]) -> Vec<f32> {
        let Scale { input_mean, input_spread, .. } = &self.scale;
        let entries = rows.iter().enumerate().map(|(i, x)| (i % self.input_width(), x));
        entries.map(|(k, x)| (x - input_mean[k]) / input_spread[k]).collect()
    }
}

/// Uniform between 0 and 1.
fn uniform_draw(draw: &mut ChaCha8Rng) -> f32 {
    (draw.next_u32() >> 8) as f32 / (1u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale() -> Scale {
        Scale {
            input_mean: vec![0.1, -0.2, 3.0],
            input_spread: vec![0.5, 2.0, 1.5],
            answer_mean: 0.7,
            answer_spread: 0.3,
        }
    }

    #[test]
    fn the_gradient_by_the_inputs_is_that_of_central_differences() {
        // the seeds give predictions on both sides of the mean
        for (seed, row) in (0..4).flat_map(|s| [[0.3, 1.1, 2.0], [-0.5, 0.2, 4.0], [0.1, 0.0, 0.0]].map(|row| (s, row)))
        {
            let network = Network::new(scale(), &[20, 30, 20], seed);
            let (answer, slope) = network.prediction_and_slope(&row);
            assert!((answer - f64::from(network.predict(&row.map(|x| x as f32))[0])).abs() < 1e-6);
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut other = row;
                    other[k] += by;
                    network.prediction_and_slope(&other).0
                };
                let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((difference - slope[k]).abs() < 1e-8, "{difference} {}", slope[k]);
            }
        }
    }

    #[test]
    fn a_batch_gives_the_predictions_of_its_rows() {
        let network = Network::new(scale(), &[20, 30], 4);
        let rows: Vec<f32> = (0..3 * 1500).map(|i| (0.01 * i as f32).sin()).collect();
        let all = network.predict(&rows);
        assert!(rows.chunks(3).zip(&all).all(|(row, y)| (network.predict(row)[0] - y).abs() < 1e-5));
    }

    #[test]
    fn a_constant_input_is_not_scaled() {
        let samples = Samples { width: 2, inputs: vec![1.0, 5.0, 3.0, 5.0], targets: vec![1.0, 2.0] };
        let scale = Scale::of_samples(&samples);
        assert_eq!((scale.input_spread, scale.input_mean), (vec![1.0, 1.0], vec![2.0, 5.0]));
    }

    #[test]
    fn a_network_has_a_weight_for_each_connection_and_a_bias_for_each_neuron() {
        // 3 → 5 → 2 → 1
        assert_eq!(Network::new(scale(), &[5, 2], 1).parameter_count(), (15 + 5) + (10 + 2) + (2 + 1));
        assert_eq!(Network::new(scale(), &[], 1).parameter_count(), 3 + 1);
    }
}
