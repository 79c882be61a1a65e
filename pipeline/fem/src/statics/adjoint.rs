//! Gradients of an equilibrium: backwards from one scalar to all parameters, forwards from one parameter to all nodes.
//!
//! With r(u, θ) = ∂Π/∂u = 0 and the symmetric tangent K = ∂r/∂u:
//! du/dθ = −K⁻¹ ∂r/∂θ,  dL/dθ = −λ · ∂r/∂θ with K λ = ∂L/∂u.
//!
//! Stands on: `statics`, `tangent`, `parameter`. Never knows: what the scalar measures.

use crate::algebra::vectors::dot;
use crate::descent::tangent::Demand;
use crate::parameter::Parameter;
use crate::solver::Solver;
use crate::stall::SolveError;
use crate::statics::equilibrium::Equilibrium;

/// ∂L/∂E, ∂L/∂ν and ∂L/∂ρ of one region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionGradient {
    /// Unit of L per Pa.
    pub youngs_modulus: f64,
    /// Unit of L.
    pub poissons_ratio: f64,
    /// Unit of L per kg/m³.
    pub density: f64,
}

/// The gradient of one scalar L by everything that shapes an equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// One a region.
    pub regions: Vec<RegionGradient>,
    /// ∂L/∂p, one a chamber, unit of L per Pa.
    pub pressures: Vec<f64>,
    /// ∂L/∂f of dead forces, 3 a node, unit of L per N.
    pub forces: Vec<f64>,
}

/// Four digits below what a Taylor test resolves; a factor of the exact tangent is cheaper than twelve iterations.
const EXACT: Demand = Demand { tolerance: 1e-11, patience: 12 };

impl Solver {
    /// ∂L/∂E, ∂L/∂ν and ∂L/∂ρ of every region, from `dloss_du` = ∂L/∂u (3 a node, unit of L per m) at the equilibrium
    /// `at`.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable or a list has the wrong length.
    pub fn adjoint(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Vec<RegionGradient>, SolveError> {
        self.gradient(at, dloss_du).map(|gradient| gradient.regions)
    }

    /// The same, with ∂L/∂p of every chamber and ∂L/∂f of every dead force.
    ///
    /// # Errors
    /// As [`Solver::adjoint`].
    pub fn gradient(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Gradient, SolveError> {
        self.check_field("the derivative of the loss", dloss_du)?;
        let lambda = self.tangent_solve(at, dloss_du)?;
        let by = |solver: &Self, parameter| -dot(&lambda, &solver.push(at, parameter));
        let region = |region| RegionGradient {
            youngs_modulus: by(self, Parameter::YoungsModulus(region)),
            poissons_ratio: by(self, Parameter::PoissonsRatio(region)),
            density: by(self, Parameter::Density(region)),
        };
        let regions = (0..self.given.elastic.len()).map(region).collect();
        let pressures = (0..self.parts.chambers.len()).map(|chamber| by(self, Parameter::Pressure(chamber))).collect();
        Ok(Gradient { regions, pressures, forces: lambda })
    }

    /// du/dθ at the equilibrium `at`, 3 a node, m per unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable, or what the parameter names does not exist.
    pub fn sensitivity(&mut self, at: &Equilibrium, parameter: Parameter) -> Result<Vec<f64>, SolveError> {
        self.check_parameter(parameter)?;
        self.check_field("the displacement", &at.displacement)?;
        let mut push = self.push(at, parameter);
        push.iter_mut().for_each(|entry| *entry = -*entry);
        self.tangent_solve(at, &push)
    }

    /// ∂r/∂θ at fixed u, 3 a node, N per unit of the parameter.
    fn push(&self, at: &Equilibrium, parameter: Parameter) -> Vec<f64> {
        match parameter {
            Parameter::YoungsModulus(_) | Parameter::PoissonsRatio(_) => self.elastic_push(&at.displacement, parameter),
            _ => self.load_push(&at.displacement, &at.pressures, parameter),
        }
    }

    /// K⁻¹ b at the equilibrium `at`, both 3 a node; held freedoms come out as nothing.
    fn tangent_solve(&mut self, at: &Equilibrium, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_pressures(&at.pressures)?;
        let Self { parts, given, newton, linearised } = self;
        let potential = given.at_rest(parts, &at.pressures, 1.0);
        if linearised.as_ref() != Some(at) {
            newton.linearise(&potential, &at.displacement);
            *linearised = Some(at.clone());
        }
        let mut free = Vec::new();
        parts.pattern.gather(b, &mut free);
        let (x, _) = newton.solve_exactly(&potential, &at.displacement, &free, EXACT).ok_or(SolveError::NotStable)?;
        let mut full = vec![0.0; b.len()];
        parts.pattern.spread(&x, 1.0, &mut full);
        Ok(full)
    }
}
