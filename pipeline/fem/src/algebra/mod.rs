//! Linear algebra of one body: its graph, the order of elimination, the factor, and what betters an old factor.
//!
//! Stands on: `faer`. Never knows: what is solved for.

pub(crate) mod bordered;
pub(crate) mod factor;
pub(crate) mod graph;
pub(crate) mod krylov;
pub(crate) mod memory;
pub(crate) mod order;
pub(crate) mod sparse;
pub(crate) mod vectors;
