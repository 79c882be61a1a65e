//! The physics of the bench: a specimen as finite elements, in equilibrium under pressure and in motion in air and water.
//!
//! Quadratic elements on the bench's own swept mesh of the half z ≥ 0, which the pipeline never reads. Quasi-static shapes are equilibria of
//! the whole body. Motions are computed in a reduced model, because a recording has about a hundred trials; tests compare it with the whole
//! body in air and in water.

mod body;
mod centre_line;
mod dynamics;
mod flapping;
mod motion;
mod pressure_sweep;
pub(crate) mod snapshots;
mod staircase;
mod water;

pub use body::{Body, BodySettings};
pub use centre_line::{CentreLine, Station};
pub use dynamics::{Sampling, integrate};
pub use flapping::{Conditions, FlappingModel, FlappingMotion, SoftenedModel, TimeSpan};
pub use motion::{Motion, QuasistaticMotion, SampledMotion};
pub use pressure_sweep::{PressureSweep, even_pressures};
pub use staircase::{Staircase, StaircaseMotion};
pub use water::{Fluid, Water, WaterForce};
