//! Why projective dynamics refuses a system, or finds no step.
//!
//! Stands on: `solver` (its errors), `search` (Newton's). Never knows: how it was found.

use crate::descent::search::Stall;
use crate::stall::SolveError;

/// What projective dynamics cannot do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProjectiveError {
    /// Elements of another order.
    #[error(
        "the mesh has tetrahedra of {nodes} nodes\n  why: projective dynamics projects one deformation an element, which 4-node tetrahedra have\n  do:  give a mesh without middle nodes, or use `Solver`"
    )]
    Order {
        /// Nodes of an element.
        nodes: usize,
    },
    /// Another law.
    #[error(
        "region {region} is made of {law}\n  why: projective dynamics knows the projections of corotated alone\n  do:  make the region of corotated, or use `Solver`"
    )]
    Law {
        /// Which region.
        region: usize,
        /// Its law.
        law: &'static str,
    },
    /// The constant matrix cannot be used.
    #[error(
        "the matrix of the global step has no factor along axis {axis}\n  why: {why}\n  do:  at rest, hold at least one node along each axis; else take a coarser mesh"
    )]
    NoFactor {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// What went wrong.
        why: String,
    },
    /// An input of the wrong length, or that is no number.
    #[error(transparent)]
    Asked(#[from] SolveError),
    /// The step began where an element is inverted.
    #[error(
        "an element is turned inside out where the step begins\n  why: its energy is infinite there\n  do:  begin from a shape that a solve left, at a smaller speed"
    )]
    InsideOut,
    /// The iterations did not suffice.
    #[error(
        "the residual is still {residual:.2e} after {iterations} iterations\n  why: the limit is {tolerance:.2e}\n  do:  allow more iterations; beyond a ratio of moduli of some hundreds, use `Solver`"
    )]
    TooSlow {
        /// Unbalanced force over the forces' own size; backwards ‖Kz − b‖ / ‖b‖.
        residual: f64,
        /// Iterations made.
        iterations: usize,
        /// The residual to reach.
        tolerance: f64,
    },
    /// No step along a direction lowers the energy.
    #[error(
        "no step lowers the energy after {iterations} iterations, at a residual of {residual:.2e}\n  why: rounding hides what is left\n  do:  allow a larger tolerance"
    )]
    NoDescent {
        /// Iterations made.
        iterations: usize,
        /// Unbalanced force over the forces' own size.
        residual: f64,
    },
    /// A tangent that is not positive definite.
    #[error(
        "the tangent is not positive definite, found in iteration {iterations}\n  why: the shape is not a stable end of a step\n  do:  pass the displacement that a step left, with its pressures"
    )]
    NotStable {
        /// Iterations made.
        iterations: usize,
    },
    /// Newton's method, asked for comparison, found no step.
    #[error("Newton's method finds no step\n  why: {0}\n  do:  take a smaller time step or a smaller load")]
    Newton(#[from] Stall),
}
