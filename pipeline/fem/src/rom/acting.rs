//! What acts at the sampled points of a region in one step: the law with damping and relaxation.

use materials::Moduli;
use materials::symmetric::Symmetric;

/// What acts at the points of one region in one step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ActingRegion {
    /// Those of the law, with damping and relaxation.
    pub moduli: Moduli,
    /// H of each point, Pa; empty: none.
    pub held: Vec<Symmetric>,
}
