//! Parameters: what a shape at rest or a motion depends on, and how the balance of forces feels each of them.
//!
//! r(u, θ) = 0 is the balance; `push` gives ∂r/∂θ at fixed u.
//!
//! Stands on: `solver`, `gas`. Never knows: a tangent, a time step.

use crate::given::add_weights;
use crate::load::Load;
use crate::material::Lame;
use crate::solver::Solver;
use crate::stall::SolveError;
use si::Pascal;

/// What a shape or a motion depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// E of a region, Pa.
    YoungsModulus(usize),
    /// ν of a region.
    PoissonsRatio(usize),
    /// ρ of a region, kg/m³: through gravity at rest, through inertia too in motion.
    Density(usize),
    /// p in a chamber, Pa; in motion, the same at all times.
    Pressure(usize),
    /// A factor before p(t) of a chamber, at 1.
    PressureGain(usize),
    /// A dead force on a node, N.
    Force {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// α of Rayleigh's damping, 1/s; nothing at rest.
    MassDamping,
    /// β of Rayleigh's damping, s; nothing at rest.
    StiffnessDamping,
    /// Displacement of a node at the start of a motion, m; nothing at rest.
    InitialDisplacement {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// Velocity of a node at the start of a motion, m/s; nothing at rest.
    InitialVelocity {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
}

impl Solver {
    /// # Errors
    /// [`SolveError`] when the parameter's region, chamber, node or axis does not exist.
    pub(crate) fn check_parameter(&self, parameter: Parameter) -> Result<(), SolveError> {
        let (regions, chambers) = (self.given.properties.len(), self.parts.chambers.len());
        let (what, index, count) = match parameter {
            Parameter::YoungsModulus(region) | Parameter::PoissonsRatio(region) | Parameter::Density(region) => {
                ("the region number of a parameter", region, regions)
            }
            Parameter::Pressure(chamber) | Parameter::PressureGain(chamber) => {
                ("the chamber number of a parameter", chamber, chambers)
            }
            Parameter::Force { node, axis }
            | Parameter::InitialDisplacement { node, axis }
            | Parameter::InitialVelocity { node, axis } => (
                "3 node + axis of a parameter",
                if axis < 3 { 3 * node + axis } else { usize::MAX },
                3 * self.parts.mesh.nodes.len(),
            ),
            Parameter::MassDamping | Parameter::StiffnessDamping => return Ok(()),
        };
        if index < count {
            return Ok(());
        }
        Err(SolveError::Setting { what, value: index as f64, range: "below their number" })
    }

    /// The change of Lamé's constants with E or ν of a region; nothing for other parameters.
    pub(crate) fn lame_change(&self, parameter: Parameter) -> Option<(usize, Lame)> {
        let is = |region: usize| &self.given.properties[region];
        match parameter {
            Parameter::YoungsModulus(region) => {
                let (e, nu) = (is(region).youngs_modulus, is(region).poissons_ratio);
                Some((region, Lame::by_youngs_modulus(e, nu)))
            }
            Parameter::PoissonsRatio(region) => {
                let (e, nu) = (is(region).youngs_modulus, is(region).poissons_ratio);
                Some((region, Lame::by_poissons_ratio(e, nu)))
            }
            _ => None,
        }
    }

    /// ∂f/∂θ of the elastic forces at `u`, 3 a node, N per unit of θ; zeros for all but E and ν.
    pub(crate) fn elastic_push(&self, u: &[f64], parameter: Parameter) -> Vec<f64> {
        let mut push = vec![0.0; u.len()];
        if let Some((region, change)) = self.lame_change(parameter) {
            self.parts.body().force_change(&self.given.elastic, u, region, change, &mut push);
        }
        push
    }

    /// ∂r/∂θ of the loads at `u` and `pressures`, 3 a node, N per unit of θ; zeros for what is no load.
    pub(crate) fn load_push(&self, u: &[f64], pressures: &[Pascal], parameter: Parameter) -> Vec<f64> {
        let mut push = vec![0.0; u.len()];
        match parameter {
            Parameter::Density(region) => {
                let mut weights = vec![0.0; self.parts.mesh.nodes.len()];
                self.parts.overlaps.add_weights(&self.parts.mesh, region, -1.0, &mut weights);
                add_weights(&weights, self.given.gravity, &mut push);
            }
            Parameter::Pressure(chamber) => self.add_pressure_push(u, pressures, chamber, 1.0, &mut push),
            Parameter::PressureGain(chamber) => {
                self.add_pressure_push(u, pressures, chamber, pressures[chamber], &mut push);
            }
            Parameter::Force { node, axis } => push[3 * node + axis] = -1.0,
            _ => {}
        }
        push
    }

    fn add_pressure_push(&self, u: &[f64], pressures: &[Pascal], chamber: usize, scale: f64, push: &mut [f64]) {
        let (pressure, ambient) = (pressures[chamber], self.given.ambient[chamber]);
        let gas = crate::gas::Gas { chamber: &self.parts.chambers[chamber], pressure, ambient };
        self.parts.chambers[chamber].add_gradient(u, scale * gas.gauge_by_pressure(u), push);
    }
}
