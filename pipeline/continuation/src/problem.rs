//! Problems whose equilibrium paths are followed.

use si::Metre;

/// A family of equilibria r(u, λ) = 0 with a symmetric tangent K = ∂r/∂u. Vectors hold one entry per dof.
pub trait Problem {
    /// Number of dofs.
    fn dofs(&self) -> usize;

    /// The length that tolerances and steps are relative to.
    fn size(&self) -> Metre;

    /// u at the load factor at which the path begins; it is corrected there.
    fn start(&self) -> Vec<f64>;

    /// r(u, λ) at `u` and `load_factor`; none where it is not defined, as with an inverted element.
    fn residual(&mut self, u: &[f64], load_factor: f64) -> Option<Vec<f64>>;

    /// q = −∂r/∂λ at `u` and `load_factor`.
    fn load(&mut self, u: &[f64], load_factor: f64) -> Vec<f64>;

    /// Factorises K at `u` and `load_factor`, or with `previous`, where the step to `u` began, an approximation of it
    /// that converges faster. Returns the number of its negative eigenvalues; none when it is singular to working
    /// precision.
    fn factorise(&mut self, u: &[f64], load_factor: f64, previous: Option<&[f64]>) -> Option<usize>;

    /// x ← K⁻¹ x by the last factor.
    fn solve(&mut self, x: &mut [f64]);
}
