//! Adjoint and forward sensitivity of an equilibrium.
//!
//! With the residual r(u, θ) = ∂Π/∂u = 0 and the symmetric tangent K = ∂r/∂u:
//! du/dθ = −K⁻¹ ∂r/∂θ,  dL/dθ = −λ · ∂r/∂θ with K λ = ∂L/∂u.

use crate::adjoint::gradient::{Gradient, RegionGradient};
use crate::adjoint::parameter::Parameter;
use crate::assembly::elastic::Body;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::Equilibrium;
use sparse::{PcgOptions, add, dot};

/// Four digits below what a Taylor test resolves; beyond twelve iterations a factorisation of the exact tangent is
/// cheaper.
const ADJOINT: PcgOptions = PcgOptions { tolerance: 1e-11, max_iterations: 12 };

impl SolverState {
    /// See [`crate::Solver::gradient`].
    pub(crate) fn equilibrium_gradient(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Gradient, SolveError> {
        self.check_field("the derivative of the loss", dloss_du)?;
        // The tangent is symmetric, so the adjoint needs no transposed factor: the one that Newton's method left
        // preconditions it.
        let lambda = self.solve_at(at, dloss_du)?;
        let by = |state: &Self, parameter| -dot(&lambda, &state.residual_derivative(at, parameter));
        let region = |region| RegionGradient {
            youngs_modulus: by(self, Parameter::YoungsModulus(region)),
            poissons_ratio: by(self, Parameter::PoissonsRatio(region)),
            density: by(self, Parameter::Density(region)),
            stiffening: [0, 1].map(|term| by(self, Parameter::Stiffening { region, term })),
        };
        let regions = (0..self.inputs.elastic.len()).map(region).collect();
        let pressures = (0..self.data.chambers.len()).map(|chamber| by(self, Parameter::Pressure(chamber))).collect();
        let mut elements = self.inputs.body(&self.data).element_work(&at.displacement, &lambda);
        elements.iter_mut().for_each(|work| *work = -*work);
        Ok(Gradient { regions, elements, pressures, forces: lambda })
    }

    /// See [`crate::Solver::sensitivity`].
    pub(crate) fn equilibrium_sensitivity(
        &mut self,
        at: &Equilibrium,
        parameter: Parameter,
    ) -> Result<Vec<f64>, SolveError> {
        self.equilibrium_sensitivity_along(at, &[(parameter, 1.0)])
    }

    /// See [`crate::Solver::sensitivity_along`].
    pub(crate) fn equilibrium_sensitivity_along(
        &mut self,
        at: &Equilibrium,
        direction: &[(Parameter, f64)],
    ) -> Result<Vec<f64>, SolveError> {
        direction.iter().try_for_each(|&(parameter, _)| self.check_parameter(parameter))?;
        self.check_field("the displacement", &at.displacement)?;
        let mut right = vec![0.0; at.displacement.len()];
        let mut factors = Vec::new();
        for &(parameter, part) in direction {
            match parameter {
                Parameter::Force { node, axis } => right[3 * node + axis] += part,
                // Directions of all elements at once: their forces are those of a body with these factors.
                Parameter::ElementFactor(element) => {
                    factors.resize(self.data.mesh.elements.len(), 0.0);
                    factors[element] += part;
                }
                _ => add(&mut right, -part, &self.residual_derivative(at, parameter)),
            }
        }
        if !factors.is_empty() {
            let mut force = vec![0.0; right.len()];
            let body = Body { factors: &factors, ..self.inputs.body(&self.data) };
            body.energy(&at.displacement, &mut force);
            add(&mut right, -1.0, &force);
        }
        self.solve_at(at, &right)
    }

    /// ∂r/∂θ at fixed u, 3 entries per node, N per unit of the parameter.
    fn residual_derivative(&self, at: &Equilibrium, parameter: Parameter) -> Vec<f64> {
        match parameter {
            Parameter::YoungsModulus(_)
            | Parameter::ElementFactor(_)
            | Parameter::PoissonsRatio(_)
            | Parameter::Stiffening { .. } => self.elastic_residual_derivative(&at.displacement, parameter),
            _ => self.load_residual_derivative(&at.displacement, &at.pressures, parameter),
        }
    }

    /// K⁻¹ b at the equilibrium `at`, both 3 entries per node; zero at constrained dofs.
    fn solve_at(&mut self, at: &Equilibrium, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_pressures(&at.pressures)?;
        let Self { data, inputs, newton, linearised } = self;
        let potential = inputs.at_rest(data, &at.pressures);
        if linearised.as_ref() != Some(at) {
            newton.linearise(&potential, &at.displacement);
            *linearised = Some(at.clone());
        }
        let free = data.pattern.gather(b);
        let (x, _) = newton.tangent_solve(&potential, &at.displacement, &free, ADJOINT).ok_or(SolveError::NotStable)?;
        Ok(data.pattern.scattered(&x, 1.0, b.len()))
    }
}
