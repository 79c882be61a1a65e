//! The equilibria of both sides and the reduced model: what every trial needs, solved once and kept as a checkpoint.
//!
//! The checkpoint is a file of safetensors. Its numbers are those that were solved, bit by bit, so that a recording has the same bytes
//! whether its trials were made by the process that solved them or by others.

use diagnostics::Result;
use fem::ReducedModelData;
use safetensors::{Dtype, SafeTensors, tensor::TensorView};

use super::STATICS;
use super::in_progress::InProgress;
use super::setup::Setup;
use crate::checkpoint;
use crate::physics::{FlappingModel, PressureSweep, snapshots};
use crate::side::Side;

/// Equilibria and reduced model of a specimen.
pub(super) struct Statics {
    /// Equilibria by pressure, left and right.
    pub(super) sweeps: [PressureSweep; 2],
    /// The reduced model.
    pub(super) reduced: ReducedModelData,
}

impl Statics {
    /// Loads them, or solves and saves them.
    ///
    /// # Errors
    /// When an equilibrium is not found or the checkpoint cannot be written.
    pub(super) fn of_setup(setup: &Setup, recording: &InProgress) -> Result<Self> {
        recording.make_once(
            STATICS,
            &|| Self::from_bytes(&checkpoint::load_bytes(&recording.folder, STATICS)?, setup),
            &|| Self::solve_statics(setup),
            &|statics| checkpoint::save_bytes(&recording.folder, STATICS, &statics.as_bytes()),
        )
    }

    fn solve_statics(setup: &Setup) -> Result<Self> {
        let (progress, name, body) = (setup.request.progress, setup.name, &setup.body);
        let pressures = setup.sweep_pressures();
        let task = progress.begin_step(STATICS, name, 2 * (pressures.len() - 1));
        let side = |side: Side| PressureSweep::solve_sweep(body, side, &pressures, &|| task.count_part());
        let (left, right) = rayon::join(|| side(Side::Left), || side(Side::Right));
        task.end_step(&format!("{} equilibria of {} unknowns", 2 * (pressures.len() - 1), body.system.dofs()));
        let sweeps = [left?, right?];
        let task = progress.begin_step("reduce", name, snapshots::COUNT);
        let reduced = FlappingModel::reduce_body(body, &setup.centre_line(), &sweeps, &|| task.count_part())?;
        let points: usize = reduced.points.iter().map(Vec::len).sum();
        task.end_step(&format!("{} coordinates, {points} points", reduced.modes.len()));
        Ok(Self { sweeps, reduced })
    }

    /// As a file: arrays of doubles, which hold the numbers of the sampled points exactly as well.
    fn as_bytes(&self) -> Vec<u8> {
        let Self { sweeps: [left, right], reduced } = self;
        let mut arrays: Vec<(String, Vec<f64>)> = vec![
            (Side::Left.channel_name().into(), left.shapes.concat()),
            (Side::Right.channel_name().into(), right.shapes.concat()),
            ("modes".into(), reduced.modes.concat()),
            ("size".into(), vec![reduced.size]),
        ];
        for (region, sampled) in reduced.points.iter().enumerate() {
            arrays.push((format!("points_{region}"), sampled.iter().map(|(point, _)| f64::from(*point)).collect()));
            arrays.push((format!("weights_{region}"), sampled.iter().map(|(_, weight)| *weight).collect()));
        }
        let raw: Vec<Vec<u8>> = arrays.iter().map(|(_, a)| a.iter().flat_map(|x| x.to_le_bytes()).collect()).collect();
        // length: each list of bytes was made from one array
        let views = arrays.iter().zip(&raw).map(|((name, array), bytes)| {
            let view = TensorView::new(Dtype::F64, vec![array.len()], bytes);
            (name, view.expect("a double has eight bytes"))
        });
        safetensors::serialize(views, None).expect("the arrays have different names")
    }

    /// From a file; nothing when it is not one of this specimen.
    fn from_bytes(bytes: &[u8], setup: &Setup) -> Option<Self> {
        let file = SafeTensors::deserialize(bytes).ok()?;
        let array = |name: &str| -> Option<Vec<f64>> {
            let (values, remainder) = file.tensor(name).ok()?.data().as_chunks();
            remainder.is_empty().then(|| values.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
        };
        let shapes = |name: &str| -> Option<Vec<Vec<f64>>> {
            let (values, length) = (array(name)?, 3 * setup.body.mesh.nodes.len());
            values.len().is_multiple_of(length).then(|| values.chunks(length).map(<[f64]>::to_vec).collect())
        };
        let pressures = setup.sweep_pressures();
        let sweep = |side: Side| {
            let shapes = shapes(side.channel_name())?;
            (shapes.len() == pressures.len()).then(|| PressureSweep { pressures: pressures.clone(), shapes })
        };
        let sampled = |region: usize| -> Option<Vec<(u32, f64)>> {
            let (points, weights) = (array(&format!("points_{region}"))?, array(&format!("weights_{region}"))?);
            let is_whole =
                points.len() == weights.len() && points.iter().all(|point| f64::from(*point as u32) == *point);
            is_whole.then(|| points.iter().map(|point| *point as u32).zip(weights).collect())
        };
        let reduced = ReducedModelData {
            modes: shapes("modes")?,
            points: (0..setup.body.system.regions().len()).map(sampled).collect::<Option<Vec<_>>>()?,
            size: *array("size")?.first()?,
        };
        if reduced.fault().is_some() {
            return None;
        }
        Some(Self { sweeps: [sweep(Side::Left)?, sweep(Side::Right)?], reduced })
    }
}
