//! Thrust: models that tell it from motion and pressure, from the mean to a network, fitted and judged alike.
//!
//! [`outline`] is the tail as water sees it; [`run`] is one beating trial as evenly spaced samples; `rungs/` holds one file a kind of model and the list `LADDER`;
//! [`score`] judges what a rung says of runs it never saw; [`splits`] chooses which those are; [`simulated`] evaluates a
//! trained model on the whole body's motion, with gradients through the finite elements; [`swim`] on the reduced body's in
//! [`water`]; [`climb`] goes uphill by either.
//!
//! Stands on: hydro, fit, signal, the reduced model. Never knows: a file, a record, a stage. Paper: section V.

pub mod climb;
pub mod outline;
pub mod run;
pub mod rungs;
pub mod score;
pub mod simulated;
pub mod splits;
pub mod swim;
pub mod water;

pub use run::Run;
pub use rungs::{Fitted, LADDER, Lesson, Rung};
