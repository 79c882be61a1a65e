//! Static equilibria: Newton's method from a nearby shape, homotopies where it fails, and pseudo-transient continuation at last.

mod displaced_clamps;
pub(crate) mod equilibrium;
mod homotopy;
pub(crate) mod load_path;
mod load_stepping;
mod pseudo_transient;
