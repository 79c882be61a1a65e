//! Pressure levels, measured and simulated.

use si::{Pascal, Point2};

use crate::noise::Covariance2;
use crate::surrogate::Slope;

/// One pressure level and the measured displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureLevel {
    /// One pressure a chamber, Pa.
    pub pressures: Vec<Pascal>,
    /// Displacement of each marker in the plane, m.
    pub measured: Vec<Point2>,
    /// Their covariance, m².
    pub covariance: Vec<Covariance2>,
    /// The part of it that all levels of a film share: pose of the camera, position at rest; m².
    pub shared: Vec<Covariance2>,
    /// Positions of the markers at rest, m.
    pub rest: Vec<Point2>,
}

impl PressureLevel {
    /// The highest of its pressures, Pa.
    pub fn top(&self) -> Pascal {
        self.pressures.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The same measurement under `factor` times the pressures.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let pressures = self.pressures.iter().map(|pressure| factor * pressure).collect();
        Self { pressures, ..self.clone() }
    }

    /// The chamber with that pressure.
    pub(crate) fn filled(&self) -> usize {
        let order = |a: &usize, b: &usize| self.pressures[*a].total_cmp(&self.pressures[*b]);
        (0..self.pressures.len()).max_by(order).unwrap_or(0)
    }
}

/// One level, simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedLevel {
    /// Displacement of each marker in the plane, m.
    pub markers: Vec<Point2>,
    /// ∂(mean distance)/∂E of each solid of this level's part of the loss, m/Pa; empty unless requested.
    pub gradient: Vec<f64>,
    /// d(marker displacement)/dθ: for E of each solid (m/Pa), then, when requested, ν of each or both ratios of stiffening (m); each
    /// markers × 2.
    pub sensitivities: Vec<Vec<Point2>>,
    /// Displacement of every node, m, 3 a node.
    pub displacement: Vec<f64>,
    /// The shape in the unknowns that were solved for.
    pub(crate) shape: Vec<f64>,
    /// Its derivatives by the coordinates of its load; empty unless sensitivities were requested.
    pub(crate) slopes: Vec<Slope>,
    /// Time of the equilibrium, s.
    pub forward_seconds: f64,
    /// Time of gradient or sensitivities on top of it, s.
    pub derivative_seconds: f64,
}

/// Derivatives to compute beside the displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derivatives {
    /// None.
    None,
    /// The adjoint gradient of the mean distance.
    Gradient,
    /// Forward sensitivities of every marker to the moduli.
    Sensitivities,
    /// To the moduli and the Poisson's ratios.
    AllSensitivities,
    /// To the moduli and both ratios of stiffening of the softest solid.
    StiffeningSensitivities,
}

/// What is added to a level that a reduced model simulates.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct LevelCorrection {
    /// To the displacement of each marker, m.
    pub markers: Vec<Point2>,
    /// To its derivatives by the parameters, the moduli first; those of further parameters stay as they are.
    pub sensitivities: Vec<Vec<Point2>>,
}
