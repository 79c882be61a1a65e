//! Reducing a system to a model, and restoring the model from its data.

use nalgebra::DMatrix;

use super::chamber_volume::CubicVolume;
use super::error::ReducedError;
use super::model::{ReducedModel, ReducedModelData};
use super::pod::{Pod, ReductionSettings};
use super::training::{Snapshot, TrainingShape};
use super::{ecsw, pod};
use crate::system::System;

impl System {
    /// Reduces the body to coordinates spanned by `snapshots`: displacements (3 entries per node, m) of the full model
    /// under loads like those to come, without the undeformed shape.
    ///
    /// # Errors
    /// [`ReducedError`] when there are no snapshots, they are not of this system, or a region uses mean dilatation.
    pub fn reduce(&self, snapshots: &[&[f64]], settings: &ReductionSettings) -> Result<ReducedModel, ReducedError> {
        let snapshots: Vec<Snapshot> = snapshots.iter().map(|shape| Snapshot::of_shape(shape)).collect();
        self.reduce_trained(&snapshots, settings)
    }

    /// As [`System::reduce`], from shapes under several sets of constants and with the directions in which they change: the model serves for
    /// all bodies between.
    ///
    /// # Errors
    /// As [`System::reduce`].
    pub fn reduce_trained(
        &self,
        snapshots: &[Snapshot],
        settings: &ReductionSettings,
    ) -> Result<ReducedModel, ReducedError> {
        let system = &*self.data;
        let count = snapshots.len();
        if snapshots.is_empty() || !snapshots.iter().all(|snapshot| snapshot.is_of(system)) {
            return Err(ReducedError::Snapshots { count, required: system.full_length() });
        }
        self.check_reducible()?;
        let shapes = snapshots.iter().map(|snapshot| snapshot.displacement);
        let changes = snapshots.iter().flat_map(|snapshot| snapshot.changes.iter().map(Vec::as_slice));
        let fields: Vec<&[f64]> = shapes.chain(changes).collect();
        let Pod { modes, coordinates } =
            pod::decompose(system, &fields, settings).ok_or(ReducedError::NoMode { count })?;
        let moduli = snapshots.iter().map(|snapshot| snapshot.acting_moduli(system));
        // of the coordinates, those of the shapes come first
        let training: Vec<TrainingShape> = coordinates.into_iter().zip(moduli).collect();
        let points = ecsw::sample_points(system, &modes, &training, settings.tolerance);
        let size = training.iter().flat_map(|(q, _)| q.iter()).fold(0.0, |most: f64, q| most.max(q.abs()));
        let modes = modes.column_iter().map(|mode| mode.iter().copied().collect()).collect();
        self.restore(&ReducedModelData { modes, points, size })
    }

    /// The reduced model with the given `data`: the same numbers as when it was reduced.
    ///
    /// # Errors
    /// [`ReducedError`] when the data are of another system, or a region uses mean dilatation.
    pub fn restore(&self, data: &ReducedModelData) -> Result<ReducedModel, ReducedError> {
        let system = &*self.data;
        self.check_reducible()?;
        self.check_data(data)?;
        let rows = system.full_length();
        let modes = DMatrix::from_iterator(rows, data.modes.len(), data.modes.iter().flatten().copied());
        let mass = pod::projected_mass(system, &modes);
        let points = ecsw::point_groups(system, &modes, &data.points);
        let chambers = system.chambers.iter().map(|chamber| CubicVolume::of(chamber, &modes, data.size)).collect();
        let products = modes.tr_mul(&modes).lu();
        let regions = system.regions.len();
        Ok(ReducedModel {
            modes,
            products,
            mass,
            regions,
            points,
            chambers,
            size: data.size,
            sampled: data.points.clone(),
        })
    }

    /// # Errors
    /// [`ReducedError::MeanDilatation`]
    fn check_reducible(&self) -> Result<(), ReducedError> {
        if self.data.options.mean_dilatation.contains(&true) { Err(ReducedError::MeanDilatation) } else { Ok(()) }
    }

    /// # Errors
    /// [`ReducedError::Foreign`]
    fn check_data(&self, data: &ReducedModelData) -> Result<(), ReducedError> {
        let system = &*self.data;
        let rows = 3 * system.mesh.nodes.len();
        let foreign = |what: String| Err(ReducedError::Foreign { what });
        if data.modes.is_empty() || data.modes.iter().any(|mode| mode.len() != rows) {
            return foreign(format!("a mode of this system has {rows} numbers, 3 per node"));
        }
        if data.points.len() != system.regions.len() {
            return foreign(format!("points of {} regions, not of {}", data.points.len(), system.regions.len()));
        }
        if !(data.size > 0.0 && data.size.is_finite()) || data.modes.iter().flatten().any(|v| !v.is_finite()) {
            return foreign("a number is not finite".into());
        }
        for (region, sampled) in data.points.iter().enumerate() {
            let is_in_region = |point: u32| {
                let element = point as usize / system.reference.points;
                system.mesh.regions.get(element).is_some_and(|r| *r as usize == region)
            };
            if let Some((point, _)) =
                sampled.iter().find(|(point, weight)| !is_in_region(*point) || weight.is_nan() || *weight <= 0.0)
            {
                return foreign(format!("quadrature point {point} is not in region {region}"));
            }
        }
        Ok(())
    }
}
