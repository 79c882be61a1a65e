//! Projective dynamics: the solver that the paper used, for 4-node tetrahedra of the corotated law.
//!
//! A step of implicit Euler is the minimum of Π(u) = Σ V ψ(F) − Σ p V_c(u) − f · u + ½ c (u − û)ᵀ M (u − û), c = 1/h².
//! The local step projects each element: its F onto the nearest turn R, at the weight 2μ, and onto the nearest F' with
//! R : F' = 3, at the weight 3λ, for λ/2 (R : F − 3)² is 3λ/2 times that distance squared. The global step minimises
//! Π with all projections held, which is one constant matrix A = c M + Σ V (2μ + 3λ) GᵀG, the same along each axis and
//! factorised once. Together they are u ← u − A⁻¹ ∇Π exactly, and L-BFGS with A⁻¹ as its first guess speeds them up;
//! backwards, the exact tangent K z = b is solved in the same way.        [bouaziz2014], [liu2017], [du2021]
//!
//! A knows no direction: a sheet that is far stiffer than what surrounds it holds each element back by its own modulus,
//! though it could turn freely. The iterations therefore grow with the ratio of the moduli, and Newton's do not.
//!
//! Stands on: `solver`, `potential`, `memory`. Never knows: more than one step.

mod compare;
mod descent;
mod global;
mod refusal;

pub use refusal::ProjectiveError;

use crate::descent::potential::{Curvature, Inertia, Potential};
use crate::given::Given;
use crate::mesh::Elements;
use crate::motion::march::State;
use crate::parts::Parts;
use crate::solver::Solver;
use crate::stall::SolveError;
use crate::system::System;
use global::Global;
use si::{Pascal, Second};

/// How a step or its gradient is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProjectiveSettings {
    /// ‖∇Π‖ over the size of the forces that the step began with; backwards ‖Kz − b‖ / ‖b‖.
    pub tolerance: f64,
    /// Iterations at most: a local and a global step each.
    pub iterations: usize,
}

impl Default for ProjectiveSettings {
    /// A millionth of the forces, in as many iterations as the ratio of acetal to silicone asks for.
    fn default() -> Self {
        Self { tolerance: 1e-6, iterations: 20_000 }
    }
}

/// A system and the constant matrix of one time step.
#[derive(Debug)]
pub struct Projective {
    solver: Solver,
    global: Global,
    step: Second,
}

impl Projective {
    /// Prepares time steps of length `step` (s); an infinite one leads to rest at once.
    ///
    /// # Errors
    /// [`ProjectiveError`] when the mesh is not of 4-node tetrahedra, a region has another law than `corotated`, the
    /// step is not above zero, or the constant matrix has no factor.
    pub fn new(system: &System, step: Second) -> Result<Self, ProjectiveError> {
        let parts = &system.parts;
        if let Elements::Quadratic(_) = parts.mesh.elements {
            return Err(ProjectiveError::Order { nodes: parts.mesh.elements.nodes_each() });
        }
        if let Some(region) = parts.regions.iter().position(|is| is.material.name() != "corotated") {
            return Err(ProjectiveError::Law { region, law: parts.regions[region].material.name() });
        }
        if step.is_nan() || step <= 0.0 {
            let (what, range) = ("the time step of projective dynamics", "above 0 s");
            return Err(SolveError::Setting { what, value: step, range }.into());
        }
        let solver = system.solver();
        let global = Global::new(parts, &solver.given.elastic, rate(step))?;
        Ok(Self { solver, global, step })
    }

    /// One step from `state` under `pressures` (one a chamber, Pa) and dead `forces` (3 a node, N, or none), and the
    /// iterations that it took.
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
        let (inertia, mut u) = self.set_out(state, pressures, forces)?;
        let potential = potential(&self.solver.given, &self.solver.parts, pressures, inertia.as_ref());
        let global = &mut self.global;
        let from = self.solver.with_held_at_rest(&state.displacement);
        let iterations = descent::minimise(&potential, global, &mut u, &from, settings)?;
        Ok((self.arrived(state, u), iterations))
    }

    /// z with K z = `b` (3 a node) for the exact tangent K = ∂²Π/∂u² of a step that ends in `displacement` (3 a node, m),
    /// and the iterations that it took: the gradient of a scalar by all forces, when `b` is its slope by u.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length, K is not positive definite, or the iterations do not suffice.
    pub fn backward(
        &mut self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
        settings: &ProjectiveSettings,
    ) -> Result<(Vec<f64>, usize), ProjectiveError> {
        let (inertia, b) = self.set_back(displacement, pressures, b)?;
        let potential = potential(&self.solver.given, &self.solver.parts, pressures, inertia.as_ref());
        let global = &mut self.global;
        let parts = potential.parts;
        let mut tangent = vec![0.0; parts.pattern.entries()];
        potential.curvature(displacement, &[], Curvature::Exact, &mut tangent);
        let image = |x: &[f64], y: &mut [f64]| parts.pattern.multiply(&tangent, x, y);
        let (z, iterations) = descent::solve(image, global, &b, settings)?;
        let mut full = vec![0.0; displacement.len()];
        parts.pattern.spread(&z, 1.0, &mut full);
        Ok((full, iterations))
    }

    /// Checks what a step is given, sets its forces, and says where inertia draws it and where it begins.
    fn set_out(
        &mut self,
        state: &State,
        pressures: &[Pascal],
        forces: &[f64],
    ) -> Result<(Option<Inertia>, Vec<f64>), SolveError> {
        self.solver.check_field("the displacement", &state.displacement)?;
        self.solver.check_field("the velocity", &state.velocity)?;
        self.solver.check_pressures(pressures)?;
        self.solver.set_forces(forces)?;
        if self.step.is_infinite() {
            return Ok((None, self.solver.with_held_at_rest(&state.displacement)));
        }
        let ahead: Vec<f64> = state.displacement.iter().zip(&state.velocity).map(|(u, v)| u + self.step * v).collect();
        let mut centre = Vec::new();
        self.solver.parts.pattern.gather(&ahead, &mut centre);
        let inertia = Inertia { rate: rate(self.step), centre, history: Vec::new() };
        Ok((Some(inertia), self.solver.with_held_at_rest(&ahead)))
    }

    /// Checks what a gradient is given; the inertia of its tangent, and b at free nodes.
    fn set_back(
        &self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
    ) -> Result<(Option<Inertia>, Vec<f64>), SolveError> {
        self.solver.check_field("the displacement", displacement)?;
        self.solver.check_pressures(pressures)?;
        self.solver.check_field("the right-hand side", b)?;
        let mut free = Vec::new();
        self.solver.parts.pattern.gather(b, &mut free);
        let inertia = Inertia { rate: rate(self.step), centre: vec![0.0; free.len()], history: Vec::new() };
        Ok((self.step.is_finite().then_some(inertia), free))
    }

    fn arrived(&self, from: &State, u: Vec<f64>) -> State {
        let velocity = u.iter().zip(&from.displacement).map(|(now, then)| (now - then) / self.step).collect();
        State { displacement: u, velocity }
    }
}

/// c = 1/h², 1/s².
fn rate(step: Second) -> f64 {
    1.0 / (step * step)
}

fn potential<'a>(
    given: &'a Given,
    parts: &'a Parts,
    pressures: &'a [Pascal],
    inertia: Option<&'a Inertia>,
) -> Potential<'a> {
    match inertia {
        Some(inertia) => given.in_motion(parts, pressures, 1.0, inertia),
        None => given.at_rest(parts, pressures, 1.0),
    }
}
