//! Statics of a reduced model with constants of its own: equilibria and their derivatives.
//!
//! r(q; θ) = f(q; θ) − Σ p ∂V/∂q = 0 with the tangent K = ∂r/∂q, so that dq/dθ = −K⁻¹ ∂f/∂θ; a loss with the derivative a by q has
//! dL/dθ = −(K⁻¹a) · ∂f/∂θ.

use std::sync::Arc;

use materials::material::Moduli;
use nalgebra::{Cholesky, DVector, Dyn};
use si::Pascal;

use super::chamber_volume::CubicVolume;
use super::contact::ReducedContact;
use super::elastic_forces::{ActingRegion, ReducedTangent};
use super::error::ReducedError;
use super::model::ReducedModel;
use super::step::{NoForce, Step, no_convergence};
use crate::adjoint::parameter::Parameter;
use crate::dynamics::settings::DynamicSettings;
use crate::dynamics::stencil::Stencil;
use crate::properties::RegionProperties;
use crate::setup_error::SetupError;
use crate::solve_error::SolveError;
use crate::validation;

/// A reduced model with constants that change from solve to solve, as [`crate::Solver`] is of the whole body.
#[derive(Debug, Clone)]
pub struct ReducedSolver {
    model: Arc<ReducedModel>,
    regions: Vec<RegionProperties>,
    contact: Option<Arc<ReducedContact>>,
}

/// A stable equilibrium of a reduced model.
#[derive(Debug, Clone)]
pub struct ReducedEquilibrium {
    /// q
    pub coordinates: DVector<f64>,
    /// Of K.
    factor: Cholesky<f64, Dyn>,
}

impl ReducedSolver {
    /// Of `model`, with the constants of its `regions`.
    ///
    /// # Panics
    /// When there is not one set of constants per region.
    pub fn new(model: Arc<ReducedModel>, regions: Vec<RegionProperties>) -> Self {
        assert_eq!(regions.len(), model.regions, "one set of constants per region");
        Self { model, regions, contact: None }
    }

    /// The same with walls that repel each other.
    pub fn in_contact(self, contact: Option<Arc<ReducedContact>>) -> Self {
        Self { contact, ..self }
    }

    /// The model.
    pub fn model(&self) -> &ReducedModel {
        &self.model
    }

    /// Sets E (Pa) and ν of `region`.
    ///
    /// # Errors
    /// [`SetupError`] when there is no such region, or a constant is out of range.
    pub fn set_elastic(
        &mut self,
        region: usize,
        youngs_modulus: Pascal,
        poissons_ratio: f64,
    ) -> Result<(), SetupError> {
        validation::check_elastic(region, youngs_modulus, poissons_ratio)?;
        let properties = self.region(region)?;
        (properties.youngs_modulus, properties.poissons_ratio) = (youngs_modulus, poissons_ratio);
        Ok(())
    }

    /// Sets C₂₀/C₁₀ and C₃₀/C₁₀ of `region`; without effect on laws that do not stiffen.
    ///
    /// # Errors
    /// As [`ReducedSolver::set_elastic`].
    pub fn set_stiffening(&mut self, region: usize, ratios: [f64; 2]) -> Result<(), SetupError> {
        validation::check_stiffening(region, ratios)?;
        self.region(region)?.stiffening = ratios;
        Ok(())
    }

    fn region(&mut self, index: usize) -> Result<&mut RegionProperties, SetupError> {
        let count = self.regions.len();
        self.regions.get_mut(index).ok_or(SetupError::NoSuchIndex { part: "region", index, count })
    }

