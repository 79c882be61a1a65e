//! The discrepancy between the model and the films of held shapes, and what it leaves open of the parameters.
//!
//! Four parts: the markers' own errors (pixels, camera), of which the levels of a film share what comes from the camera's pose and the
//! positions at rest; a common scale of all displacements of a film (supply pressure, temperature), of a size that is set; a scale of each
//! chamber's films, opposed between the chambers; and a deviation of the shape, which grows with the displacement and varies smoothly along the
//! body and with the pressure. Sizes and correlations are estimated ([`Discrepancy::estimated`]).
//!
//! The chambers' scales add up to nothing: a mould fixes the outside of a body, and a core that lies off its place takes from one wall what it
//! gives to another. What one side moves too far, the other moves too little, and their mean is as the moduli say. Films of one chamber alone
//! say nothing of that, and its scale then counts whole.
//!
//! The parameters are those of a search whose weights are set ([`crate::Misfit`]), and their covariance is that of this estimator under the
//! estimated discrepancy, G S Gᵀ with G = −(JᵀWJ)⁻¹JᵀW, as of generalised estimating equations [liang1986].
// To weigh by S itself is more efficient where S is right. But where a film has a common scale of 5 %, as S then allows, the moduli
// follow from small changes of the shape alone, which are those that mesh and law get wrong: on one of three tails the modulus of the sheet went from 4 %
// to 21 % off, 3.4 stated deviations.

mod likelihood;

use std::collections::BTreeSet;

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
    /// Standard deviation of a chamber's scale, of all displacements of its films, no unit; those of all chambers add up to nothing.
    pub scale_sigma: f64,
    /// Standard deviation of the scale of a film beside it, no unit; set, not estimated.
    #[serde(default)]
    pub film_sigma: f64,
    /// Standard deviation of the deviation of the shape at a marker, over its displacement, no unit.
    pub shape_sigma: f64,
    /// Distance of markers over which that deviation is correlated, m.
    pub correlation_length_m: Metre,
    /// Logarithm of the ratio of pressures over which it is correlated, no unit.
    pub correlation_log_pressure: f64,
}

impl Discrepancy {
    /// Covariance of one film's displacements, row after row: levels × markers × 2, m².
    fn film_covariance(&self, film: &[PressureLevel]) -> Vec<f64> {
        let mean = |marker: usize| {
            [0, 1, 2].map(|k| film.iter().map(|l| l.shared[marker][k]).sum::<f64>() / film.len() as f64)
        };
        let components = |level, marker| [0, 1].map(|axis| Displacement { level, shared: mean(marker), marker, axis });
        let displacements: Vec<Displacement> = film
            .iter()
            .flat_map(|level| (0..level.measured.len()).flat_map(move |marker| components(level, marker)))
            .collect();
        displacements
            .iter()
            .flat_map(|a| displacements.iter().map(|b| self.covariance_entry(a, b)).collect::<Vec<_>>())
            .collect()
    }

    fn covariance_entry(&self, a: &Displacement, b: &Displacement) -> f64 {
        marker_covariance(a, b)
            + self.film_sigma.powi(2) * a.axis_displacement() * b.axis_displacement()
            + self.shape_covariance(a, b)
    }

    /// Covariance of the deviation of the shape: smooth along the body (Gaussian in the distance of the markers), a random walk over the
    /// logarithm of the pressure (exponential).
    fn shape_covariance(&self, a: &Displacement, b: &Displacement) -> f64 {
        if a.axis != b.axis || self.shape_sigma == 0.0 {
            return 0.0;
        }
        let ([x, y], [u, v]) = (a.level.rest[a.marker], b.level.rest[b.marker]);
        let distance_ratio = (x - u).hypot(y - v) / self.correlation_length_m;
        let raised = (a.level.top() / b.level.top()).ln().abs() / self.correlation_log_pressure;
        self.shape_sigma.powi(2) * a.distance() * b.distance() * (-0.5 * distance_ratio * distance_ratio - raised).exp()
    }

    /// By how much all displacements follow one standard deviation of each chamber's own cause, which moves the films of the other chambers
    /// the other way: chambers × displacements.
    // (δ − 1/n) n/(n − 1) is the covariance of n scales of variance one that add up to nothing, and I − 1/n is its own square.
    fn chamber_scales(&self, misfit: &Misfit) -> Vec<Vec<f64>> {
        let filled: Vec<usize> = misfit.levels.iter().map(PressureLevel::filled).collect();
        let chambers = filled.iter().copied().collect::<BTreeSet<_>>();
        let count = chambers.len() as f64;
        let (mean, size) = if count > 1.0 { (1.0 / count, (count / (count - 1.0)).sqrt()) } else { (0.0, 1.0) };
        let chamber_scale = |chamber: &usize| {
            let share = |level: usize| f64::from(u8::from(filled[level] == *chamber)) - mean;
            let displacements = misfit.levels.iter().enumerate().flat_map(|(number, level)| {
                let factor = self.scale_sigma * size * share(number);
                level.measured.iter().flatten().map(move |displacement| factor * displacement)
            });
            displacements.collect()
        };
        chambers.iter().map(chamber_scale).collect()
    }

    /// The whitening of the levels under this discrepancy.
    fn whitening(&self, misfit: &Misfit) -> Result<Whitening> {
        Ok(misfit.whitening_under(|film| self.film_covariance(film))?.with_common(&self.chamber_scales(misfit))?)
    }

