//! Solvers: energies, forces and the tangent as a linear problem of its own.

use crate::newton::potential::HessianKind;
use crate::solve_error::SolveError;
use crate::solver::Solver;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::Equilibrium;
use si::{Joule, Pascal};
use sparse::LowerTriangle;

/// Energies and forces.
impl Solver {
    /// Elastic energy Ψ(u) of displacement `u` (3 entries per node, m), J; of a half model, of the half. Infinite where
    /// an element is inverted and its law forbids that.
    ///
    /// # Errors
    /// [`SolveError`] when `u` is not of this system.
    pub fn elastic_energy(&self, u: &[f64]) -> Result<Joule, SolveError> {
        self.state.check_field("the displacement", u)?;
        let mut forces = vec![0.0; u.len()];
        Ok(self.state.inputs.body(&self.state.data).energy(u, &mut forces))
    }

    /// Kinetic energy ½ vᵀ M v of velocity `v` (3 entries per node, m/s), J; of a half model, of the half.
    ///
    /// # Errors
    /// [`SolveError`] when `v` is not of this system.
    pub fn kinetic_energy(&self, v: &[f64]) -> Result<Joule, SolveError> {
        self.state.check_field("the velocity", v)?;
        let SolverState { data, inputs, .. } = &self.state;
        let free = data.pattern.gather(v);
        let mut momentum = vec![0.0; free.len()];
        inputs.mass.multiply(&data.pattern, &free, &mut momentum);
        Ok(0.5 * free.iter().zip(&momentum).map(|(v, p)| v * p).sum::<f64>())
    }

    /// Elastic force ∂Ψ/∂u at `u` (3 entries per node, m), 3 entries per node, N.
    ///
    /// # Errors
    /// [`SolveError`] when `u` is not of this system.
    pub fn elastic_force(&self, u: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.state.check_field("the displacement", u)?;
        Ok(self.state.elastic_forces(u))
    }

    /// Unbalanced force ∂Π/∂u at `u` (3 entries per node, m) under `pressures` (one per chamber, Pa) and the dead forces
    /// set before, 3 entries per node, N. Not finite where an element is inverted.
    ///
    /// # Errors
    /// [`SolveError`] when a list is not of this system.
    pub fn residual(&self, u: &[f64], pressures: &[Pascal]) -> Result<Vec<f64>, SolveError> {
        self.state.check_field("the displacement", u)?;
        self.state.check_pressures(pressures)?;
        let mut gradient = vec![0.0; u.len()];
        let energy = self.state.inputs.at_rest(&self.state.data, pressures).energy(u, &mut gradient);
        if !energy.value.is_finite() {
            gradient.fill(f64::NAN);
        }
        Ok(gradient)
    }
}

/// The tangent as a linear problem of its own, for modes, condensation and timings. Newton's method and the adjoint do
/// not need it.
impl Solver {
    /// Assembles the exact tangent ∂²Π/∂u² at `at`, without the rank-one terms of sealed chambers.
    ///
    /// # Errors
    /// [`SolveError`] when `at` is not of this system.
    pub fn assemble(&mut self, at: &Equilibrium) -> Result<LowerTriangle<'_>, SolveError> {
        self.assemble_kind(at, &[], HessianKind::Exact)
    }

    /// As [`Solver::assemble`], with the mixed-integration-point tangent of a step from `previous` (3 entries per node, m).
    ///
    /// # Errors
    /// As [`Solver::assemble`].
    pub fn assemble_mixed(&mut self, at: &Equilibrium, previous: &[f64]) -> Result<LowerTriangle<'_>, SolveError> {
        self.state.check_field("the previous displacement", previous)?;
        self.assemble_kind(at, previous, HessianKind::MixedPoint)
    }

    fn assemble_kind(
        &mut self,
        at: &Equilibrium,
        from: &[f64],
        kind: HessianKind,
    ) -> Result<LowerTriangle<'_>, SolveError> {
        self.state.check_field("the displacement", &at.displacement)?;
        self.state.check_pressures(&at.pressures)?;
        self.state.couple_contact(&at.displacement)?;
        self.state.linearised = None;
        let SolverState { data, inputs, newton, .. } = &mut self.state;
        inputs.at_rest(data, &at.pressures).hessian(&at.displacement, from, kind, &mut newton.tangent);
        Ok(data.pattern.lower_triangle(&newton.tangent))
    }

    /// Factorises the tangent assembled last at `at`, and checks the factor on one solve.
    ///
    /// # Errors
    /// [`SolveError::NotStable`] when it is not positive definite.
    pub fn factorise(&mut self, at: &Equilibrium) -> Result<(), SolveError> {
        let SolverState { data, inputs, newton, .. } = &mut self.state;
        let potential = inputs.at_rest(data, &at.pressures);
        let mut probe = vec![0.0; data.pattern.dofs()];
        data.pattern.multiply(&newton.tangent, &vec![1.0; probe.len()], &mut probe);
        newton.factorise(&potential, &at.displacement, &probe).map_err(|_| SolveError::NotStable)
    }

    /// x with K x = `b` by the last factor, both 3 entries per node; zero at constrained dofs.
    ///
    /// # Errors
    /// [`SolveError`] when `b` has the wrong length, or nothing was factorised yet.
    pub fn solve(&mut self, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.state.check_field("the right-hand side", b)?;
        let SolverState { data, newton, .. } = &mut self.state;
        if !newton.is_ready() {
            return Err(SolveError::NotStable);
        }
        let mut free = data.pattern.gather(b);
        newton.solve(data, &mut free);
        Ok(data.pattern.scattered(&free, 1.0, b.len()))
    }
}
