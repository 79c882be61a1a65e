//! The arrays of a reduced model, for a program that steps it by itself.

use super::chamber_volume::CubicVolume;
use super::elastic_forces::Points;
use super::model::ReducedModel;
use materials::material::{Material, Moduli};
use si::CubicMetre;

/// The arrays of a reduced model of r coordinates q, column after column where they are matrices.
#[derive(Debug, Clone)]
pub struct ReducedArrays<'a> {
    /// VᵀMV, r × r, kg m² in the units of q.
    pub mass: &'a [f64],
    /// Largest |q| of the snapshots.
    pub size: f64,
    /// One per region, two where its elements share the energy between two sets of points.
    pub regions: Vec<ReducedRegion<'a>>,
    /// One per chamber: V₀ (m³), and a (r), B (r × r) and C (r × pairs i ≤ j) of V₀ + a·q + ½ B q q + ⅙ C q q q.
    pub chambers: Vec<(CubicMetre, [&'a [f64]; 3])>,
}

/// Sampled quadrature points of one region that integrate the same shares of its energy.
#[derive(Debug, Clone, Copy)]
pub struct ReducedRegion<'a> {
    /// Number of the region in the system.
    pub region: usize,
    /// Its law.
    pub material: &'static dyn Material,
    /// The points' shares of its moduli when the system was reduced.
    pub moduli: Moduli,
    /// Weight of each point, m³.
    pub weights: &'a [f64],
    /// ∂F/∂q, points × 9 × r: columns of F one below the other.
    pub gradients: &'a [f64],
}

impl ReducedModel {
    /// Its arrays.
    pub fn arrays(&self) -> ReducedArrays<'_> {
        ReducedArrays {
            mass: self.mass.as_slice(),
            size: self.size,
            regions: self.points.iter().map(Points::arrays).collect(),
            chambers: self.chambers.iter().map(CubicVolume::arrays).collect(),
        }
    }
}

impl Points {
    fn arrays(&self) -> ReducedRegion<'_> {
        let (elastic, weights, gradients) = (self.elastic(), self.weights(), self.gradients());
        ReducedRegion { region: self.region, material: elastic.material, moduli: elastic.moduli, weights, gradients }
    }
}
