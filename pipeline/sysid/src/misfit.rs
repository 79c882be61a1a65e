//! Misfit between simulated and measured displacements at each held pressure, whitened with their covariance.
//!
//! The covariance of a film's displacements has three parts: the markers' own (pixels, camera), of which the levels of a film share what
//! comes from the camera's pose and the positions at rest; a common scale of all displacements of the film (wall thickness, supply pressure);
//! and a deviation of the shape, which grows with the displacement and varies smoothly along the body and with the pressure. The size of
//! both discrepancies is estimated (`discrepancy`). Those of different films are independent, so films of both sides together determine the
//! moduli better than either alone.

use optimize::{Residuals, Whitening};
use si::{Metre, Point2};

use crate::landscape;
use crate::levels::{PressureLevel, SimulatedLevel};
use crate::noise::{Covariance2, Level, NoiseModel};
use diagnostics::{Diagnostic, Result};

/// The levels of all films, film after film.
pub struct Misfit {
    /// The levels.
    pub levels: Vec<PressureLevel>,
    /// How many of them each film has.
    films: Vec<usize>,
    whitening: Whitening,
    length: Metre,
}

impl Misfit {
    /// The misfit of levels grouped into films of the given lengths.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the covariance of a film is not positive definite.
    pub fn new(levels: Vec<PressureLevel>, films: &[usize], noise: &NoiseModel, length: Metre) -> Result<Self> {
        let whitening = whitening(&levels, films, noise)?;
        Ok(Self { levels, films: films.to_vec(), whitening, length })
    }

    /// The same levels under another noise model.
    ///
    /// # Errors
    /// As [`Misfit::new`].
    pub fn under(&self, noise: &NoiseModel) -> Result<Self> {
        Self::new(self.levels.clone(), &self.films, noise, self.length)
    }

    /// The whitening under a noise model.
    pub(crate) fn whitening_under(&self, noise: &NoiseModel) -> Result<Whitening> {
        whitening(&self.levels, &self.films, noise)
    }

    /// Residuals of the levels in m, from those that this misfit has whitened; the rows of a prior after them are left out.
    ///
    /// # Errors
    /// A [`Diagnostic`] when they are of other levels.
    pub fn raw(&self, white: &Residuals, parameters: usize) -> Result<Residuals> {
        self.whitening.invert(white, parameters).map_err(Diagnostic::from)
    }

    /// Residuals in m, whitened.
    ///
    /// # Errors
    /// As [`Misfit::raw`].
    pub fn white(&self, raw: &Residuals, parameters: usize) -> Result<Residuals> {
        self.whitening.apply(raw, parameters).map_err(Diagnostic::from)
    }

    /// The misfit of the levels in an identification record.
    ///
    /// # Errors
    /// As [`Misfit::new`].
    pub fn kept(levels: &[Level], noise: &NoiseModel, length: Metre) -> Result<Self> {
        let films: Vec<usize> = levels.chunk_by(|a, b| a.trial == b.trial).map(<[Level]>::len).collect();
        let level = |l: &Level| PressureLevel {
            pressures: l.pressures_pa.clone(),
            measured: l.measured_m.clone(),
            covariance: l.covariance_m2.clone(),
            shared: l.shared_m2.clone(),
            rest: l.rest_m.clone(),
        };
        Self::new(levels.iter().map(level).collect(), &films, noise, length)
    }

    /// Mean distance of simulated from measured displacements over the specimen's length.
    pub fn loss(&self, simulated: &[Vec<Point2>]) -> f64 {
        landscape::loss(&self.levels, simulated, self.length)
    }

    /// Whitened residuals, simulated less measured; `turns` are the derivatives of the constants by the searched parameters, in
    /// the order of the simulated sensitivities.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the simulation is of other levels.
    pub fn residuals(&self, simulated: &[SimulatedLevel], turns: &[f64]) -> Result<Residuals> {
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for (solved, level) in simulated.iter().zip(&self.levels) {
            for (m, (simulated, measured)) in solved.markers.iter().zip(&level.measured).enumerate() {
                for k in 0..2 {
                    values.push(simulated[k] - measured[k]);
                    jacobian.extend(
                        turns.iter().zip(&solved.sensitivities).map(|(turn, sensitivity)| sensitivity[m][k] * turn),
                    );
                }
            }
        }
        self.whitening.apply(&Residuals { values, jacobian }, turns.len()).map_err(Diagnostic::from)
    }

