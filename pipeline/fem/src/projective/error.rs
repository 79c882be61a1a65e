//! Errors of projective dynamics.

use crate::newton::options::NonConvergence;
use crate::solve_error::SolveError;
use sparse::FactorError;

/// Why projective dynamics cannot treat a system, or finds no step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProjectiveError {
    /// Elements of another order.
    #[error(
        "the mesh has tetrahedra of {nodes} nodes\n  why: projective dynamics projects one deformation gradient per element, as of 4-node tetrahedra\n  do:  give a mesh without mid-edge nodes, or use `Solver`"
    )]
    Order {
        /// Nodes of an element.
        nodes: usize,
    },
    /// Another law.
    #[error(
        "the law of region {region} is {law}\n  why: projective dynamics has projections for the corotated law alone\n  do:  set the law of the region to corotated, or use `Solver`"
    )]
    Law {
        /// Which region.
        region: usize,
        /// Its law.
        law: &'static str,
    },
    /// The constant matrix has no factor.
    #[error(
        "the matrix of the global step has no factor along axis {axis}\n  why: {cause}\n  do:  at rest, constrain at least one node along each axis; else take a coarser mesh"
    )]
    Factor {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Why the factorisation failed.
        #[source]
        cause: FactorError,
    },
    /// An input of the wrong length, not finite, or out of range.
    #[error(transparent)]
    Input(#[from] SolveError),
    /// An element is inverted at the start of the step.
    #[error(
        "an element is inverted at the start of the step\n  why: its energy is infinite there\n  do:  start from a converged shape, at a smaller velocity"
    )]
    InvertedElement,
    /// The iterations did not suffice.
    #[error(
        "the residual is still {residual:.2e} after {iterations} iterations\n  why: the limit is {tolerance:.2e}\n  do:  allow more iterations; beyond a ratio of moduli of some hundreds, use `Solver`"
    )]
    IterationLimit {
        /// Unbalanced force over the size of the forces; for the adjoint ‖Kz − b‖ / ‖b‖.
        residual: f64,
        /// Iterations made.
        iterations: usize,
        /// The residual to reach.
        tolerance: f64,
    },
    /// The line search found no step that lowers the energy.
    #[error(
        "no step lowers the energy after {iterations} iterations, at a residual of {residual:.2e}\n  why: the remaining residual is rounding\n  do:  allow a larger tolerance"
    )]
    LineSearchFailed {
        /// Iterations made.
        iterations: usize,
        /// Unbalanced force over the size of the forces.
        residual: f64,
    },
    /// A tangent that is not positive definite.
    #[error(
        "the tangent is not positive definite, found in iteration {iterations}\n  why: the shape is not a stable result of a step\n  do:  pass the displacement and the pressures of a converged step"
    )]
    NotStable {
        /// Iterations made.
        iterations: usize,
    },
    /// Newton's method, as the reference, found no step.
    #[error("Newton's method finds no step\n  why: {0}\n  do:  take a smaller time step or a smaller load")]
    Newton(#[from] NonConvergence),
}
