//! A trained reduced model as safetensors: what `softfish.ReducedModel.load` reads, with the box that it was trained over beside.

use std::path::Path;

use fem::ReducedModelData;
use safetensors::{Dtype, tensor::TensorView};
use serde::Serialize;

use super::ranges::NamedRange;
use diagnostics::{Diagnostic, Result};

/// What a model was trained on, kept with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TrainingNote {
    pub constants: Vec<NamedRange>,
    /// One per chamber of the mesh, Pa.
    pub pressures: Vec<NamedRange>,
    pub equilibria: usize,
    pub checked: usize,
    /// Of a node at a checked point, over the largest displacement.
    pub largest_difference: f64,
}

/// Writes modes (coordinates × nodes × 3), points and weights of each region, and size.
///
/// # Errors
/// A [`Diagnostic`] when the file cannot be written; it is then as before.
pub(super) fn write_model(path: &Path, model: &ReducedModelData, note: &TrainingNote) -> Result<()> {
    let doubles = |values: &mut dyn Iterator<Item = f64>| values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let nodes = model.modes.first().map_or(0, |mode| mode.len() / 3);
    let mut tensors: Vec<(String, Dtype, Vec<usize>, Vec<u8>)> = vec![
        (
            "modes".into(),
            Dtype::F64,
            vec![model.modes.len(), nodes, 3],
            doubles(&mut model.modes.iter().flatten().copied()),
        ),
        ("size".into(), Dtype::F64, vec![1], doubles(&mut std::iter::once(model.size))),
    ];
    for (region, points) in model.points.iter().enumerate() {
        let numbers = points.iter().flat_map(|(point, _)| i64::from(*point).to_le_bytes()).collect();
        tensors.push((format!("points.{region}"), Dtype::I64, vec![points.len()], numbers));
        let weights = doubles(&mut points.iter().map(|(_, weight)| *weight));
        tensors.push((format!("weights.{region}"), Dtype::F64, vec![points.len()], weights));
    }
    let refused =
        |what: String| Diagnostic::new(format!("{} cannot be written", path.display()), what, "check the folder");
    let views =
        tensors.iter().map(|(name, kind, shape, bytes)| Ok((name, TensorView::new(*kind, shape.clone(), bytes)?)));
    let views: Vec<_> =
        views.collect::<Result<_, safetensors::SafeTensorError>>().map_err(|e| refused(e.to_string()))?;
    // one entry: a map of several has no order
    let text = serde_json::to_string(note).map_err(|e| refused(e.to_string()))?;
    let bytes = safetensors::serialize(views, Some([("training".to_owned(), text)].into()));
    let bytes = bytes.map_err(|e| refused(e.to_string()))?;
    let partial = path.with_extension("partial");
    std::fs::write(&partial, bytes).and_then(|()| std::fs::rename(&partial, path)).map_err(|e| refused(e.to_string()))
}
