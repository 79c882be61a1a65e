//! The physics of the bench: a specimen as finite elements, at rest under pressure and in motion in air and water.
//!
//! Quadratic neo-Hookean elements on the bench's own swept mesh of the half z ≥ 0, which no pipeline ever sees. What is held rests on
//! a ladder of equilibria of the whole body; what moves does so in coordinates that it was reduced to, which tests hold
//! against the whole body's march.
//!
//! Stands on: `fem`, `shape`. Never knows: a camera, a log, a file.

mod body;
mod dynamics;
mod flap;
mod line;
mod motion;
mod stairs;
mod statics;
pub mod training;
mod water;

pub use body::Body;
pub use dynamics::march;
pub use flap::{Conditions, Flap, Swimmer};
pub use line::{CentreLine, Station};
pub use motion::{Motion, Quasistatic, Recorded};
pub use stairs::Stairs;
pub use statics::Ladder;
pub use water::{Fluid, Push, Water};
