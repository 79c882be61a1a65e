//! The reduced model: modes, projected mass, sampled elastic forces and chamber volumes.

use nalgebra::{DMatrix, DVector, Dyn, LU};
use si::CubicMetre;

use super::chamber_volume::CubicVolume;
use super::elastic_forces::Points;

/// By region: numbers of the sampled quadrature points in the full model, and their weights, m³.
pub(super) type Sampled = Vec<Vec<(u32, CubicMetre)>>;

/// The part of a reduced model that cannot be computed from its system again.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedModelData {
    /// Columns of V, 3 entries per node, m per unit of q.
    pub modes: Vec<Vec<f64>>,
    /// By region: numbers of the sampled quadrature points in the full model, and their weights, m³.
    pub points: Vec<Vec<(u32, CubicMetre)>>,
    /// Largest |q| of the snapshots.
    pub size: f64,
}

impl ReducedModelData {
    /// What is wrong with data that were read from a file: no modes, modes that differ in length, or a number out of range.
    pub fn fault(&self) -> Option<String> {
        let length = self.modes.first().map_or(0, Vec::len);
        if length == 0 || !length.is_multiple_of(3) || self.modes.iter().any(|mode| mode.len() != length) {
            return Some(format!("{} modes do not have 3 numbers per node each", self.modes.len()));
        }
        if let Some(mode) = self.modes.iter().position(|mode| mode.iter().any(|x| !x.is_finite())) {
            return Some(format!("mode {mode} holds a number that is not finite"));
        }
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        let weights = self.points.iter().flatten().map(|(_, weight)| *weight);
        let wrong = weights.chain([self.size]).find(|value| !is_positive(*value))?;
        Some(format!("the size or the weight of a point is {wrong}, and must be above 0"))
    }
}

/// A body in r generalised coordinates q.
#[derive(Debug)]
pub struct ReducedModel {
    /// V, (3 per node) × r, m per unit of q.
    pub(super) modes: DMatrix<f64>,
    /// Factor of VᵀV, r × r, m².
    pub(super) products: LU<f64, Dyn, Dyn>,
    /// r × r, kg m² in the units of q.
    pub(super) mass: DMatrix<f64>,
    /// Number of regions of the system.
    pub(super) regions: usize,
    /// Region after region.
    pub(super) points: Vec<Points>,
    /// One per chamber.
    pub(super) chambers: Vec<CubicVolume>,
    /// Largest |q| of the snapshots: the size that tolerances are relative to.
    pub(super) size: f64,
    pub(super) sampled: Sampled,
}

impl ReducedModel {
    /// Number of coordinates r.
    pub fn coordinates(&self) -> usize {
        self.modes.ncols()
    }

    /// Number of sampled quadrature points, by region.
    pub fn points(&self) -> Vec<usize> {
        self.sampled.iter().map(Vec::len).collect()
    }

    /// Displacements V q, 3 entries per node, m.
    pub fn displacement(&self, q: &DVector<f64>) -> Vec<f64> {
        (&self.modes * q).data.into()
    }

    /// The coordinates whose displacements are nearest to `displacement` (3 entries per node, m) in the sense of least squares.
    pub fn projected(&self, displacement: &[f64]) -> DVector<f64> {
        let onto = self.modes.tr_mul(&DVector::from_column_slice(displacement));
        self.products.solve(&onto).unwrap_or_else(|| DVector::zeros(onto.len()))
    }

    /// The row of V of the dof `index` (3 node + axis), m per unit of q.
    pub fn row(&self, index: usize) -> impl Iterator<Item = f64> + '_ {
        self.modes.row(index).into_iter().copied().collect::<Vec<_>>().into_iter()
    }

    /// Volume of `chamber` at q, m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber.
    pub fn chamber_volume(&self, chamber: usize, q: &DVector<f64>) -> si::CubicMetre {
        self.chambers[chamber].volume_at(q)
    }

    /// Elastic energy density that each sampled point of `region` integrates at q, J/m³ at rest.
    ///
    /// # Panics
    /// When there is no such region.
    pub fn energy_densities(&self, region: usize, q: &DVector<f64>) -> Vec<f64> {
        assert!(region < self.regions, "region {region} of {}", self.regions);
        let mut densities = Vec::new();
        for points in self.points.iter().filter(|points| points.region == region) {
            let elastic = points.elastic();
            points.for_each_deformation(q, |deformation| {
                densities.push(elastic.material.energy_and_stress(deformation, elastic.moduli).0);
            });
        }
        densities
    }

    /// The data from which [`crate::System::restore`] restores the model.
    pub fn data(&self) -> ReducedModelData {
        let modes = self.modes.column_iter().map(|mode| mode.iter().copied().collect()).collect();
        ReducedModelData { modes, points: self.sampled.clone(), size: self.size }
    }
}