    /// χ² of simulated displacements.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the simulation is of other levels.
    pub fn chi_square(&self, simulated: &[Vec<Point2>]) -> Result<f64> {
        let pairs = simulated.iter().zip(&self.levels).flat_map(|(s, level)| s.iter().zip(&level.measured));
        let values = pairs.flat_map(|(s, m)| [s[0] - m[0], s[1] - m[1]]).collect();
        let weighed = self.whitening.apply(&Residuals { values, jacobian: Vec::new() }, 0)?;
        Ok(2.0 * weighed.half_sum_of_squares())
    }
}

fn whitening(levels: &[PressureLevel], films: &[usize], noise: &NoiseModel) -> Result<Whitening> {
    let mut first = 0;
    let blocks = films.iter().map(|&count| {
        first += count;
        covariance(&levels[first - count..first], noise)
    });
    Ok(Whitening::new(&blocks.collect::<Vec<_>>())?)
}

/// Standard deviation of what neither camera nor simulation resolves, m. It is independent, and keeps a covariance positive definite whose
/// other parts are smooth.
const RESOLUTION: Metre = 2e-6;

/// One displacement of a film.
struct Displacement<'a> {
    level: &'a PressureLevel,
    /// What the levels share, the mean over them: one positive semidefinite part of all, m².
    shared: Covariance2,
    marker: usize,
    /// 0 or 1.
    axis: usize,
}

impl Displacement<'_> {
    fn moved(&self) -> Metre {
        self.level.measured[self.marker][self.axis]
    }

    /// How far the marker moved.
    fn distance(&self) -> Metre {
        let [x, y] = self.level.measured[self.marker];
        x.hypot(y)
    }
}

/// Of one film's displacements, row after row: levels × markers × 2.
fn covariance(film: &[PressureLevel], noise: &NoiseModel) -> Vec<f64> {
    let mean =
        |marker: usize| [0, 1, 2].map(|k| film.iter().map(|l| l.shared[marker][k]).sum::<f64>() / film.len() as f64);
    let of = |level, marker| [0, 1].map(|axis| Displacement { level, shared: mean(marker), marker, axis });
    let all: Vec<Displacement> =
        film.iter().flat_map(|level| (0..level.measured.len()).flat_map(move |marker| of(level, marker))).collect();
    all.iter().flat_map(|a| all.iter().map(|b| entry(a, b, noise)).collect::<Vec<_>>()).collect()
}

fn entry(a: &Displacement, b: &Displacement, noise: &NoiseModel) -> f64 {
    // Without the common scale, which adds a rank-one term over the whole film, smooth deviations of many markers would claim far smaller
    // uncertainties than errors of wall thickness and supply pressure allow.
    own(a, b) + noise.scale_sigma.powi(2) * a.moved() * b.moved() + shape(a, b, noise)
}

/// Covariance of the markers' own errors.
fn own(a: &Displacement, b: &Displacement) -> f64 {
    if a.marker != b.marker {
        return 0.0;
    }
    let k = a.axis + b.axis;
    if !std::ptr::eq(a.level, b.level) {
        return a.shared[k];
    }
    let noise = a.level.covariance[a.marker][k] - a.level.shared[a.marker][k];
    a.shared[k] + noise + if a.axis == b.axis { RESOLUTION.powi(2) } else { 0.0 }
}

