//! One step of the branches of every region, and the stress that the past adds to it.

use crate::assembly::elastic::Elastic;
use crate::properties::RegionProperties;
use crate::system_data::SystemData;
use crate::viscoelastic::history::{History, for_each_point};
use materials::step::RegionStep;
use materials::symmetric::{Symmetric, add_scaled};
use si::Second;

/// The regions' steps of one length; `None` when no region relaxes.
pub(crate) fn region_steps(properties: &[RegionProperties], step: Second) -> Option<Vec<RegionStep>> {
    let relaxes = properties.iter().any(|is| !is.relaxation.is_none());
    relaxes
        .then(|| properties.iter().map(|is| RegionStep::new(is.material, is.moduli(), &is.relaxation, step)).collect())
}

/// The law of each region and the stress of the past, as they act in one step.
#[derive(Debug, Clone, Default)]
pub(crate) struct ActingStress {
    pub elastic: Vec<Elastic>,
    /// H of every quadrature point, Pa; empty: none.
    pub held: Vec<Symmetric>,
}

impl ActingStress {
    /// `elastic` multiplied by `scale`, and the branches after `history` over the steps `regions`.
    pub fn new(data: &SystemData, elastic: &[Elastic], scale: f64, past: Option<(&[RegionStep], &History)>) -> Self {
        let mut acting: Vec<Elastic> =
            elastic.iter().map(|is| Elastic { moduli: is.moduli.scaled(scale), ..*is }).collect();
        let Some((regions, history)) = past else { return Self { elastic: acting, held: Vec::new() } };
        for ((acting, is), region) in acting.iter_mut().zip(elastic).zip(regions) {
            acting.moduli.mu += is.moduli.mu * region.gain();
        }
        let mut held_stress = vec![[0.0; 6]; data.reference.weights.len()];
        for_each_point(data, regions, |point, region| {
            add_scaled(&mut held_stress[point.number], region.mu, &region.held_stress(history.of_point(point)));
        });
        Self { elastic: acting, held: held_stress }
    }
}
