//! One dense layer: y = W x + b for a batch, and its backpropagation.
//!
//! `weight` is outputs × inputs, row after row, as PyTorch's `nn.Linear` stores it; a batch is inputs × batch with a column
//! a sample, column after column.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// Weights and biases.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    pub inputs: usize,
    pub outputs: usize,
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
}

/// The gradient of a loss by a layer's weights and biases.
#[derive(Debug, Clone, Default)]
pub(super) struct LayerGradient {
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
}

impl Layer {
    /// Weights and biases uniform within ±1/√inputs; `unit` draws between 0 and 1.
    pub(crate) fn initialised_layer(inputs: usize, outputs: usize, unit: &mut dyn FnMut() -> f32) -> Self {
        let bound = 1.0 / (inputs as f32).sqrt();
        let mut draw = |count: usize| (0..count).map(|_| bound * (2.0 * unit() - 1.0)).collect::<Vec<f32>>();
        let weight = draw(inputs * outputs);
        Self { inputs, outputs, weight, bias: draw(outputs) }
    }

    /// W as inputs × outputs, column after column: its transpose, because its rows are contiguous.
    fn transposed_weights(&self) -> MatRef<'_, f32> {
        MatRef::from_column_major_slice(&self.weight, self.inputs, self.outputs)
    }

    /// outputs × batch.
    pub(crate) fn forward_batch(&self, x: &[f32], batch: usize) -> Vec<f32> {
        let mut y = Vec::with_capacity(self.outputs * batch);
        (0..batch).for_each(|_| y.extend_from_slice(&self.bias));
        let output = MatMut::from_column_major_slice_mut(&mut y, self.outputs, batch);
        let x = MatRef::from_column_major_slice(x, self.inputs, batch);
        matmul(output, Accum::Add, self.transposed_weights().transpose(), x, 1.0, Par::Seq);
        y
    }

    /// The gradient of the loss by the inputs (inputs × batch), from that by the outputs.
    pub(crate) fn backward_batch(&self, output_gradient: &[f32], batch: usize) -> Vec<f32> {
        let mut input_gradient = vec![0.0; self.inputs * batch];
        let product = MatMut::from_column_major_slice_mut(&mut input_gradient, self.inputs, batch);
        let output_gradient = MatRef::from_column_major_slice(output_gradient, self.outputs, batch);
        matmul(product, Accum::Replace, self.transposed_weights(), output_gradient, 1.0, Par::Seq);
        input_gradient
    }

    /// W x + b of one sample in f64.
    pub(crate) fn forward_f64(&self, x: &[f64]) -> Vec<f64> {
        let dot = |row: &[f32]| row.iter().zip(x).map(|(w, x)| f64::from(*w) * x).sum::<f64>();
        self.weight.chunks_exact(self.inputs).zip(&self.bias).map(|(row, b)| dot(row) + f64::from(*b)).collect()
    }

    /// Wᵀ y of one sample in f64.
    pub(crate) fn backward_f64(&self, output_gradient: &[f64]) -> Vec<f64> {
        let mut input_gradient = vec![0.0; self.inputs];
        for (row, p) in self.weight.chunks_exact(self.inputs).zip(output_gradient) {
            input_gradient.iter_mut().zip(row).for_each(|(b, w)| *b += f64::from(*w) * p);
        }
        input_gradient
    }

    /// The gradient of the loss by weights and biases, into `layer_gradient`.
    pub(crate) fn weight_gradient(
        &self,
        x: &[f32],
        output_gradient: &[f32],
        batch: usize,
        layer_gradient: &mut LayerGradient,
    ) {
        layer_gradient.weight.resize(self.weight.len(), 0.0);
        let product = MatMut::from_column_major_slice_mut(&mut layer_gradient.weight, self.inputs, self.outputs);
        let x = MatRef::from_column_major_slice(x, self.inputs, batch);
        let gradients = MatRef::from_column_major_slice(output_gradient, self.outputs, batch);
        matmul(product, Accum::Replace, x, gradients.transpose(), 1.0, Par::Seq);
        layer_gradient.bias.clear();
        layer_gradient.bias.resize(self.outputs, 0.0);
        for column in output_gradient.chunks_exact(self.outputs) {
            layer_gradient.bias.iter_mut().zip(column).for_each(|(b, p)| *b += p);
        }
    }
}

/// max(z, 0), in place.
pub(super) fn rectify_values(values: &mut [f32]) {
    values.iter_mut().for_each(|v| *v = v.max(0.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_is_the_product_written_out() {
        let weight = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let layer = Layer { inputs: 3, outputs: 2, weight, bias: vec![0.5, -0.5] };
        assert_eq!(layer.forward_batch(&[1.0, 0.0, -1.0, 2.0, 1.0, 0.0], 2), [-1.5, -2.5, 4.5, 12.5]);
        assert_eq!(layer.backward_batch(&[1.0, 1.0], 1), [5.0, 7.0, 9.0]);
        let mut found = LayerGradient::default();
        layer.weight_gradient(&[1.0, 2.0, 3.0], &[1.0, -2.0], 1, &mut found);
        assert_eq!(found.weight, [1.0, 2.0, 3.0, -2.0, -4.0, -6.0]);
        assert_eq!(found.bias, [1.0, -2.0]);
    }
}
