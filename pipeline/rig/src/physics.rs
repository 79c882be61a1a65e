//! The physics of the bench: a specimen as finite elements, at rest under pressure and in motion.
//!
//! Quadratic neo-Hookean elements on the bench's own swept mesh of the half z ≥ 0, which no pipeline ever sees.
//!
//! Stands on: `fem`, `shape`. Never knows: a camera, a log, a file.

mod body;
mod dynamics;
mod motion;
mod reaction;
mod statics;

pub use body::Body;
pub use dynamics::march;
pub use motion::{Motion, Quasistatic, Recorded};
pub use reaction::Reaction;
pub use statics::{ladder, rungs};
