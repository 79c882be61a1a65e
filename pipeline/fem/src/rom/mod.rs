//! Reduced-order models: the same nonlinear body in a few dozen generalised coordinates, for many simulations.
//!
//! u = V q with modes V by proper orthogonal decomposition (POD) of displacements that the full model took (`pod`).
//! Hyper-reduction by energy-conserving sampling and weighting (ECSW) [farhat2014], [hernandez2017]: the elastic forces
//! of q are summed over a few hundred quadrature points with weights that reproduce the virtual work of all points
//! (`ecsw`). The mass is projected, and the volumes of chambers are cubic polynomials of q (`chamber_volume`).
//! In statics walls may repel each other (`contact`); in motions they pass through each other.

mod arrays;
mod chamber_volume;
mod compliance;
mod contact;
mod ecsw;
mod elastic_forces;
mod error;
mod integration;
mod model;
mod motion;
mod pod;
mod points;
mod reduction;
mod relaxation;
mod single_step;
mod statics;
mod step;
mod training;

pub use arrays::{ReducedArrays, ReducedRegion};
pub use contact::ReducedContact;
pub use error::ReducedError;
pub use model::{ReducedModel, ReducedModelData};
pub use motion::{Actuation, ReducedMotion};
pub use pod::ReductionSettings;
pub use single_step::{ReducedState, ReducedStep, ReducedStepGradient};
pub use statics::{ReducedEquilibrium, ReducedSolver};
pub use step::{ExternalForce, NoForce, StepState};
pub use training::Snapshot;

#[cfg(test)]
mod tests;