/// Covariance of the deviation of the shape: smooth along the body (Gaussian in the distance of the markers), a random walk over the
/// logarithm of the pressure (exponential).
// A deviation that is smooth over the pressure as well makes its changes between levels look certain, and with them the modulus of the sheet:
// over four drawn tails errors of the moduli had 1.9 and 1.5 stated deviations (root mean square), with the random walk 1.2 and 1.3.
fn shape(a: &Displacement, b: &Displacement, noise: &NoiseModel) -> f64 {
    if a.axis != b.axis || noise.shape_sigma == 0.0 {
        return 0.0;
    }
    let ([x, y], [u, v]) = (a.level.rest[a.marker], b.level.rest[b.marker]);
    let apart = (x - u).hypot(y - v) / noise.correlation_length_m;
    let raised = (a.level.top() / b.level.top()).ln().abs() / noise.correlation_log_pressure;
    noise.shape_sigma.powi(2) * a.distance() * b.distance() * (-0.5 * apart * apart - raised).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(moved: Point2) -> PressureLevel {
        let covariance = vec![[1e-10, 2e-11, 4e-10]];
        PressureLevel {
            pressures: vec![1.0],
            measured: vec![moved],
            covariance,
            shared: vec![[0.0; 3]],
            rest: vec![[0.0; 2]],
        }
    }

    #[test]
    fn a_common_scale_error_of_a_film_costs_little() {
        let noise = NoiseModel { scale_sigma: 0.02, ..NoiseModel::default() };
        let films = vec![level([1e-3, 5e-3]), level([2e-3, 9e-3])];
        let levels = Misfit::new(films.clone(), &[2], &noise, 0.1).unwrap();
        let off = |by: [f64; 2]| -> Vec<Vec<Point2>> {
            films.iter().zip(by).map(|(r, b)| vec![r.measured[0].map(|v| (1.0 + b) * v)]).collect()
        };
        // one standard deviation of the scale that both share
        assert!((levels.chi_square(&off([0.02, 0.02])).unwrap() - 1.0).abs() < 0.1);
        assert!(levels.chi_square(&off([0.02, -0.02])).unwrap() > 50.0);
    }

    #[test]
    fn a_markers_own_covariance_is_taken_whole() {
        let levels = Misfit::new(vec![level([0.0, 0.0])], &[1], &NoiseModel::default(), 0.1).unwrap();
        // S = [[1.04, 0.2], [0.2, 4.04]] e-10 with the resolution; r = (1e-5, 0): r S⁻¹ r = 4.04 / (1.04 · 4.04 − 0.04)
        let found = levels.chi_square(&[vec![[1e-5, 0.0]]]).unwrap();
        assert!((found - 4.04 / 4.1616).abs() < 1e-9, "{found}");
    }

    #[test]
    fn what_levels_share_is_one_error_and_not_several() {
        let own = |shared: f64| {
            let one = PressureLevel {
                covariance: vec![[1e-8, 0.0, 1e-8]],
                shared: vec![[shared, 0.0, shared]],
                ..level([0.0; 2])
            };
            let levels = Misfit::new(vec![one; 4], &[4], &NoiseModel::default(), 0.1).unwrap();
            levels.chi_square(&vec![vec![[1e-4, 0.0]]; 4]).unwrap()
        };
        assert!((own(0.0) - 4.0).abs() < 0.01 && (own(0.99e-8) - 1.0).abs() < 0.02, "{} {}", own(0.0), own(0.99e-8));
    }

    #[test]
    fn a_deviation_of_the_shape_is_smooth_along_the_body_and_over_the_pressures() {
        let noise = NoiseModel {
            shape_sigma: 0.01,
            correlation_length_m: 0.02,
            correlation_log_pressure: 1.0,
            ..NoiseModel::default()
        };
        let level = |pressure: f64| PressureLevel {
            pressures: vec![pressure],
            measured: vec![[0.0, 5e-3]; 2],
            covariance: vec![[1e-12; 3]; 2],
            shared: vec![[0.0; 3]; 2],
            rest: vec![[0.05, 0.0], [0.06, 0.0]],
        };
        let levels = Misfit::new(vec![level(1e4), level(2e4)], &[2], &noise, 0.1).unwrap();
        let off = |by: [f64; 4]| {
            let of = |k: usize| [0, 1].map(|m| [0.0, 5e-3 * (1.0 + by[2 * k + m])]).to_vec();
            levels.chi_square(&[of(0), of(1)]).unwrap()
        };
        assert!(off([0.01; 4]) < 1.5, "{}", off([0.01; 4]));
        // a pair apart by half a correlation length, and a pair of levels apart by a factor of two
        assert!(off([0.01, -0.01, 0.01, -0.01]) > 15.0 && off([0.01, 0.01, -0.01, -0.01]) > 3.0);
    }
}
