//! Loads: potentials of the displacement, and the family of them.
//!
//! A load of strength s adds s W(u) to the energy that a body minimises. W comes with its exact first and second
//! derivative, so that the tangent stays symmetric and one Cholesky factor serves Newton and the adjoint.
//!
//! To add a load: one file here and its line in the conformance tests, which check both derivatives.

mod chamber;
mod dead;
pub(crate) mod gas;

#[cfg(test)]
mod conformance;

pub(crate) use chamber::ChamberPressure;
pub use dead::Forces;
pub(crate) use dead::{DeadForces, add_gravity};

use nalgebra::Matrix3;

/// A potential W of the displacement, per unit of strength.
pub(crate) trait Load: std::fmt::Debug + Send + Sync {
    /// W(u); `u` holds 3 entries per node, m.
    fn potential(&self, u: &[f64]) -> f64;

    /// Adds `strength` ∂W/∂u to `gradient`, 3 entries per node.
    fn add_gradient(&self, u: &[f64], strength: f64, gradient: &mut [f64]);

    /// Calls `add` with `strength` ∂²W/∂u_a∂u_b for pairs of nodes a, b, each unordered pair in one order only.
    fn add_hessian(&self, u: &[f64], strength: f64, add: &mut dyn FnMut(u32, u32, &Matrix3<f64>));
}
