//! The discrepancy between the model and the films of held shapes, and what it leaves open of the parameters.
//!
//! Three parts: the markers' own errors (pixels, camera), of which the levels of a film share what comes from the camera's pose and the
//! positions at rest; a common scale of all displacements of a film (wall thickness, supply pressure); and a deviation of the shape, which
//! grows with the displacement and varies smoothly along the body and with the pressure. Sizes and correlations are estimated
//! ([`Discrepancy::estimated`]). Discrepancies of different films are independent.
//!
//! The parameters are those of a search whose weights are set ([`crate::Misfit`]), and their covariance is that of this estimator under the
//! estimated discrepancy, G S Gᵀ with G = −(JᵀWJ)⁻¹JᵀW, as of generalised estimating equations [liang1986].
// To weigh by S itself is more efficient where S is right. But where a film has a common scale of 5 %, as S then allows, the moduli
// follow from small changes of the shape alone, which are those that mesh and law get wrong: on one of three tails the modulus of the sheet went from 4 %
// to 21 % off, 3.4 stated deviations.

mod likelihood;

use optimize::{Covariance, Residuals, Whitening};
use serde::{Deserialize, Serialize};
use si::Metre;

use crate::levels::PressureLevel;
use crate::misfit::Misfit;
use crate::noise::Covariance2;
use diagnostics::{Diagnostic, Result};

/// Sizes and correlations of the discrepancy. It grows with the displacement: a model that is at rest where the body is at rest errs by a
/// share of what moves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Discrepancy {
    /// Standard deviation of the common scale of all displacements of a film, no unit.
    pub scale_sigma: f64,
    /// Standard deviation of the deviation of the shape at a marker, over its displacement, no unit.
    pub shape_sigma: f64,
    /// Distance of markers over which that deviation is correlated, m.
    pub correlation_length_m: Metre,
    /// Logarithm of the ratio of pressures over which it is correlated, no unit.
    pub correlation_log_pressure: f64,
}

impl Discrepancy {
    /// Covariance of one film's displacements, row after row: levels × markers × 2, m².
    fn covariance(&self, film: &[PressureLevel]) -> Vec<f64> {
        let mean = |marker: usize| {
            [0, 1, 2].map(|k| film.iter().map(|l| l.shared[marker][k]).sum::<f64>() / film.len() as f64)
        };
        let of = |level, marker| [0, 1].map(|axis| Displacement { level, shared: mean(marker), marker, axis });
        let all: Vec<Displacement> =
            film.iter().flat_map(|level| (0..level.measured.len()).flat_map(move |marker| of(level, marker))).collect();
        all.iter().flat_map(|a| all.iter().map(|b| self.entry(a, b)).collect::<Vec<_>>()).collect()
    }

    fn entry(&self, a: &Displacement, b: &Displacement) -> f64 {
        own(a, b) + self.scale_sigma.powi(2) * a.moved() * b.moved() + self.shape(a, b)
    }

    /// Covariance of the deviation of the shape: smooth along the body (Gaussian in the distance of the markers), a random walk over the
    /// logarithm of the pressure (exponential).
    fn shape(&self, a: &Displacement, b: &Displacement) -> f64 {
        if a.axis != b.axis || self.shape_sigma == 0.0 {
            return 0.0;
        }
        let ([x, y], [u, v]) = (a.level.rest[a.marker], b.level.rest[b.marker]);
        let apart = (x - u).hypot(y - v) / self.correlation_length_m;
        let raised = (a.level.top() / b.level.top()).ln().abs() / self.correlation_log_pressure;
        self.shape_sigma.powi(2) * a.distance() * b.distance() * (-0.5 * apart * apart - raised).exp()
    }

    /// The whitening of the levels under this discrepancy.
    fn whitening(&self, misfit: &Misfit) -> Result<Whitening> {
        misfit.under(|film| self.covariance(film))
    }

