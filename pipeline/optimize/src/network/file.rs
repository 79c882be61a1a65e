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
        let mut tensors: BTreeMap<String, (Vec<usize>, Vec<u8>)> = BTreeMap::new();
        let mut insert_tensor = |name: String, shape: Vec<usize>, values: &[f32]| {
            tensors.insert(name, (shape, values.iter().flat_map(|v| v.to_le_bytes()).collect()));
        };
        for (i, layer) in self.layers.iter().enumerate() {
            insert_tensor(format!("{}.weight", 2 * i), vec![layer.outputs, layer.inputs], &layer.weight);
            insert_tensor(format!("{}.bias", 2 * i), vec![layer.outputs], &layer.bias);
        }
        let Scale { input_mean, input_spread, answer_mean, answer_spread } = &self.scale;
        insert_tensor("input_mean".into(), vec![self.input_width()], input_mean);
        insert_tensor("input_spread".into(), vec![self.input_width()], input_spread);
        insert_tensor("answer_mean".into(), vec![1], &[*answer_mean]);
        insert_tensor("answer_spread".into(), vec![1], &[*answer_spread]);
        let views = tensors.iter().map(|(name, (shape, bytes))| {
            TensorView::new(Dtype::F32, shape.clone(), bytes).map(|view| (name.as_str(), view))
        });
        let views = views.collect::<Result<Vec<_>, _>>()?;
        Ok(safetensors::serialize(views, None)?)
    }

    /// The network in the bytes of a file.
    ///
    /// # Errors
    /// [`NetworkFileError`] when the bytes are no safetensors, or a tensor is absent, of another type or shape, not finite, or none of a
    /// network.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, NetworkFileError> {
        let file = SafeTensors::deserialize(bytes)?;
        let count = file.names().iter().filter(|name| name.ends_with(WEIGHT)).count();
        let required = 2 * count + SCALE.len();
        if count == 0 || file.len() != required {
            let defect = format!("it has {} tensors; {count} layers with their scale have {required}", file.len());
            return Err(NetworkFileError::Shape(defect));
        }
        let layers = (0..count).map(|number| layer_from_file(&file, number)).collect::<Result<Vec<_>, _>>()?;
        check_joints(&layers)?;
        let width = layers[0].inputs;
        let scale = Scale {
            input_mean: tensor_values(&file, SCALE[0], &[width])?,
            input_spread: positive_values(SCALE[1], tensor_values(&file, SCALE[1], &[width])?)?,
            answer_mean: tensor_values(&file, SCALE[2], &[1])?[0],
            answer_spread: positive_values(SCALE[3], tensor_values(&file, SCALE[3], &[1])?)?[0],
        };
        Ok(Self { layers, scale })
    }
}

/// Ending of a layer's weights.
const WEIGHT: &str = ".weight";
/// Tensors of the scale.
const SCALE: [&str; 4] = ["input_mean", "input_spread", "answer_mean", "answer_spread"];

/// The numbers of one tensor.
fn tensor_values(file: &SafeTensors, name: &str, shape: &[usize]) -> Result<Vec<f32>, NetworkFileError> {
    let view = file.tensor(name)?;
    if view.dtype() != Dtype::F32 {
        return Err(NetworkFileError::Shape(format!("`{name}` holds {:?}, not F32", view.dtype())));
    }
    if view.shape() != shape {
        return Err(NetworkFileError::Shape(format!("`{name}` has the shape {:?}, not {shape:?}", view.shape())));
    }
    // length: safetensors holds a tensor to the bytes of its shape
    let numbers = view.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let numbers: Vec<f32> = numbers.collect();
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(NetworkFileError::Shape(format!("`{name}` holds {number}, and must be finite"))),
        None => Ok(numbers),
    }
}

fn layer_from_file(file: &SafeTensors, number: usize) -> Result<Layer, NetworkFileError> {
    let (weight, bias) = (format!("{}{WEIGHT}", 2 * number), format!("{}.bias", 2 * number));
    let &[outputs, inputs] = file.tensor(&weight)?.shape() else {
        return Err(NetworkFileError::Shape(format!("`{weight}` is no matrix")));
    };
    let (weight, bias) = (tensor_values(file, &weight, &[outputs, inputs])?, tensor_values(file, &bias, &[outputs])?);
    Ok(Layer { inputs, outputs, weight, bias })
}

