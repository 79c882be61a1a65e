//! Adjoint and forward sensitivity of an equilibrium.
//!
//! With the residual r(u, θ) = ∂Π/∂u = 0 and the symmetric tangent K = ∂r/∂u:
//! du/dθ = −K⁻¹ ∂r/∂θ,  dL/dθ = −λ · ∂r/∂θ with K λ = ∂L/∂u.

use crate::adjoint::gradient::{Gradient, RegionGradient};
use crate::adjoint::parameter::Parameter;
use crate::assembly::elastic::Body;
use crate::properties::RegionProperties;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use crate::statics::equilibrium::Equilibrium;
use materials::material::Moduli;
use sparse::{PcgOptions, add, dot};

/// PCG of the adjoint of an equilibrium.
// Four digits below what a Taylor test resolves; beyond twelve iterations a factorisation of the exact tangent is cheaper.
const ADJOINT: PcgOptions = PcgOptions { tolerance: 1e-11, max_iterations: 12 };

impl SolverState {
    /// See [`crate::Solver::gradient`].
    pub(crate) fn equilibrium_gradient(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Gradient, SolveError> {
        self.check_field("the derivative of the loss", dloss_du)?;
        // The tangent is symmetric, so the adjoint needs no transposed factor: the one that Newton's method left
        // preconditions it.
        let lambda = self.solve_at(at, dloss_du)?;
        let load_derivative = |parameter| -dot(&lambda, &self.residual_derivative(at, parameter));
        let work = self.inputs.body(&self.data).element_work(&at.displacement, &lambda);
        let mut regions = self.region_gradients(&work);
        // Without gravity a density has no effect on an equilibrium.
        if self.inputs.gravity != [0.0; 3] {
            regions.iter_mut().enumerate().for_each(|(region, region_gradient)| {
                region_gradient.density = load_derivative(Parameter::Density(region))
            });
        }
        let pressures =
            (0..self.data.chambers.len()).map(|chamber| load_derivative(Parameter::Pressure(chamber))).collect();
        let elements = self.element_gradients(&work);
        Ok(Gradient { regions, elements, pressures, forces: lambda })
    }

    /// ∂L by E, ν and stiffening of each region, from the virtual `work` of each element along λ by its moduli: one pass
    /// over the mesh serves all of them.
    fn region_gradients(&self, work: &[[f64; 4]]) -> Vec<RegionGradient> {
        let mut sums = vec![[0.0; 4]; self.inputs.properties.len()];
        for (element, (work, &region)) in work.iter().zip(&self.data.mesh.regions).enumerate() {
            let factor = self.inputs.factors.get(element).copied().unwrap_or(1.0);
            sums[region as usize].iter_mut().zip(work).for_each(|(sum, work)| *sum += factor * work);
        }
        let region_gradient = |(properties, sums): (&RegionProperties, [f64; 4])| {
            let derivative_along =
                |change: Moduli| -change.to_array().iter().zip(sums).map(|(change, sum)| change * sum).sum::<f64>();
            RegionGradient {
                youngs_modulus: derivative_along(properties.moduli_by_youngs_modulus()),
                poissons_ratio: derivative_along(properties.moduli_by_poissons_ratio()),
                density: 0.0,
                stiffening: [0, 1].map(|term| derivative_along(properties.moduli_by_stiffening(term))),
            }
        };
        self.inputs.properties.iter().zip(sums).map(region_gradient).collect()
    }

    /// ∂L by the factor of each element.
    pub(crate) fn element_gradients(&self, work: &[[f64; 4]]) -> Vec<f64> {
        let moduli: Vec<[f64; 4]> = self.inputs.elastic.iter().map(|elastic| elastic.moduli.to_array()).collect();
        let element_gradient = |(work, &region): (&[f64; 4], &u16)| {
            -moduli[region as usize].iter().zip(work).map(|(modulus, work)| modulus * work).sum::<f64>()
        };
        work.iter().zip(&self.data.mesh.regions).map(element_gradient).collect()
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

    /// Notes that the tangent which Newton's method factorised on the way to `found` is also that at `found`: where every
    /// law is linear, and no pressure turns with the walls, it does not depend on the displacement. The adjoint of a
    /// linear problem then assembles nothing.
    pub(crate) fn keep_constant_tangent(&mut self, found: &Equilibrium) {
        let is_linear = self.inputs.elastic.iter().all(|is| !is.material.is_objective());
        let has_gas = self.inputs.at_rest(&self.data, &found.pressures).gases().next().is_some();
        if is_linear && !has_gas && self.data.contact.is_none() && found.factorisations > 0 {
            self.linearised = Some(found.clone());
        }
    }

    /// K⁻¹ b at the equilibrium `at`, both 3 entries per node; zero at constrained dofs.
    pub(crate) fn solve_at(&mut self, at: &Equilibrium, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.linearise_at(at)?;
        let Self { data, inputs, newton, .. } = self;
        let potential = inputs.at_rest(data, &at.pressures);
        let free = data.pattern.gather(b);
        let (x, _) = newton.tangent_solve(&potential, &at.displacement, &free, ADJOINT).ok_or(SolveError::NotStable)?;
        Ok(data.pattern.scattered(&x, 1.0, b.len()))
    }

    /// See [`crate::Solver::factorise_at`].
    pub(crate) fn factorise_at(&mut self, at: &Equilibrium) -> Result<(), SolveError> {
        self.linearise_at(at)?;
        let Self { data, inputs, newton, .. } = self;
        let potential = inputs.at_rest(data, &at.pressures);
        let mut probe = vec![0.0; data.pattern.dofs()];
        data.pattern.multiply(&newton.tangent, &vec![1.0; probe.len()], &mut probe);
        newton.factorise(&potential, &at.displacement, &probe).map_err(|_| SolveError::NotStable)
    }

    /// Assembles the exact tangent at `at`, unless it is that of the last call.
    fn linearise_at(&mut self, at: &Equilibrium) -> Result<(), SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_pressures(&at.pressures)?;
        self.couple_contact(&at.displacement)?;
        let Self { data, inputs, newton, linearised } = self;
        let is_same = |state: &Equilibrium| state.displacement == at.displacement && state.pressures == at.pressures;
        if !linearised.as_ref().is_some_and(is_same) {
            newton.linearise(&inputs.at_rest(data, &at.pressures), &at.displacement);
            *linearised = Some(at.clone());
        }
        Ok(())
    }
}
