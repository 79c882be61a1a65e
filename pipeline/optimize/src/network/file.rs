//! A network as a safetensors file that PyTorch loads: the key names of an `nn.Sequential` of `Linear` and `ReLU`.
//!
//! `0.weight` (outputs × inputs), `0.bias`, `2.weight`, … with the rectifiers at the odd places; beside them `input_mean`,
//! `input_spread`, `answer_mean` and `answer_spread`, the means and standard deviations of inputs and targets.

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use std::collections::BTreeMap;

use super::layer::Layer;
use super::{Network, Scale};

/// Why bytes are not a network.
#[derive(Debug, thiserror::Error)]
pub enum NetworkFileError {
    /// Not a safetensors file, or a tensor is absent.
    #[error("the file holds no network\n  why: {0}\n  do:  train it again")]
    Format(#[from] safetensors::SafeTensorError),
    /// Tensors of other types or shapes than a network's.
    #[error("the file holds no network\n  why: {0}\n  do:  train it again")]
    Shape(String),
}

impl Network {
    /// The bytes of a safetensors file; the same network gives the same bytes.
    ///
    /// # Errors
    /// [`NetworkFileError`] when safetensors refuses a shape, which it does not for a network made here.
    pub fn to_safetensors(&self) -> Result<Vec<u8>, NetworkFileError> {
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
        let views = views.collect::<Result<Vec<_>, _>>()?;
        Ok(safetensors::serialize(views, None)?)
    }

    /// The network in the bytes of a file.
    ///
    /// # Errors
    /// [`NetworkFileError`] when the bytes are no safetensors, or a tensor is absent or of another shape.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, NetworkFileError> {
        let file = SafeTensors::deserialize(bytes)?;
        let list = |name: &str| -> Result<(Vec<usize>, Vec<f32>), NetworkFileError> {
            let view = file.tensor(name)?;
            if view.dtype() != Dtype::F32 {
                return Err(NetworkFileError::Shape(format!("`{name}` is not of 32-bit numbers")));
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
                _ => return Err(NetworkFileError::Shape(format!("layer {} has the shape {shape:?}", layers.len()))),
            }
        }
        let one = |name: &str| list(name).map(|(_, values)| values[0]);
        let (input_mean, input_spread) = (list("input_mean")?.1, list("input_spread")?.1);
        let width = layers.first().map_or(0, |l| l.inputs);
        let ends = layers.last().map(|l| l.outputs);
        if width == 0 || input_mean.len() != width || input_spread.len() != width || ends != Some(1) {
            return Err(NetworkFileError::Shape(format!(
                "{} layers, {width} inputs, {} means",
                layers.len(),
                input_mean.len()
            )));
        }
        let (answer_mean, answer_spread) = (one("answer_mean")?, one("answer_spread")?);
        Ok(Self { layers, scale: Scale { input_mean, input_spread, answer_mean, answer_spread } })
    }
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
    fn a_network_read_from_its_file_is_the_same_and_has_the_same_bytes() {
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