    /// The covariance of the parameters of a search and χ² over the degrees of freedom, both under this discrepancy; `white` are the
    /// residuals that `misfit` has whitened at the best parameters, those of a prior behind them.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the residuals are of other levels, or do not determine the parameters.
    pub fn posterior(&self, misfit: &Misfit, white: &Residuals, parameters: usize) -> Result<(Covariance, f64)> {
        let discrepancy = self.whitening(misfit)?;
        let raw = misfit.raw(white, parameters)?;
        let (levels, all) = (raw.values.len(), white.values.len());
        // one standard deviation of each independent cause: the columns of L of S = L Lᵀ, and the rows of the prior
        let unit = |k: usize, of: usize| -> Vec<f64> { (0..of).map(|i| f64::from(u8::from(i == k))).collect() };
        let of_level = |k: usize| -> Result<Vec<f64>> {
            let column = discrepancy.invert(&Residuals { values: unit(k, levels), jacobian: Vec::new() }, 0)?;
            let mut seen = misfit.white(&column, 0)?.values;
            seen.resize(all, 0.0);
            Ok(seen)
        };
        let causes = (0..levels).map(of_level).chain((levels..all).map(|k| Ok(unit(k, all))));
        let moves = causes.map(|cause| white.response(&cause?, parameters).map_err(Diagnostic::from));
        let covariance = Covariance::of_errors(parameters, &moves.collect::<Result<Vec<_>>>()?);
        let mut seen = discrepancy.apply(&raw, parameters)?;
        seen.values.extend(&white.values[levels..]);
        Ok((covariance, seen.reduced_chi_square(parameters)))
    }

    /// By how much the parameters of a search follow one standard deviation of the common scale of each film: films × parameters, in the
    /// order of the films, of the same search as [`Discrepancy::posterior`].
    ///
    /// # Errors
    /// As [`Discrepancy::posterior`].
    pub fn scales(&self, misfit: &Misfit, white: &Residuals, parameters: usize) -> Result<Vec<Vec<f64>>> {
        let of_film = |levels: std::ops::Range<usize>| -> Result<Vec<f64>> {
            let larger = |(number, level): (usize, &PressureLevel)| {
                let sigma = if levels.contains(&number) { self.scale_sigma } else { 0.0 };
                level.measured.iter().flatten().map(move |moved| -sigma * moved).collect::<Vec<f64>>()
            };
            let values = misfit.levels.iter().enumerate().flat_map(larger).collect();
            let mut seen = misfit.white(&Residuals { values, jacobian: Vec::new() }, 0)?.values;
            seen.resize(white.values.len(), 0.0);
            Ok(white.response(&seen, parameters)?)
        };
        misfit.films().map(of_film).collect()
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::NoiseModel;

    fn level(pressure: f64, moved: [f64; 2], shared: f64) -> PressureLevel {
        PressureLevel {
            pressures: vec![pressure],
            measured: vec![moved; 2],
            covariance: vec![[1e-8, 0.0, 1e-8]; 2],
            shared: vec![[shared, 0.0, shared]; 2],
            rest: vec![[0.05, 0.0], [0.06, 0.0]],
        }
    }

    fn misfit(levels: Vec<PressureLevel>) -> Misfit {
        let films = [levels.len()];
        Misfit::new(levels, &films, &NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.01 }, 0.1).unwrap()
    }