    /// The covariance of the parameters of a search and χ² over the degrees of freedom, both under this discrepancy; `white` are the
    /// residuals that `misfit` has whitened at the best parameters, those of a prior behind them.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the residuals are of other levels, or do not determine the parameters.
    pub fn posterior(&self, misfit: &Misfit, white: &Residuals, parameters: usize) -> Result<(Covariance, f64)> {
        let discrepancy = self.whitening(misfit)?;
        let raw = misfit.unwhiten_residuals(white, parameters)?;
        let (level_rows, rows) = (raw.values.len(), white.values.len());
        // one standard deviation of each independent cause: the columns of a root of S, and the rows of the prior
        let unit = |k: usize, count: usize| -> Vec<f64> { (0..count).map(|i| f64::from(u8::from(i == k))).collect() };
        let level_cause = |k: usize| -> Result<Vec<f64>> {
            let column = discrepancy.invert(&Residuals { values: unit(k, level_rows), jacobian: Vec::new() }, 0)?;
            let mut whitened = misfit.whiten_residuals(&column, 0)?.values;
            whitened.resize(rows, 0.0);
            Ok(whitened)
        };
        let causes = (0..level_rows).map(level_cause).chain((level_rows..rows).map(|k| Ok(unit(k, rows))));
        let moves = causes.map(|cause| white.parameter_response(&cause?, parameters).map_err(Diagnostic::from));
        let covariance = Covariance::of_errors(parameters, &moves.collect::<Result<Vec<_>>>()?);
        let mut whitened = discrepancy.apply(&raw, parameters)?;
        whitened.values.extend(&white.values[level_rows..]);
        Ok((covariance, whitened.reduced_chi_square(parameters)))
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
    fn axis_displacement(&self) -> Metre {
        self.level.measured[self.marker][self.axis]
    }

    /// How far the marker moved.
    fn distance(&self) -> Metre {
        let [x, y] = self.level.measured[self.marker];
        x.hypot(y)
    }
}

/// Covariance of the markers' own errors.
fn marker_covariance(a: &Displacement, b: &Displacement) -> f64 {
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

    /// Two levels of each of two chambers, of one film each.
    fn sides() -> Misfit {
        let of = |(side, p): (f64, f64)| PressureLevel {
            pressures: if side > 0.0 { vec![p, 0.0] } else { vec![0.0, p] },
            ..level(p, [0.0, 3e-7 * side * p], 0.0)
        };
        let all = [(1.0, 5e3), (1.0, 1e4), (-1.0, 5e3), (-1.0, 1e4)].map(of).to_vec();
        Misfit::new(all, &[2, 2], &NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.0 }, 0.1).unwrap()
    }

    #[test]
    fn opposed_scales_leave_a_parameter_that_scales_all() {
        let levels = sides();
        let jacobian: Vec<f64> = levels.levels.iter().flat_map(|l| l.measured.iter().flatten().copied()).collect();
        let white = levels.whiten_residuals(&Residuals { values: vec![0.0; jacobian.len()], jacobian }, 1).unwrap();
        let variance = |of: &Discrepancy| of.posterior(&levels, &white, 1).unwrap().0.of(0, 0);
        let none = variance(&SMOOTH);
        let opposed = variance(&Discrepancy { scale_sigma: 0.04, ..SMOOTH });
        assert!((opposed / none - 1.0).abs() < 1e-6, "{opposed:e} {none:e}");
        // of two independent films the mean has half the variance
        let films = variance(&Discrepancy { film_sigma: 0.04, ..SMOOTH });
        assert!(((films - none) / 0.0008 - 1.0).abs() < 1e-6, "{films:e}");
    }

    #[test]
    fn what_one_side_moves_too_far_and_the_other_too_little_is_one_error() {
        let (levels, truth) = (sides(), Discrepancy { scale_sigma: 0.05, ..SMOOTH });
        let off = |by: [f64; 4]| {
            let scaled =
                levels.levels.iter().zip(by).flat_map(|(l, b)| l.measured.iter().flatten().map(move |m| b * m));
            chi_square(&levels, &truth, scaled.collect())
        };
        let [opposed, alike] = [off([0.05, 0.05, -0.05, -0.05]), off([0.05; 4])];
        assert!(opposed < 1.2 && alike > 10.0 * opposed, "{opposed} {alike}");
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

    const SMOOTH: Discrepancy = Discrepancy {
        scale_sigma: 0.0,
        film_sigma: 0.0,
        shape_sigma: 0.01,
        correlation_length_m: 0.02,
        correlation_log_pressure: 1.0,
    };

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
            let values = (0..jacobian.len()).map(|_| likelihood::testing::draw_normal(draw)).collect();
            let drawn =
                truth.whitening(&levels).unwrap().invert(&Residuals { values, jacobian: Vec::new() }, 0).unwrap();
            let white = levels.whiten_residuals(&Residuals { jacobian: jacobian.clone(), ..drawn }, 1).unwrap();
            (white.parameter_response(&white.values, 1).unwrap()[0], white)
        };
        let (_, white) = estimate(&mut draw);
        let (covariance, _) = truth.posterior(&levels, &white, 1).unwrap();
        let square: f64 = (0..4000).map(|_| estimate(&mut draw).0.powi(2)).sum();
        let scatter = (square / 4000.0).sqrt();
        assert!((covariance.sigma(0) / scatter - 1.0).abs() < 0.05, "{} {scatter}", covariance.sigma(0));
    }
}
