//! A shape at rest, and how it is sought.
//!
//! Stands on: `si`. Never knows: a solver.

use si::Pascal;

/// How an equilibrium is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticSettings {
    /// The last step moves no node further than this part of the body's size.
    pub tolerance: f64,
    /// Steps in which the load is raised from rest, when all goes well.
    pub load_steps: usize,
    /// Newton directions at most, in each load step.
    pub iterations: usize,
    /// How often a load step may be halved before the equilibrium is given up.
    pub halvings: usize,
    /// Begin with the factor of the last solve: pays after changes of a few percent.
    pub reuse_factor: bool,
}

impl Default for StaticSettings {
    fn default() -> Self {
        Self { tolerance: 1e-8, load_steps: 3, iterations: 40, halvings: 40, reuse_factor: false }
    }
}

/// A shape at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// 3 a node, m.
    pub displacement: Vec<f64>,
    /// One a chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Newton directions, over all load steps.
    pub iterations: usize,
    /// Factors made, over all load steps.
    pub factorisations: usize,
    /// Unbalanced force over the load's own force, both as root of the sum of squares; no unit.
    pub residual: f64,
    /// Whether the load was raised in steps from rest.
    pub stepped: bool,
    /// Where the body snapped: parts of the load (0 to 1) at which tangents on the way were not positive definite, and
    /// the shape beyond was found downhill.
    pub snaps: Vec<f64>,
}
