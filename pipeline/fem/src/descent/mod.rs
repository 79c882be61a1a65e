//! Descent: the potential that a body minimises, and the ways to its minimum.
//!
//! Stands on: `body`, `algebra`, `loads`. Never knows: a load step, a time step.

pub(crate) mod glide;
pub(crate) mod newton;
pub(crate) mod potential;
pub(crate) mod search;
pub(crate) mod tangent;
