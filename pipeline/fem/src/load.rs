//! Loads: what pushes on a body, as a potential of its displacement.
//!
//! A load of strength s adds s W(u) to the energy that a body minimises; W comes with its exact first and second
//! derivative, so that the tangent stays symmetric and one Cholesky factor serves Newton and the adjoint.
//!
//! Stands on: `nalgebra`. Never knows: a material, a matrix, the time.
//! A new load: one file in `loads/` and its line in the suite there, which checks both derivatives.

use nalgebra::Matrix3;

/// A potential W of the displacement, per unit of strength.
pub(crate) trait Load: std::fmt::Debug + Send + Sync {
    /// W(u); `u` holds 3 a node, m.
    fn potential(&self, u: &[f64]) -> f64;

    /// Adds `strength` ∂W/∂u to `gradient`, 3 a node.
    fn add_gradient(&self, u: &[f64], strength: f64, gradient: &mut [f64]);

    /// Hands `strength` ∂²W/∂u_a∂u_b to `add` for pairs of nodes a, b, each unordered pair in one order only.
    fn add_hessian(&self, u: &[f64], strength: f64, add: &mut dyn FnMut(u32, u32, &Matrix3<f64>));
}
