//! Relaxation in a reduced model: histories at the sampled quadrature points.
//!
//! As `viscoelastic` has it for the full model, with F = I + G q at each sampled point.

use nalgebra::{DMatrix, DVector};
use si::Second;

use super::elastic_forces::{ActingRegion, Points, ReducedTangent};
use super::error::ReducedError;
use super::model::ReducedModel;
use super::motion::ReducedMotion;
use materials::Relaxation;
use materials::step::RegionStep;
use materials::symmetric::{Symmetric, add_scaled};

/// The histories of all regions: those of a region's points one after the other, none where nothing relaxes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReducedHistory {
    regions: Vec<Vec<Symmetric>>,
}

impl ReducedModel {
    /// The law of each group of points in `motion` over a step of `step` seconds.
    ///
    /// # Errors
    /// [`ReducedError::Relaxation`] when there is not one relaxation and stiffening per region, or a law cannot relax.
    ///
    /// # Panics
    /// When there is not one scale per region.
    pub(super) fn region_steps(&self, motion: &ReducedMotion, step: Second) -> Result<Vec<RegionStep>, ReducedError> {
        let ReducedMotion { modulus_scale, relaxation, stiffening, .. } = *motion;
        let regions = self.regions;
        assert_eq!(modulus_scale.len(), regions, "one scale per region");
        for (what, given) in [("relaxations", relaxation.len()), ("stiffenings", stiffening.len())] {
            if given != 0 && given != regions {
                return Err(ReducedError::Relaxation { what: format!("{given} {what} for {regions} regions") });
            }
        }
        let none = Relaxation::default();
        let step_of = |points: &Points| {
            let region = points.region;
            let (elastic, relaxation) = (points.elastic(), relaxation.get(region).unwrap_or(&none));
            if !relaxation.is_none() && !elastic.material.is_objective() {
                let what = format!("region {region} has the law `{}`", elastic.material.name());
                return Err(ReducedError::Relaxation { what });
            }
            let moduli = elastic.moduli.scaled(modulus_scale[region]);
            let moduli = stiffening.get(region).map_or(moduli, |ratios| moduli.with_stiffening(*ratios));
            Ok(RegionStep::new(elastic.material, moduli, relaxation, step))
        };
        self.points.iter().map(step_of).collect()
    }

    /// What acts in a step in which the law's own stress is multiplied by `damping`.
    pub(super) fn acting(&self, regions: &[RegionStep], damping: f64, history: &ReducedHistory) -> Vec<ActingRegion> {
        let acting_region = |(region, tensors): (&RegionStep, &Vec<Symmetric>)| {
            let mut moduli = region.moduli.scaled(damping);
            // Not damped: the branches dissipate by themselves, and stiffness damping belongs to the law's own stress.
            moduli.mu += region.mu * region.gain();
            let held_stress = |tensors: &[Symmetric]| {
                let mut held_stress = [0.0; 6];
                add_scaled(&mut held_stress, region.mu, &region.held_stress(tensors));
                held_stress
            };
            ActingRegion { moduli, held: tensors.chunks_exact(1 + region.branches.len()).map(held_stress).collect() }
        };
        regions.iter().zip(&history.regions).map(acting_region).collect()
    }

    /// Of a body that has been held at `q` for ever.
    pub(super) fn relaxed(&self, regions: &[RegionStep], q: &DVector<f64>) -> ReducedHistory {
        let region_history = |(points, region): (&Points, &RegionStep)| {
            if region.branches.is_empty() {
                return Vec::new();
            }
            let mut tensors = Vec::new();
            points.for_each_deformation(q, |gradient| {
                tensors.push(region.stress(gradient));
                tensors.extend(region.branches.iter().map(|_| [0.0; 6]));
            });
            tensors
        };
        ReducedHistory { regions: self.points.iter().zip(regions).map(region_history).collect() }
    }

    /// Advances `history` by a step that ends at `q`.
    pub(super) fn advance(&self, regions: &[RegionStep], q: &DVector<f64>, history: &mut ReducedHistory) {
        for ((points, region), tensors) in self.points.iter().zip(regions).zip(&mut history.regions) {
            let mut each = tensors.chunks_exact_mut(1 + region.branches.len());
            if !region.branches.is_empty() {
                points.for_each_deformation(q, |gradient| {
                    each.next().into_iter().for_each(|own| region.advance_history(own, region.stress(gradient)));
                });
            }
        }
    }

    /// Forces (J) at q of what acts in each region.
    pub(super) fn acting_forces(&self, q: &DVector<f64>, acting: &[ActingRegion]) -> DVector<f64> {
        let mut forces = DVector::zeros(self.coordinates());
        self.points.iter().zip(acting).for_each(|(points, acting)| points.add_forces(q, acting, &mut forces));
        forces
    }

    /// Their derivative by q (J).
    pub(super) fn acting_stiffness(
        &self,
        q: &DVector<f64>,
        kind: ReducedTangent,
        acting: &[ActingRegion],
    ) -> DMatrix<f64> {
        let r = self.coordinates();
        let mut stiffness = DMatrix::zeros(r, r);
        self.points
            .iter()
            .zip(acting)
            .for_each(|(points, acting)| points.add_stiffness(q, kind, acting, &mut stiffness));
        stiffness
    }

    /// The law alone, its moduli multiplied by `scale`.
    ///
    /// # Panics
    /// When there is not one scale per region.
    pub(super) fn elastic(&self, scale: &[f64]) -> Vec<ActingRegion> {
        assert_eq!(scale.len(), self.regions, "one scale per region");
        let law = |points: &Points| ActingRegion {
            moduli: points.elastic().moduli.scaled(scale[points.region]),
            held: Vec::new(),
        };
        self.points.iter().map(law).collect()
    }
}
