//! Covariance and noise model of measured displacements, and the levels with both.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2};

use diagnostics::Result;

/// Covariance of a place in the plane, m²: xx, xy, yy.
pub type Covariance2 = [f64; 3];

/// Errors beside the covariance of the markers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct NoiseModel {
    /// Standard deviation of the model discrepancy of each displacement over the level's root mean square displacement, no unit.
    pub discrepancy: f64,
    /// Its correlation length along the body, m: the model errs smoothly.
    pub correlation_length_m: Metre,
    /// Standard deviation of the common scale of all displacements of a film, no unit.
    pub scale_sigma: f64,
}

/// Candidates of each size relative to its median, and their prior: the standard deviation of the logarithm.
const SIZES: [f64; 9] = [0.1, 0.18, 0.32, 0.56, 1.0, 1.8, 3.2, 5.6, 10.0];
const DISCREPANCY_PRIOR: f64 = 1.0;
const SCALE_PRIOR: f64 = 0.5;
/// Candidates of the correlation length over the length of the body, all as likely beforehand.
const LENGTHS: [f64; 6] = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6];

/// The mean of the logarithms of a noise model under a likelihood and a prior around `median`, over a body of some length (m).
pub(crate) fn estimated(
    median: &NoiseModel,
    length: Metre,
    likelihood: &dyn Fn(&NoiseModel) -> Result<f64>,
) -> Result<NoiseModel> {
    let prior = |size: f64, sigma: f64| -0.5 * (size.ln() / sigma).powi(2);
    let mut all = Vec::new();
    for discrepancy in SIZES {
        for scale in SIZES {
            for share in LENGTHS {
                let noise = NoiseModel {
                    discrepancy: discrepancy * median.discrepancy,
                    correlation_length_m: share * length,
                    scale_sigma: scale * median.scale_sigma,
                };
                let before = prior(discrepancy, DISCREPANCY_PRIOR) + prior(scale, SCALE_PRIOR);
                all.push((likelihood(&noise)? + before, noise));
            }
        }
    }
    let most = all.iter().map(|(log, _)| *log).fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = all.iter().map(|(log, _)| (log - most).exp()).sum();
    let mean = |of: fn(&NoiseModel) -> f64| {
        (all.iter().map(|(log, noise)| (log - most).exp() / sum * of(noise).ln()).sum::<f64>()).exp()
    };
    Ok(NoiseModel {
        discrepancy: mean(|n| n.discrepancy),
        correlation_length_m: mean(|n| n.correlation_length_m),
        scale_sigma: mean(|n| n.scale_sigma),
    })
}

/// One pressure level, measured and simulated with the identified moduli.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
