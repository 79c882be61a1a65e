//! What one step back adds to the gradient of a motion: −λ · ∂r/∂θ for every parameter.
//!
//! Stands on: `trajectory`, `parameter`, `assembly`. Never knows: how λ was found.

use crate::algebra::vectors::{add, dot};
use crate::material::Lame;
use crate::motion::march::State;
use crate::motion::stencil::Stencil;
use crate::motion::trajectory::{Stretch, Trajectory};
use crate::parameter::Parameter;
use crate::solver::Solver;
use crate::statics::adjoint::RegionGradient;

/// The gradient of one scalar L of a motion by everything that shapes it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionGradient {
    /// One a region; density through inertia and gravity.
    pub regions: Vec<RegionGradient>,
    /// ∂L/∂α, unit of L · s.
    pub mass_damping: f64,
    /// ∂L/∂β, unit of L per s.
    pub stiffness_damping: f64,
    /// ∂L/∂p of each step (from the first) and chamber, unit of L per Pa.
    pub pressures: Vec<Vec<f64>>,
    /// ∂L/∂(a factor before p(t)), one a chamber, unit of L.
    pub pressure_gains: Vec<f64>,
    /// ∂L/∂f of dead forces, 3 a node, unit of L per N.
    pub forces: Vec<f64>,
    /// ∂L by the initial displacement (per m) and velocity (per m/s), 3 a node.
    pub initial: State,
}

/// One step seen from behind.
pub(crate) struct Behind<'a> {
    pub n: usize,
    pub stretch: &'a Stretch,
    pub stencil: Stencil,
}

impl Behind<'_> {
    /// aₙ, 3 a node.
    fn acceleration(&self) -> Vec<f64> {
        let velocity = |j: usize| self.stretch.state(self.n - j).velocity.as_slice();
        self.stencil.rate(velocity(0), (1..=self.stencil.weights.len()).map(velocity))
    }
}

impl Solver {
    /// Nothing gathered yet.
    pub(crate) fn no_gradient(&self, trajectory: &Trajectory) -> MotionGradient {
        let none = RegionGradient { youngs_modulus: 0.0, poissons_ratio: 0.0, density: 0.0 };
        let nodes = self.parts.mesh.nodes.len();
        let chambers = self.parts.chambers.len();
        MotionGradient {
            regions: vec![none; self.given.properties.len()],
            mass_damping: 0.0,
            stiffness_damping: 0.0,
            pressures: vec![vec![0.0; chambers]; trajectory.steps()],
            pressure_gains: vec![0.0; chambers],
            forces: vec![0.0; 3 * nodes],
            initial: State::rest(nodes),
        }
    }

    /// Adds what the elastic forces at `u` feel of E, ν and β.
    pub(crate) fn gather_elastic(&self, u: &[f64], on_elastic: &[f64], on_rate: &[f64], gradient: &mut MotionGradient) {
        let powers = self.parts.body().powers(&self.given.elastic, u, on_elastic, on_rate);
        for ((of, is), [by_mu, by_lambda, rate]) in gradient.regions.iter_mut().zip(&self.given.properties).zip(powers)
        {
            let by = |change: Lame| change.mu * by_mu + change.lambda * by_lambda;
            of.youngs_modulus -= by(Lame::by_youngs_modulus(is.youngs_modulus, is.poissons_ratio));
            of.poissons_ratio -= by(Lame::by_poissons_ratio(is.youngs_modulus, is.poissons_ratio));
            gradient.stiffness_damping -= rate;
        }
    }

    /// Adds −λ · ∂r/∂θ of one step for all other parameters.
    pub(crate) fn gather_other(
        &self,
        trajectory: &Trajectory,
        behind: &Behind,
        lambda: &[f64],
        gradient: &mut MotionGradient,
    ) {
        let State { displacement, velocity } = behind.stretch.state(behind.n);
        let pressures = trajectory.pressures(behind.n);
        let mut moved = behind.acceleration();
        add(&mut moved, trajectory.march.mass_damping, velocity);
        let regions = gradient.regions.len();
        let products = self.parts.overlaps.products(&self.parts.mesh, regions, lambda, &moved);
        for (region, (of, product)) in gradient.regions.iter_mut().zip(products).enumerate() {
            of.density -= product;
            if self.given.gravity != [0.0; 3] {
                of.density -= dot(lambda, &self.load_push(displacement, pressures, Parameter::Density(region)));
            }
        }
        gradient.mass_damping -= dot(lambda, &self.mass_times(velocity));
        for (chamber, by) in gradient.pressures[behind.n - 1].iter_mut().enumerate() {
            *by = -dot(lambda, &self.load_push(displacement, pressures, Parameter::Pressure(chamber)));
            gradient.pressure_gains[chamber] += pressures[chamber] * *by;
        }
        add(&mut gradient.forces, 1.0, lambda);
    }
}
