//! Errors of reducing a model, and of its integration.

use crate::solve_error::SolveError;
use si::Second;

/// Why a body cannot be reduced, or a step of its reduced model fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReducedError {
    /// Snapshots of another system, or none.
    #[error(
        "{count} snapshots cannot span this body\n  why: each needs {required} numbers, 3 per node\n  do:  give displacements of this system"
    )]
    Snapshots {
        /// Number of snapshots.
        count: usize,
        /// Numbers required in each.
        required: usize,
    },
    /// Snapshots that span nothing.
    #[error(
        "the {count} snapshots have no mode\n  why: none of them moves a node that is free, or their numbers are out of range\n  do:  give displacements that the body took under loads"
    )]
    NoMode {
        /// Number of snapshots.
        count: usize,
    },
    /// A region with mean dilatation.
    #[error(
        "a region uses mean dilatation\n  why: hyper-reduction samples single quadrature points, and the mean couples those of an element\n  do:  reduce a mesh of hexahedra of second order, or of 10-node tetrahedra without mean_dilatation"
    )]
    MeanDilatation,
    /// Data of another system, or damaged data.
    #[error("the reduced model does not belong to this system\n  why: {what}\n  do:  reduce this system again")]
    Foreign {
        /// What does not match.
        what: String,
    },
    /// A setting out of range.
    #[error(transparent)]
    Settings(#[from] SolveError),
    /// A step without a solution.
    #[error(
        "no step of the reduced model is found after {time:.4} s\n  why: {max_iterations} iterations leave a change of {change:.1e} of the largest snapshot; the limit is {tolerance:.0e}\n  do:  take shorter steps, or reduce from snapshots nearer to this motion"
    )]
    NoConvergence {
        /// Time of the last step that converged, s.
        time: Second,
        /// Iterations made.
        max_iterations: usize,
        /// Size of the last one, no unit.
        change: f64,
        /// Size to reach, no unit.
        tolerance: f64,
    },
    /// Relaxation that the model cannot have.
    #[error(
        "the reduced model cannot relax like this: {what}\n  why: it needs one relaxation per region, and an objective law where something relaxes\n  do:  give one relaxation per region, empty for elastic ones"
    )]
    Relaxation {
        /// What is wrong.
        what: String,
    },
}
