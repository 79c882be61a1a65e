//! Shapes at rest: found by raising the load, by creeping where that fails, and differentiated.
//!
//! Stands on: `solver`, `descent`. Never knows: time, a measurement.

pub(crate) mod adjoint;
mod climb;
mod creep;
mod descend;
pub(crate) mod equilibrium;