/// Each layer takes what the one before gives, and the last gives one number.
fn check_joints(layers: &[Layer]) -> Result<(), NetworkFileError> {
    let expected_outputs = layers.iter().skip(1).map(|layer| layer.inputs).chain([1]);
    // length: one number is taken from each layer, the last one by the reader of the prediction
    for (number, (layer, expected_outputs)) in layers.iter().zip(expected_outputs).enumerate() {
        if layer.outputs != expected_outputs || layer.inputs == 0 {
            let [name, next_name] = [2 * number, 2 * number + 2].map(|number| format!("`{number}{WEIGHT}`"));
            let next_name = if number + 1 == layers.len() { "a prediction".to_owned() } else { next_name };
            let (inputs, outputs) = (layer.inputs, layer.outputs);
            let defect = format!(
                "{name} has {inputs} inputs and {outputs} outputs, of which {next_name} takes {expected_outputs}"
            );
            return Err(NetworkFileError::Shape(defect));
        }
    }
    Ok(())
}

/// Standard deviations are above 0: inputs are divided by them.
fn positive_values(name: &str, values: Vec<f32>) -> Result<Vec<f32>, NetworkFileError> {
    match values.iter().find(|value| **value <= 0.0) {
        Some(value) => Err(NetworkFileError::Shape(format!("`{name}` has {value}, and must be above 0"))),
        None => Ok(values),
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

    /// The same file with one tensor replaced, or left out.
    fn with(name: &str, tensor: Option<(Vec<usize>, Vec<f32>)>) -> Vec<u8> {
        let bytes = network().to_safetensors().unwrap();
        let file = SafeTensors::deserialize(&bytes).unwrap();
        let kept = file.names().into_iter().filter(|own| *own != name);
        let mut tensors: BTreeMap<String, (Vec<usize>, Vec<u8>)> = kept
            .map(|own| (own.to_owned(), file.tensor(own).map(|t| (t.shape().to_vec(), t.data().to_vec())).unwrap()))
            .collect();
        if let Some((shape, values)) = tensor {
            tensors.insert(name.to_owned(), (shape, values.iter().flat_map(|v| v.to_le_bytes()).collect()));
        }
        let views = tensors.iter().map(|(n, (s, b))| (n, TensorView::new(Dtype::F32, s.clone(), b).unwrap()));
        safetensors::serialize(views, None).unwrap()
    }

    #[test]
    fn a_tensor_that_is_missing_extra_of_another_shape_or_out_of_range_is_refused_by_name() {
        for (name, tensor, words) in [
            ("6.weight", None, "it has 11 tensors; 3 layers"),
            ("6.bias", None, "it has 11 tensors; 4 layers"),
            ("8.weight", Some((vec![1, 1], vec![1.0])), "it has 13 tensors; 5 layers"),
            ("more", Some((vec![1], vec![1.0])), "it has 13 tensors; 4 layers"),
            ("2.weight", Some((vec![5, 6], vec![1.0; 30])), "`2.bias` has the shape [6], not [5]"),
            ("2.bias", Some((vec![5], vec![1.0; 5])), "`2.bias` has the shape [5], not [6]"),
            ("0.weight", Some((vec![20], vec![1.0; 20])), "`0.weight` is no matrix"),
            ("0.weight", Some((vec![5, 3], vec![1.0; 15])), "`input_mean` has the shape [4], not [3]"),
            (
                "4.weight",
                Some((vec![5, 5], vec![1.0; 25])),
                "`2.weight` has 5 inputs and 6 outputs, of which `4.weight` takes 5",
            ),
            ("answer_mean", Some((vec![0], vec![])), "`answer_mean` has the shape [0], not [1]"),
            ("answer_spread", Some((vec![1], vec![0.0])), "`answer_spread` has 0"),
            ("input_spread", Some((vec![4], vec![1.0, -1.0, 1.0, 1.0])), "`input_spread` has -1"),
            ("input_mean", Some((vec![4], vec![f32::NAN; 4])), "`input_mean` holds NaN"),
        ] {
            let error = Network::from_safetensors(&with(name, tensor)).unwrap_err().to_string();
            assert!(error.contains(words), "{name}: {error}");
        }
    }
}