    /// The stable equilibrium under `pressures` (one per chamber, Pa) by Newton's method from the coordinates `predicted`, and from the shape
    /// `nearby` where these lead nowhere.
    ///
    /// # Errors
    /// [`ReducedError::NoConvergence`] at time 0; [`SolveError::NotStable`] where what was found is a saddle.
    ///
    /// # Panics
    /// When a list has the wrong length.
    pub fn equilibrium_near(
        &self,
        pressures: &[Pascal],
        nearby: &DVector<f64>,
        predicted: &DVector<f64>,
    ) -> Result<ReducedEquilibrium, ReducedError> {
        let model = &*self.model;
        assert_eq!(pressures.len(), model.chambers.len(), "one pressure per chamber");
        let acting = self.acting(&self.regions.iter().map(RegionProperties::moduli).collect::<Vec<_>>());
        // A stencil without rates leaves the static equations.
        let stencil = Stencil { gamma: 0.0, weights: Vec::new() };
        let zero = || DVector::zeros(model.coordinates());
        let equations = Step {
            model,
            settings: &DynamicSettings::default(),
            stencil: &stencil,
            pressures,
            acting: &acting,
            external: &NoForce,
            contact: self.contact.as_deref(),
            time: 0.0,
            past: [zero(), zero(), zero()],
        };
        let solved = equations.solve(&equations.admissible_shape(nearby, predicted), nearby, &mut None);
        let coordinates = solved.map_err(|change| no_convergence(0.0, change))?;
        let mut tangent = model.acting_stiffness(&coordinates, ReducedTangent::Exact, &acting);
        for (chamber, pressure) in model.chambers.iter().zip(pressures) {
            chamber.add_hessian(&coordinates, -pressure, &mut tangent);
        }
        if let Some(contact) = &self.contact {
            contact.add_hessian(&coordinates, false, &mut tangent);
        }
        // Its failure shows a saddle, which Newton's method finds as readily as a minimum; LU would factor it.
        let factor = Cholesky::new(tangent).ok_or(SolveError::NotStable)?;
        Ok(ReducedEquilibrium { coordinates, factor })
    }

    /// dq/dθ at an equilibrium, per unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError::Setting`] of a parameter that a reduced model does not have.
    pub fn sensitivity(&self, at: &ReducedEquilibrium, parameter: Parameter) -> Result<DVector<f64>, SolveError> {
        Ok(-at.factor.solve(&self.force_derivative(at, parameter)?))
    }

    /// dL/dθ of each of the `parameters`, of a loss with the derivative `by_coordinates` at an equilibrium.
    ///
    /// # Errors
    /// As [`ReducedSolver::sensitivity`].
    pub fn adjoint(
        &self,
        at: &ReducedEquilibrium,
        by_coordinates: &DVector<f64>,
        parameters: &[Parameter],
    ) -> Result<Vec<f64>, SolveError> {
        let lambda = at.factor.solve(by_coordinates);
        parameters.iter().map(|&parameter| Ok(-lambda.dot(&self.force_derivative(at, parameter)?))).collect()
    }

    /// dL/dp of each chamber, of a loss with the derivative `by_coordinates` at an equilibrium, 1/Pa.
    pub fn pressure_gradient(&self, at: &ReducedEquilibrium, by_coordinates: &DVector<f64>) -> Vec<f64> {
        let lambda = at.factor.solve(by_coordinates);
        let by_pressure = |chamber: &CubicVolume| {
            let mut gradient = DVector::zeros(lambda.len());
            chamber.add_gradient(&at.coordinates, 1.0, &mut gradient);
            gradient.dot(&lambda)
        };
        self.model.chambers.iter().map(by_pressure).collect()
    }

    /// ∂f/∂θ, J per unit of the parameter.
    fn force_derivative(&self, at: &ReducedEquilibrium, parameter: Parameter) -> Result<DVector<f64>, SolveError> {
        let no_such = || SolveError::Setting {
            what: "a parameter of a reduced equilibrium",
            value: f64::NAN,
            range: "a modulus, a Poisson's ratio or a stiffening of one of its regions",
        };
        let (region, change): (usize, fn(&RegionProperties, usize) -> Moduli) = match parameter {
            Parameter::YoungsModulus(region) => (region, |of, _| of.moduli_by_youngs_modulus()),
            Parameter::PoissonsRatio(region) => (region, |of, _| of.moduli_by_poissons_ratio()),
            Parameter::Stiffening { region, .. } => (region, |of, term| of.moduli_by_stiffening(term)),
            _ => return Err(no_such()),
        };
        let term = if let Parameter::Stiffening { term, .. } = parameter { term } else { 0 };
        let changed = change(self.regions.get(region).ok_or_else(no_such)?, term);
        // every law is linear in its moduli
        let only = |index| if index == region { changed } else { changed.scaled(0.0) };
        Ok(self
            .model
            .acting_forces(&at.coordinates, &self.acting(&(0..self.regions.len()).map(only).collect::<Vec<_>>())))
    }

    /// What acts at each group of points where the regions have these moduli.
    fn acting(&self, moduli: &[Moduli]) -> Vec<ActingRegion> {
        self.model.points.iter().map(|points| points.acting(moduli[points.region])).collect()
    }
}
