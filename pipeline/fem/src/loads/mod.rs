//! The family of loads.
//!
//! Stands on: the contract in `load.rs` and its members. Never knows: which of them a system carries.

mod chamber;
mod dead;

#[cfg(test)]
mod conformance;

pub(crate) use chamber::ChamberPressure;
pub(crate) use dead::DeadForces;
