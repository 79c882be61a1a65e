//! Parameters of an equilibrium or a motion, and the derivative ∂r/∂θ of the residual by each at fixed displacement.

use crate::loads::gas::Gas;
use crate::loads::{Load, add_gravity};
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use materials::material::Moduli;
use si::Pascal;

/// A parameter of an equilibrium or a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// E of a region, Pa.
    YoungsModulus(usize),
    /// The factor of an element's moduli.
    ElementFactor(usize),
    /// ν of a region.
    PoissonsRatio(usize),
    /// C₂₀/C₁₀ (term 0) or C₃₀/C₁₀ (term 1) of a region.
    Stiffening {
        /// Which region.
        region: usize,
        /// 0 or 1.
        term: usize,
    },
    /// g of a relaxation branch; no effect on an equilibrium, which is that of long times.
    RelaxationStrength {
        /// Which region.
        region: usize,
        /// Which of its branches.
        branch: usize,
    },
    /// τ of a relaxation branch, s; no effect on an equilibrium.
    RelaxationTime {
        /// Which region.
        region: usize,
        /// Which of its branches.
        branch: usize,
    },
    /// Strength of a region's springpot; no effect on an equilibrium.
    SpringpotStrength(usize),
    /// Exponent of a region's springpot; no effect on an equilibrium.
    SpringpotExponent(usize),
    /// ρ of a region, kg/m³: through gravity at rest, through inertia too in motion.
    Density(usize),
    /// p in a chamber, Pa; in motion, the same at all times.
    Pressure(usize),
    /// A factor of p(t) of a chamber, evaluated at 1.
    PressureGain(usize),
    /// A dead force on a node, N.
    Force {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// α of Rayleigh damping, 1/s; no effect at rest.
    MassDamping,
    /// β of Rayleigh damping, s; no effect at rest.
    StiffnessDamping,
    /// Initial displacement of a node, m; no effect at rest.
    InitialDisplacement {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// Initial velocity of a node, m/s; no effect at rest.
    InitialVelocity {
        /// Which node.
        node: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
}

impl SolverState {
    /// # Errors
    /// [`SolveError`] when the parameter's region, chamber, node or axis does not exist.
    pub(crate) fn check_parameter(&self, parameter: Parameter) -> Result<(), SolveError> {
        let (regions, chambers) = (self.inputs.properties.len(), self.data.chambers.len());
        let branches = |region: usize| self.inputs.properties.get(region).map(|is| is.relaxation.branches().len());
        let is_springpot =
            |region: usize| self.inputs.properties.get(region).is_some_and(|is| is.relaxation.as_springpot().is_some());
        let (what, index, count) = match parameter {
            Parameter::Stiffening { region, term } => {
                ("the region number of a parameter", if term < 2 { region } else { usize::MAX }, regions)
            }
            Parameter::RelaxationStrength { region, branch } | Parameter::RelaxationTime { region, branch } => {
                ("the branch number of a parameter", branch, branches(region).unwrap_or(0))
            }
            Parameter::SpringpotStrength(region) | Parameter::SpringpotExponent(region) => {
                ("the springpot number of a parameter", 0, usize::from(is_springpot(region)))
            }
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
                3 * self.data.mesh.nodes.len(),
            ),
            Parameter::ElementFactor(element) => {
                ("the element number of a parameter", element, self.data.mesh.elements.len())
            }
            Parameter::MassDamping | Parameter::StiffnessDamping => return Ok(()),
        };
        if index < count {
            return Ok(());
        }
        Err(SolveError::Setting { what, value: index as f64, range: "below their number" })
    }

    /// The derivative of the long-term moduli of a region; none for parameters that they do not depend on.
    fn moduli_derivative(&self, parameter: Parameter) -> Option<(usize, Moduli)> {
        let is = |region: usize| &self.inputs.properties[region];
        match parameter {
            Parameter::YoungsModulus(region) => Some((region, is(region).moduli_by_youngs_modulus())),
            Parameter::PoissonsRatio(region) => Some((region, is(region).moduli_by_poissons_ratio())),
            Parameter::Stiffening { region, term } => Some((region, is(region).moduli_by_stiffening(term))),
            _ => None,
        }
    }

    /// ∂f/∂θ of the elastic forces at `u`, 3 entries per node, N per unit of θ; zero for all but moduli and
    /// stiffening.
    pub(crate) fn elastic_residual_derivative(&self, u: &[f64], parameter: Parameter) -> Vec<f64> {
        let mut derivative = vec![0.0; u.len()];
        if let Parameter::ElementFactor(element) = parameter {
            self.inputs.body(&self.data).add_element_force(u, element, &mut derivative);
        }
        if let Some((region, change)) = self.moduli_derivative(parameter) {
            self.inputs.body(&self.data).force_derivative(u, region, change, &mut derivative);
        }
        derivative
    }

    /// ∂r/∂θ of the loads at `u` and `pressures`, 3 entries per node, N per unit of θ; zero for what is not a load.
    pub(crate) fn load_residual_derivative(&self, u: &[f64], pressures: &[Pascal], parameter: Parameter) -> Vec<f64> {
        let mut derivative = vec![0.0; u.len()];
        match parameter {
            Parameter::Density(region) => {
                let mut nodal_mass = vec![0.0; self.data.mesh.nodes.len()];
                self.data.products.add_nodal_mass(&self.data.mesh, region, -1.0, &mut nodal_mass);
                add_gravity(&nodal_mass, self.inputs.gravity, &mut derivative);
            }
            Parameter::Pressure(chamber) => {
                let gas = self.chamber_gas(chamber, pressures);
                gas.chamber.add_gradient(u, gas.gauge_by_pressure(u), &mut derivative);
            }
            Parameter::PressureGain(chamber) => {
                let gas = self.chamber_gas(chamber, pressures);
                gas.chamber.add_gradient(u, pressures[chamber] * gas.gauge_by_pressure(u), &mut derivative);
            }
            Parameter::Force { node, axis } => derivative[3 * node + axis] = -1.0,
            _ => {}
        }
        derivative
    }

    fn chamber_gas(&self, chamber: usize, pressures: &[Pascal]) -> Gas<'_> {
        let (pressure, ambient) = (pressures[chamber], self.inputs.ambient[chamber]);
        Gas { chamber: &self.data.chambers[chamber], pressure, ambient }
    }
}