    #[test]
    fn a_parameter_that_scales_all_follows_the_scale_of_each_film_by_its_share() {
        let all = [5e3, 1e4, 5e3, 1e4].map(|p| level(p, [0.0, 3e-7 * p], 0.0)).to_vec();
        let jacobian: Vec<f64> = all.iter().flat_map(|l| l.measured.iter().flatten().copied()).collect();
        let levels = Misfit::new(all, &[2, 2], &NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.0 }, 0.1).unwrap();
        let white = levels.white(&Residuals { values: vec![0.0; jacobian.len()], jacobian }, 1).unwrap();
        let truth = Discrepancy { scale_sigma: 0.04, ..SMOOTH };
        let found = truth.scales(&levels, &white, 1).unwrap();
        assert!(found.len() == 2 && found.iter().all(|film| (film[0] - 0.02).abs() < 1e-12), "{found:?}");
        // what they leave of the covariance is that of the other causes
        let variance = |of: &Discrepancy| of.posterior(&levels, &white, 1).unwrap().0.of(0, 0);
        let others = variance(&Discrepancy { scale_sigma: 0.0, ..truth });
        let sum: f64 = found.iter().map(|film| film[0].powi(2)).sum();
        assert!((variance(&truth) / (others + sum) - 1.0).abs() < 1e-9);
    }

    /// χ² under a discrepancy of residuals in m.
    fn chi_square(misfit: &Misfit, discrepancy: &Discrepancy, values: Vec<f64>) -> f64 {
        let white =
            discrepancy.whitening(misfit).unwrap().apply(&Residuals { values, jacobian: Vec::new() }, 0).unwrap();
        2.0 * white.half_sum_of_squares()
    }

    #[test]
    fn what_levels_share_is_one_error_and_not_several() {
        let own = |shared: f64| {
            let levels = misfit(vec![level(1e4, [0.0; 2], shared); 4]);
            let values = [1e-4, 0.0, 0.0, 0.0].repeat(4);
            chi_square(&levels, &Discrepancy::default(), values)
        };
        assert!((own(0.0) - 4.0).abs() < 0.01 && (own(0.99e-8) - 1.0).abs() < 0.02, "{} {}", own(0.0), own(0.99e-8));
    }

    const SMOOTH: Discrepancy =
        Discrepancy { scale_sigma: 0.0, shape_sigma: 0.01, correlation_length_m: 0.02, correlation_log_pressure: 1.0 };

    #[test]
    fn a_deviation_of_the_shape_is_smooth_along_the_body_and_over_the_pressures() {
        let mut levels = vec![level(1e4, [0.0, 5e-3], 0.0), level(2e4, [0.0, 5e-3], 0.0)];
        levels.iter_mut().for_each(|l| l.covariance = vec![[1e-12, 0.0, 1e-12]; 2]);
        let levels = misfit(levels);
        let off = |by: [f64; 4]| chi_square(&levels, &SMOOTH, by.iter().flat_map(|b| [0.0, 5e-3 * b]).collect());
        assert!(off([0.01; 4]) < 1.5, "{}", off([0.01; 4]));
        // a pair apart by half a correlation length, and a pair of levels apart by a factor of two
        assert!(off([0.01, -0.01, 0.01, -0.01]) > 15.0 && off([0.01, 0.01, -0.01, -0.01]) > 3.0);
    }

    #[test]
    fn the_covariance_is_that_of_the_estimates_of_drawn_residuals() {
        use rand_chacha::ChaCha8Rng;
        use rand_chacha::rand_core::SeedableRng;
        let levels = misfit([5e3, 1e4, 1.5e4, 2e4].map(|p| level(p, [1e-8 * p, 3e-7 * p], 2e-9)).to_vec());
        let truth = Discrepancy { scale_sigma: 0.03, ..SMOOTH };
        let jacobian: Vec<f64> = levels.levels.iter().flat_map(|l| l.measured.iter().flatten().copied()).collect();
        let mut draw = ChaCha8Rng::seed_from_u64(7);
        let estimate = |draw: &mut ChaCha8Rng| {
            let values = (0..jacobian.len()).map(|_| likelihood::testing::normal(draw)).collect();
            let drawn =
                truth.whitening(&levels).unwrap().invert(&Residuals { values, jacobian: Vec::new() }, 0).unwrap();
            let white = levels.white(&Residuals { jacobian: jacobian.clone(), ..drawn }, 1).unwrap();
            (white.response(&white.values, 1).unwrap()[0], white)
        };
        let (_, white) = estimate(&mut draw);
        let (covariance, _) = truth.posterior(&levels, &white, 1).unwrap();
        let square: f64 = (0..4000).map(|_| estimate(&mut draw).0.powi(2)).sum();
        let scatter = (square / 4000.0).sqrt();
        assert!((covariance.sigma(0) / scatter - 1.0).abs() < 0.05, "{} {scatter}", covariance.sigma(0));
    }
}
