//! Covariance and noise model of measured displacements, and the levels with both.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2};

/// Covariance of a place in the plane, m²: xx, xy, yy.
pub type Covariance2 = [f64; 3];

/// Errors beside the covariance of the markers, as they weigh the levels in a search.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct NoiseModel {
    /// Standard deviation of the model discrepancy of each displacement, m.
    pub discrepancy_m: Metre,
    /// Standard deviation of the common scale of all displacements of a film, no unit.
    pub scale_sigma: f64,
}

/// One pressure level, measured and simulated with the identified moduli.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The trial it belongs to.
    pub trial: String,
    /// Measured pressures in the order of the card's chambers, Pa.
    pub pressures_pa: Vec<Pascal>,
    /// Where the markers are at rest, m.
    pub rest_m: Vec<Point2>,
    /// Measured displacements, m.
    pub measured_m: Vec<Point2>,
    /// Their covariance, m².
    pub covariance_m2: Vec<Covariance2>,
    /// The part of it that all levels of a film share, m².
    pub shared_m2: Vec<Covariance2>,
    /// Simulated displacements, m.
    pub simulated_m: Vec<Point2>,
}

impl Level {
    /// The largest distance of a simulated from a measured displacement, m.
    pub fn largest_error(&self) -> Metre {
        let distance = |(m, s): (&Point2, &Point2)| (m[0] - s[0]).hypot(m[1] - s[1]);
        self.measured_m.iter().zip(&self.simulated_m).map(distance).fold(0.0, f64::max)
    }

    /// The highest of its pressures, Pa.
    pub fn pressure(&self) -> Pascal {
        self.pressures_pa.iter().copied().fold(f64::MIN, f64::max)
    }
}
