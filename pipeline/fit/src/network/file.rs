//! A network as a safetensors file that PyTorch loads: the key names of an `nn.Sequential` of `Linear` and `ReLU`.
//!
//! `0.weight` (outputs × inputs), `0.bias`, `2.weight`, … with the rectifiers at the odd places; beside them `input_mean`,
//! `input_spread`, `answer_mean` and `answer_spread`, which bring inputs and answers to one size.
//!
//! Stands on: safetensors. Never knows: a path.

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use std::collections::BTreeMap;

use super::layer::Layer;
use super::{Network, Scale};

/// Why bytes are not a network.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the file holds no network\n  why: {0}\n  do:  train it again")]
pub struct NotANetwork(String);

impl Network {
    /// The bytes of a safetensors file; the same network gives the same bytes.
    ///
    /// # Errors
    /// [`NotANetwork`] when safetensors refuses a shape, which it never does for a network made here.
    pub fn to_safetensors(&self) -> Result<Vec<u8>, NotANetwork> {
        let mut lists: BTreeMap<String, (Vec<usize>, Vec<u8>)> = BTreeMap::new();
        let mut put = |name: String, shape: Vec<usize>, values: &[f32]| {
            lists.insert(name, (shape, values.iter().flat_map(|v| v.to_le_bytes()).collect()));
        };
        for (i, layer) in self.layers.iter().enumerate() {
            put(format!("{}.weight", 2 * i), vec![layer.outputs, layer.inputs], &layer.weight);
            put(format!("{}.bias", 2 * i), vec![layer.outputs], &layer.bias);
        }
        let Scale { input_mean, input_spread, answer_mean, answer_spread } = &self.scale;
        put("input_mean".into(), vec![self.width()], input_mean);
        put("input_spread".into(), vec![self.width()], input_spread);
        put("answer_mean".into(), vec![1], &[*answer_mean]);
        put("answer_spread".into(), vec![1], &[*answer_spread]);
        let views = lists.iter().map(|(name, (shape, bytes))| {
            TensorView::new(Dtype::F32, shape.clone(), bytes).map(|view| (name.as_str(), view))
        });
        let views = views.collect::<Result<Vec<_>, _>>().map_err(not)?;
        safetensors::serialize(views, None).map_err(not)
    }

    /// The network in the bytes of a file.
    ///
    /// # Errors
    /// [`NotANetwork`] when the bytes are no safetensors, or a tensor is absent or of another shape.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, NotANetwork> {
        let file = SafeTensors::deserialize(bytes).map_err(not)?;
        let list = |name: &str| -> Result<(Vec<usize>, Vec<f32>), NotANetwork> {
            let view = file.tensor(name).map_err(not)?;
            if view.dtype() != Dtype::F32 {
                return Err(NotANetwork(format!("`{name}` is not of 32-bit numbers")));
            }
            let numbers = view.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            Ok((view.shape().to_vec(), numbers.collect()))
        };
        let mut layers: Vec<Layer> = Vec::new();
        while let Ok((shape, weight)) = list(&format!("{}.weight", 2 * layers.len())) {
            let (bias_shape, bias) = list(&format!("{}.bias", 2 * layers.len()))?;
            let before = layers.last().map(|l| l.outputs);
            match shape.as_slice() {
                &[outputs, inputs] if bias_shape == [outputs] && before.is_none_or(|b| b == inputs) => {
                    layers.push(Layer { inputs, outputs, weight, bias });
                }
                _ => return Err(NotANetwork(format!("layer {} has the shape {shape:?}", layers.len()))),
            }
        }
        let one = |name: &str| list(name).map(|(_, values)| values[0]);
        let (input_mean, input_spread) = (list("input_mean")?.1, list("input_spread")?.1);
        let width = layers.first().map_or(0, |l| l.inputs);
        let ends = layers.last().map(|l| l.outputs);
        if width == 0 || input_mean.len() != width || input_spread.len() != width || ends != Some(1) {
            return Err(NotANetwork(format!("{} layers, {width} inputs, {} means", layers.len(), input_mean.len())));
        }
        let (answer_mean, answer_spread) = (one("answer_mean")?, one("answer_spread")?);
        Ok(Self { layers, scale: Scale { input_mean, input_spread, answer_mean, answer_spread } })
    }
}

fn not(error: safetensors::SafeTensorError) -> NotANetwork {
    NotANetwork(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network() -> Network {
        let scale =
            Scale { input_mean: vec![0.1; 4], input_spread: vec![2.0; 4], answer_mean: 0.7, answer_spread: 0.3 };
        Network::new(scale, &[5, 6, 5], 9)
    }

    #[test]
    fn a_network_survives_its_file_and_gives_the_same_bytes_twice() {
        let bytes = network().to_safetensors().unwrap();
        assert_eq!(bytes, network().to_safetensors().unwrap());
        assert_eq!(Network::from_safetensors(&bytes).unwrap(), network());
    }

    #[test]
    fn keys_and_shapes_are_those_of_a_sequential_in_pytorch() {
        let bytes = network().to_safetensors().unwrap();
        let file = SafeTensors::deserialize(&bytes).unwrap();
        for (name, shape) in
            [("0.weight", vec![5, 4]), ("2.weight", vec![6, 5]), ("6.weight", vec![1, 5]), ("6.bias", vec![1])]
        {
            assert_eq!(file.tensor(name).unwrap().shape(), shape, "{name}");
        }
    }

    #[test]
    fn bytes_that_are_no_network_are_refused() {
        assert!(Network::from_safetensors(b"not a file").is_err());
    }
}
