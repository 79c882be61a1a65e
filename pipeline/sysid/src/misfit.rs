//! Misfit between simulated and measured displacements at each held pressure, whitened with their covariance.
//!
//! The covariance of a film's displacements has three parts: the markers' own (pixels, camera), the model discrepancy at
//! each marker, and a common scale error of all displacements of a film (wall thickness, supply pressure). The
//! scale errors of films are independent, so films of both sides together determine the moduli better than either alone. These are the
//! weights of a search; how uncertain its result is follows from the discrepancy that its residuals show (`discrepancy`).

use optimize::{Residuals, Whitening};
use si::{Metre, Point2};

use crate::landscape;
use crate::levels::{PressureLevel, SimulatedLevel};
use crate::noise::{Level, NoiseModel};
use diagnostics::{Diagnostic, Result};

/// The levels of all films, film after film.
pub struct Misfit {
    /// The levels.
    pub levels: Vec<PressureLevel>,
    /// How many of them each film has.
    films: Vec<usize>,
    whitening: Whitening,
    length: Metre,
    /// Standard deviation of the discrepancy by which each displacement was weighed, m.
    discrepancy: Metre,
}

impl Misfit {
    /// The misfit of levels grouped into films of the given lengths.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the covariance of a film is not positive definite.
    pub fn new(levels: Vec<PressureLevel>, films: &[usize], noise: &NoiseModel, length: Metre) -> Result<Self> {
        let whitening = film_whitening(&levels, films, |film| film_covariance(film, noise))?;
        Ok(Self { levels, films: films.to_vec(), whitening, length, discrepancy: noise.discrepancy_m })
    }

    /// Standard deviation of the discrepancy by which each displacement is weighed, m.
    pub(crate) fn discrepancy(&self) -> Metre {
        self.discrepancy
    }

    /// The whitening of the levels under another covariance of each film's displacements.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it is not positive definite.
    pub(crate) fn whitening_under(&self, covariance: impl Fn(&[PressureLevel]) -> Vec<f64>) -> Result<Whitening> {
        film_whitening(&self.levels, &self.films, covariance)
    }

    /// Residuals of the levels in m, from those that this misfit has whitened; the rows of a prior after them are left out.
    ///
    /// # Errors
    /// A [`Diagnostic`] when they are of other levels.
    pub(crate) fn unwhiten_residuals(&self, white: &Residuals, parameters: usize) -> Result<Residuals> {
        self.whitening.invert(white, parameters).map_err(Diagnostic::from)
    }

    /// Residuals in m, whitened.
    ///
    /// # Errors
    /// As [`Misfit::unwhiten_residuals`].
    pub(crate) fn whiten_residuals(&self, raw: &Residuals, parameters: usize) -> Result<Residuals> {
        self.whitening.apply(raw, parameters).map_err(Diagnostic::from)
    }

    /// The misfit of the levels in an identification record.
    ///
    /// # Errors
    /// As [`Misfit::new`].
    pub fn of_record(levels: &[Level], noise: &NoiseModel, length: Metre) -> Result<Self> {
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

/// From the covariance of each film.
fn film_whitening(
    levels: &[PressureLevel],
    films: &[usize],
    covariance: impl Fn(&[PressureLevel]) -> Vec<f64>,
) -> Result<Whitening> {
    let mut first = 0;
    let blocks = films.iter().map(|&count| {
        first += count;
        covariance(&levels[first - count..first])
    });
    Ok(Whitening::new(&blocks.collect::<Vec<_>>())?)
}

/// Of one film's displacements, row after row: levels × markers × 2.
fn film_covariance(film: &[PressureLevel], noise: &NoiseModel) -> Vec<f64> {
    let displacements: Vec<f64> = film.iter().flat_map(|r| r.measured.iter().flat_map(|p| *p)).collect();
    let covariance: Vec<[f64; 3]> = film.iter().flat_map(|r| r.covariance.iter().copied()).collect();
    let marker_covariance = |i: usize, j: usize| match (i / 2 == j / 2, i % 2, j % 2) {
        (false, ..) => 0.0,
        (_, 0, 0) => covariance[i / 2][0] + noise.discrepancy_m.powi(2),
        (_, 1, 1) => covariance[i / 2][2] + noise.discrepancy_m.powi(2),
        _ => covariance[i / 2][1],
    };
    // The common scale adds a rank-one term over the whole film. Without it, independent noise of many markers would claim far smaller
    // uncertainties than errors of wall thickness and supply pressure allow.
    let entry =
        |i: usize, j: usize| marker_covariance(i, j) + noise.scale_sigma.powi(2) * displacements[i] * displacements[j];
    (0..displacements.len())
        .flat_map(|i| (0..displacements.len()).map(move |j| (i, j)))
        .map(|(i, j)| entry(i, j))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(moved: Point2) -> PressureLevel {
        PressureLevel {
            pressures: vec![1.0],
            measured: vec![moved],
            covariance: vec![[1e-10, 2e-11, 4e-10]],
            shared: vec![[0.0; 3]],
            rest: vec![[0.0; 2]],
        }
    }

    #[test]
    fn a_common_scale_error_of_a_film_costs_little() {
        let noise = NoiseModel { discrepancy_m: 1e-5, scale_sigma: 0.02 };
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
        let noise = NoiseModel { discrepancy_m: 1e-5, scale_sigma: 0.0 };
        let levels = Misfit::new(vec![level([0.0, 0.0])], &[1], &noise, 0.1).unwrap();
        // S = [[2, 0.2], [0.2, 5]] e-10; r = (1e-5, 0): r S⁻¹ r = 5 / (10 − 0.04)
        let found = levels.chi_square(&[vec![[1e-5, 0.0]]]).unwrap();
        assert!((found - 5.0 / 9.96).abs() < 1e-9, "{found}");
    }
}
