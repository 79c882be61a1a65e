//! The body: shape functions, rest shapes, and the energy, forces, stiffness, mass and turn of all its elements.
//!
//! Stands on: `material`, `algebra` (places of blocks). Never knows: a pressure, a time step, a factor.

pub(crate) mod assembly;
pub(crate) mod bend;
pub(crate) mod elements;
pub(crate) mod kernels;
pub(crate) mod mass;
pub(crate) mod quadrature;
pub(crate) mod rest;
pub(crate) mod turn;
