//! What a reduced model is trained on: shapes, the constants under which the body took them, and directions in which they change.

use materials::material::Moduli;
use nalgebra::DVector;

use crate::properties::RegionProperties;
use crate::system_data::SystemData;

/// A shape at which the cubature must reproduce the forces: q, and the moduli of each region that acted.
pub(super) type TrainingShape = (DVector<f64>, Vec<Moduli>);

/// A shape that the full model took under loads like those to come.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// 3 entries per node, m.
    pub displacement: &'a [f64],
    /// One per region: the constants under which it did; of none, those that the system was made with.
    pub regions: &'a [RegionProperties],
    /// Changes of the shape, as by a constant or by a pressure, each as large as it may become; 3 entries per node, m.
    // They cost one solve each with the factor at hand, and span what a further equilibrium would.
    pub changes: &'a [Vec<f64>],
}

impl<'a> Snapshot<'a> {
    /// A shape under the system's own constants.
    pub(crate) fn of_shape(displacement: &'a [f64]) -> Self {
        Self { displacement, regions: &[], changes: &[] }
    }

    /// Whether every field has `length` numbers, and there are as many constants as the system has regions.
    pub(super) fn is_of(&self, system: &SystemData) -> bool {
        let length = 3 * system.mesh.nodes.len();
        let is_whole = |field: &[f64]| field.len() == length;
        is_whole(self.displacement)
            && self.changes.iter().all(|change| is_whole(change))
            && (self.regions.is_empty() || self.regions.len() == system.regions.len())
    }

    /// The moduli that acted, one per region.
    pub(super) fn acting_moduli(&self, system: &SystemData) -> Vec<Moduli> {
        let regions = if self.regions.is_empty() { &system.regions } else { self.regions };
        regions.iter().map(RegionProperties::moduli).collect()
    }
}
