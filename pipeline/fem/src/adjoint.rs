//! Gradients of an equilibrium: backwards from one scalar to all parameters, forwards from one parameter to all nodes.
//!
//! With r(u, θ) = ∂Π/∂u = 0 and the symmetric tangent K = ∂r/∂u:
//! du/dθ = −K⁻¹ ∂r/∂θ,  dL/dθ = −λ · ∂r/∂θ with K λ = ∂L/∂u;  ∂r/∂p = −∂V/∂u.
//!
//! The factor that Newton left is one step off the solution, so conjugate gradients on the exact tangent need two or
//! three iterations with it. When they need many, the exact tangent is factorised.
//!
//! Stands on: `statics`, `krylov`. Never knows: what the scalar measures.

use crate::krylov::conjugate_gradients;
use crate::load::Load;
use crate::material::Lame;
use crate::newton::Newton;
use crate::potential::{Curvature, dot};
use crate::solver::{SolveError, Solver, at_rest};
use crate::statics::Equilibrium;
use crate::system::Parts;

/// ∂L/∂E and ∂L/∂ν of one region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionGradient {
    /// Unit of L per Pa.
    pub youngs_modulus: f64,
    /// Unit of L.
    pub poissons_ratio: f64,
}

/// The gradient of one scalar L by everything that shapes an equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// One a region.
    pub regions: Vec<RegionGradient>,
    /// ∂L/∂p, one a chamber, unit of L per Pa.
    pub pressures: Vec<f64>,
}

/// What an equilibrium depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// E of a region.
    YoungsModulus(usize),
    /// ν of a region.
    PoissonsRatio(usize),
    /// p in a chamber.
    Pressure(usize),
}

/// ‖Kx − b‖ / ‖b‖ of a gradient: four digits below what a Taylor test resolves.
const EXACT: f64 = 1e-11;
/// Iterations after which a factor of the exact tangent is cheaper.
const PATIENCE: usize = 12;

impl Solver {
    /// ∂L/∂E and ∂L/∂ν of every region, from `dloss_du` = ∂L/∂u (3 a node, unit of L per m) at the equilibrium `at`.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable or a list has the wrong length.
    pub fn adjoint(&mut self, at: &Equilibrium, dloss_du: &[f64]) -> Result<Vec<RegionGradient>, SolveError> {
        self.gradient(at, dloss_du).map(|gradient| gradient.regions)
    }

    /// The same, with ∂L/∂p of every chamber.
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
        };
        let regions = (0..self.elastic.len()).map(region).collect();
        let pressures = (0..self.parts.chambers.len()).map(|chamber| by(self, Parameter::Pressure(chamber))).collect();
        Ok(Gradient { regions, pressures })
    }

    /// du/dθ at the equilibrium `at`, 3 a node, m per unit of the parameter.
    ///
    /// # Errors
    /// [`SolveError`] when the equilibrium is not stable, or the parameter's region or chamber does not exist.
    pub fn sensitivity(&mut self, at: &Equilibrium, parameter: Parameter) -> Result<Vec<f64>, SolveError> {
        let (what, index, asked) = match parameter {
            Parameter::YoungsModulus(region) | Parameter::PoissonsRatio(region) => {
                ("the region number of a parameter", region, self.elastic.len())
            }
            Parameter::Pressure(chamber) => ("the chamber number of a parameter", chamber, self.parts.chambers.len()),
        };
        if index >= asked {
            return Err(SolveError::Setting { what, value: index as f64, range: "below their number" });
        }
        self.check_field("the displacement", &at.displacement)?;
        let mut push = self.push(at, parameter);
        push.iter_mut().for_each(|entry| *entry = -*entry);
        self.tangent_solve(at, &push)
    }

    /// ∂r/∂θ at fixed u, 3 a node, N per unit of the parameter.
    fn push(&self, at: &Equilibrium, parameter: Parameter) -> Vec<f64> {
        let mut push = vec![0.0; at.displacement.len()];
        let mut change = |region: usize, change: Lame| {
            self.parts.body().force_change(&self.elastic, &at.displacement, region, change, &mut push);
        };
        match parameter {
            Parameter::YoungsModulus(region) => {
                let is = &self.properties[region];
                change(region, Lame::by_youngs_modulus(is.youngs_modulus, is.poissons_ratio));
            }
            Parameter::PoissonsRatio(region) => {
                let is = &self.properties[region];
                change(region, Lame::by_poissons_ratio(is.youngs_modulus, is.poissons_ratio));
            }
            Parameter::Pressure(chamber) => {
                self.parts.chambers[chamber].add_gradient(&at.displacement, 1.0, &mut push);
            }
        }
        push
    }

    /// K⁻¹ b at the equilibrium `at`, both 3 a node; held freedoms come out as nothing.
    fn tangent_solve(&mut self, at: &Equilibrium, b: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the displacement", &at.displacement)?;
        self.check_pressures(&at.pressures)?;
        if self.linearised.as_ref() != Some(at) {
            let potential = at_rest(&self.parts, &self.elastic, &self.dead, &at.pressures, 1.0);
            potential.curvature(&at.displacement, &[], Curvature::Exact, &mut self.newton.values);
            self.newton.turn_to(&potential, &at.displacement);
            self.linearised = Some(at.clone());
        }
        let mut free = Vec::new();
        self.parts.pattern.gather(b, &mut free);
        let mut full = vec![0.0; b.len()];
        if free.iter().any(|&entry| entry != 0.0) {
            let solved = self.tangent_solve_free(&free, &at.displacement).ok_or(SolveError::NotStable)?;
            self.parts.pattern.spread(&solved, 1.0, &mut full);
        }
        Ok(full)
    }

    fn tangent_solve_free(&mut self, b: &[f64], u: &[f64]) -> Option<Vec<f64>> {
        let Self { parts, newton, .. } = self;
        if let Some(x) = newton.is_ready().then(|| exactly(parts, newton, b)).flatten() {
            return Some(x);
        }
        newton.factorise(parts, u, b).ok()?;
        // rounding may keep the residual of a stiff sheet above the goal: the factor's own answer is then the best
        exactly(parts, newton, b).or_else(|| {
            let mut x = b.to_vec();
            newton.solve(parts, &mut x);
            Some(x)
        })
    }
}

/// K⁻¹ b by conjugate gradients on the tangent in `newton`, if they get there.
fn exactly(parts: &Parts, newton: &mut Newton, b: &[f64]) -> Option<Vec<f64>> {
    let values = std::mem::take(&mut newton.values);
    let improve = |x: &mut [f64]| newton.solve(parts, x);
    let found = conjugate_gradients(&parts.pattern, &values, improve, b, EXACT, PATIENCE);
    newton.values = values;
    found.map(|(x, _)| x)
}
