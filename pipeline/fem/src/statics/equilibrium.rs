//! Static equilibria and the settings of their solution.

use si::Pascal;

/// How an equilibrium is solved for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticSettings {
    /// The last Newton step moves no node further than this fraction of the body's size.
    pub tolerance: f64,
    /// Load steps from rest, when none fails.
    pub load_steps: usize,
    /// Newton iterations at most, in each load step.
    pub max_iterations: usize,
    /// Halvings of a load step at most.
    pub max_halvings: usize,
    /// Warm start: try PCG preconditioned by the factor of the previous solve first. Pays after changes of a few per
    /// cent.
    pub reuse_factor: bool,
}

impl Default for StaticSettings {
    fn default() -> Self {
        Self { tolerance: 1e-8, load_steps: 3, max_iterations: 40, max_halvings: 40, reuse_factor: false }
    }
}

/// A static equilibrium.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Equilibrium {
    /// 3 entries per node, m.
    pub displacement: Vec<f64>,
    /// One per chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Newton iterations, over all load steps.
    pub iterations: usize,
    /// Factorisations, over all load steps.
    pub factorisations: usize,
    /// Norm of the unbalanced force over that of the elastic force; no unit.
    pub residual: f64,
    /// Whether the load was applied in steps from rest.
    pub load_stepped: bool,
    /// Snap-through: load factors (0 to 1) at which tangents on the way were not positive definite; none where
    /// the search was only slow.
    pub snap_through: Vec<f64>,
}
