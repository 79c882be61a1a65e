//! Static equilibria: Newton's method from a nearby shape, homotopies where it fails, and pseudo-transient continuation at last.

pub(crate) mod equilibrium;
mod homotopy;
mod load_stepping;
pub(crate) mod pressure_path;
mod pseudo_transient;
