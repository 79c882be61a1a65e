//! Static equilibria: incremental loading with Newton's method, and pseudo-transient continuation where it fails.

pub(crate) mod equilibrium;
mod load_stepping;
mod pseudo_transient;
