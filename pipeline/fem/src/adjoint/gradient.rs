//! Gradients of a scalar by everything that an equilibrium or a motion depends on.

use crate::dynamics::settings::State;

/// ∂L by E, ν, ρ and stiffening of one region.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RegionGradient {
    /// Unit of L per Pa.
    pub youngs_modulus: f64,
    /// Unit of L.
    pub poissons_ratio: f64,
    /// Unit of L per kg/m³.
    pub density: f64,
    /// By C₂₀/C₁₀ and C₃₀/C₁₀, unit of L.
    pub stiffening: [f64; 2],
}

/// The gradient of one scalar L of an equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// One per region.
    pub regions: Vec<RegionGradient>,
    /// ∂L by the factor of each element's moduli, unit of L.
    pub elements: Vec<f64>,
    /// ∂L/∂p, one per chamber, unit of L per Pa.
    pub pressures: Vec<f64>,
    /// ∂L/∂f of dead forces, 3 entries per node, unit of L per N.
    pub forces: Vec<f64>,
}

/// The gradient of one scalar L of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionGradient {
    /// One per region; density through inertia and gravity.
    pub regions: Vec<RegionGradient>,
    /// ∂L by the factor of each element's moduli, unit of L; empty where a region relaxes.
    pub elements: Vec<f64>,
    /// ∂L by g (unit of L) and τ (per s) of each relaxation branch of each region.
    pub relaxation: Vec<Vec<[f64; 2]>>,
    /// ∂L/∂α, unit of L · s.
    pub mass_damping: f64,
    /// ∂L/∂β, unit of L per s.
    pub stiffness_damping: f64,
    /// ∂L/∂p of each step (from the first) and chamber, unit of L per Pa.
    pub pressures: Vec<Vec<f64>>,
    /// ∂L by a factor of p(t), one per chamber, unit of L.
    pub pressure_gains: Vec<f64>,
    /// ∂L/∂f of dead forces, 3 entries per node, unit of L per N.
    pub forces: Vec<f64>,
    /// ∂L by the initial displacement (per m) and velocity (per m/s), 3 entries per node.
    pub initial: State,
}

impl MotionGradient {
    /// Zero.
    pub(crate) fn zero(nodes: usize, regions: usize, chambers: usize, steps: usize) -> Self {
        Self {
            regions: vec![RegionGradient::default(); regions],
            elements: Vec::new(),
            relaxation: vec![Vec::new(); regions],
            mass_damping: 0.0,
            stiffness_damping: 0.0,
            pressures: vec![vec![0.0; chambers]; steps],
            pressure_gains: vec![0.0; chambers],
            forces: vec![0.0; 3 * nodes],
            initial: State::rest(nodes),
        }
    }
}
