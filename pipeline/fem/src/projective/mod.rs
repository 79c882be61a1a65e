//! Projective dynamics, the solver of the paper, for 4-node tetrahedra of the corotated law: a reference for
//! comparison.
//!
//! A step of implicit Euler is the minimum of Π(u) = Σ V ψ(F) − Σ p V_c(u) − f · u + ½ c (u − û)ᵀ M (u − û), c = 1/h².
//! The local step projects the F of each element onto the nearest rotation R, with weight 2μ, and onto the nearest F'
//! with R : F' = 3, with weight 3λ, because λ/2 (R : F − 3)² is 3λ/2 times that squared distance. The global step
//! minimises Π with fixed projections, which needs one constant matrix A = c M + Σ V (2μ + 3λ) GᵀG, the same along each axis and
//! factorised once. Together they are u ← u − A⁻¹ ∇Π exactly; L-BFGS with A⁻¹ as the initial inverse accelerates them,
//! and the adjoint K z = b with the exact tangent is solved in the same way.        [bouaziz2014], [liu2017], [du2021]
//!
//! A does not depend on the rotation of the elements: a sheet that is far stiffer than its surroundings is restrained
//! by its own modulus, although it could rotate freely. The number of iterations therefore grows with the ratio of the
//! moduli; that of Newton's method does not.

mod by_newton;
mod error;
mod global_step;
mod quasi_newton;

pub use error::ProjectiveError;

use crate::dynamics::settings::State;
use crate::inputs::Inputs;
use crate::mesh::Elements;
use crate::newton::potential::{HessianKind, Inertia, Potential};
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::system::System;
use crate::system_data::SystemData;
use global_step::GlobalStep;
use quasi_newton::{QuasiNewton, adjoint_solve};
use si::{Pascal, Second};
use std::sync::Arc;

/// How a step or its adjoint is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectiveSettings {
    /// ‖∇Π‖ over the size of the forces at the start of the step; for the adjoint ‖Kz − b‖ / ‖b‖.
    pub tolerance: f64,
    /// Iterations at most, of a local and a global step each.
    pub max_iterations: usize,
}

impl Default for ProjectiveSettings {
    /// A millionth of the forces, in as many iterations as the ratio of acetal to silicone takes.
    fn default() -> Self {
        Self { tolerance: 1e-6, max_iterations: 20_000 }
    }
}

/// A system and the constant matrix of one time step.
#[derive(Debug)]
pub struct Projective {
    state: SolverState,
    global: GlobalStep,
    step: Second,
}

impl Projective {
    /// Prepares time steps of length `step` (s); an infinite step solves for the equilibrium.
    ///
    /// # Errors
    /// [`ProjectiveError`] when the mesh is not of 4-node tetrahedra, a region has another law than `corotated`, the
    /// step is not above zero, or the constant matrix has no factor.
    pub fn new(system: &System, step: Second) -> Result<Self, ProjectiveError> {
        let data = &system.data;
        if !matches!(data.mesh.elements, Elements::Linear(_)) {
            return Err(ProjectiveError::Order { nodes: data.mesh.elements.nodes_each() });
        }
        if let Some(region) = data.regions.iter().position(|is| is.material.name() != "corotated") {
            return Err(ProjectiveError::Law { region, law: data.regions[region].material.name() });
        }
        if step.is_nan() || step <= 0.0 {
            let (what, range) = ("the time step of projective dynamics", "above 0 s");
            return Err(SolveError::Setting { what, value: step, range }.into());
        }
        let state = SolverState::new(Arc::clone(data));
        let global = GlobalStep::new(data, &state.inputs.elastic, inertia_rate(step))?;
        Ok(Self { state, global, step })
    }

    /// One step from `state` under `pressures` (one per chamber, Pa) and dead `forces` (3 entries per node, N, or
    /// none), and the number of iterations.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length or the iterations do not suffice.
    pub fn step(
        &mut self,
        state: &State,
        pressures: &[Pascal],
        forces: &[f64],
        settings: &ProjectiveSettings,
    ) -> Result<(State, usize), ProjectiveError> {
        let (inertia, mut u) = self.start_step(state, pressures, forces)?;
        let potential = potential(&self.state.inputs, &self.state.data, pressures, inertia.as_ref());
        let start = self.state.with_constraints(&state.displacement);
        let iterations = QuasiNewton::new(&potential, &mut self.global).minimise(&mut u, &start, settings)?;
        Ok((self.end_state(state, u), iterations))
    }

    /// z with K z = `b` (3 entries per node) for the exact tangent K = ∂²Π/∂u² of a step that ends in `displacement` (3
    /// entries per node, m), and the number of iterations: the gradient of a scalar by all forces, when `b` is its
    /// derivative by u.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length, K is not positive definite, or the iterations do not
    /// suffice.
    pub fn adjoint(
        &mut self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
        settings: &ProjectiveSettings,
    ) -> Result<(Vec<f64>, usize), ProjectiveError> {
        let (inertia, b) = self.start_adjoint(displacement, pressures, b)?;
        let potential = potential(&self.state.inputs, &self.state.data, pressures, inertia.as_ref());
        let data = potential.data;
        let mut tangent = vec![0.0; data.pattern.entries()];
        potential.hessian(displacement, &[], HessianKind::Exact, &mut tangent);
        let multiply = |x: &[f64], y: &mut [f64]| data.pattern.multiply(&tangent, x, y);
        let (z, iterations) = adjoint_solve(multiply, &mut self.global, &b, settings)?;
        Ok((data.pattern.scattered(&z, 1.0, displacement.len()), iterations))
    }

    /// Checks the inputs of a step and sets its forces; its inertia and its initial guess.
    fn start_step(
        &mut self,
        state: &State,
        pressures: &[Pascal],
        forces: &[f64],
    ) -> Result<(Option<Inertia>, Vec<f64>), SolveError> {
        self.state.check_field("the displacement", &state.displacement)?;
        self.state.check_field("the velocity", &state.velocity)?;
        self.state.check_pressures(pressures)?;
        self.set_forces(forces)?;
        if self.step.is_infinite() {
            return Ok((None, self.state.with_constraints(&state.displacement)));
        }
        let extrapolated: Vec<f64> =
            state.displacement.iter().zip(&state.velocity).map(|(u, v)| u + self.step * v).collect();
        let centre = self.state.data.pattern.gather(&extrapolated);
        let inertia = Inertia { rate: inertia_rate(self.step), centre, history: Vec::new() };
        Ok((Some(inertia), self.state.with_constraints(&extrapolated)))
    }

    /// Checks the inputs of an adjoint; the inertia of its tangent, and b at free dofs.
    fn start_adjoint(
        &self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
    ) -> Result<(Option<Inertia>, Vec<f64>), SolveError> {
        self.state.check_field("the displacement", displacement)?;
        self.state.check_pressures(pressures)?;
        self.state.check_field("the right-hand side", b)?;
        let free = self.state.data.pattern.gather(b);
        let inertia = Inertia { rate: inertia_rate(self.step), centre: vec![0.0; free.len()], history: Vec::new() };
        Ok((self.step.is_finite().then_some(inertia), free))
    }

    fn set_forces(&mut self, forces: &[f64]) -> Result<(), SolveError> {
        if !forces.is_empty() {
            self.state.check_field("a list of forces", forces)?;
        }
        self.state.inputs.forces = forces.to_vec();
        self.state.inputs.update_dead_forces();
        Ok(())
    }

    fn end_state(&self, from: &State, u: Vec<f64>) -> State {
        let velocity = u.iter().zip(&from.displacement).map(|(now, then)| (now - then) / self.step).collect();
        State { displacement: u, velocity }
    }
}

/// c = 1/h², 1/s².
fn inertia_rate(step: Second) -> f64 {
    1.0 / (step * step)
}

fn potential<'a>(
    inputs: &'a Inputs,
    data: &'a SystemData,
    pressures: &'a [Pascal],
    inertia: Option<&'a Inertia>,
) -> Potential<'a> {
    match inertia {
        Some(inertia) => inputs.at_rest(data, pressures).in_motion(inertia),
        None => inputs.at_rest(data, pressures),
    }
}
