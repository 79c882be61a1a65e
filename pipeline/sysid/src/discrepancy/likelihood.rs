//! Sizes and correlations of the discrepancy by restricted maximum likelihood [patterson1971].
//!
//! The moduli follow the part of a discrepancy that looks like a change of modulus, so that residuals at the best moduli are smaller than the
//! discrepancy. The restricted likelihood is that of the combinations of residuals that do not depend on the parameters:
//!
//!   −2 ln L = rᵀ P r + ln det S + ln det (Jᵀ S⁻¹ J),  P = S⁻¹ − S⁻¹ J (Jᵀ S⁻¹ J)⁻¹ Jᵀ S⁻¹.
//!
//! Few films determine four numbers loosely: normal priors of their logarithms, about the settings, hold what they leave open.

use nalgebra::{DMatrix, DVector};
use optimize::optimisers::{self, cma_es};
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals};

use super::Discrepancy;
use crate::misfit::Misfit;
use diagnostics::{Diagnostic, Result};

/// Standard deviations of the logarithms of scale, shape, correlation length and correlation of pressures: sizes are known to a factor of
/// three, lengths to one of two.
const PRIOR: [f64; 4] = [1.0, 1.0, 0.7, 0.7];
/// The search ends at so many deviations.
const WIDTH: f64 = 4.0;
/// Convergence of the search in units of its width: a hundredth of a deviation.
const TOLERANCE: f64 = 1e-3;

const NAMES: [&str; 4] = ["scale", "shape", "correlation length", "correlation of pressures"];

impl Discrepancy {
    fn log_values(&self) -> [f64; 4] {
        [self.scale_sigma, self.shape_sigma, self.correlation_length_m, self.correlation_log_pressure].map(f64::ln)
    }

    /// With each number by a factor, whose logarithms are given in deviations of the prior.
    fn scaled_by(&self, deviations: &[f64]) -> Self {
        let factor = |k: usize| (PRIOR[k] * deviations[k]).exp();
        Self {
            scale_sigma: self.scale_sigma * factor(0),
            film_sigma: self.film_sigma,
            shape_sigma: self.shape_sigma * factor(1),
            correlation_length_m: self.correlation_length_m * factor(2),
            correlation_log_pressure: self.correlation_log_pressure * factor(3),
        }
    }

    /// That of the greatest restricted posterior, from the residuals that `misfit` has whitened at the best parameters; `prior` is the middle
    /// of its prior. Rows after those of the levels are a prior of the parameters.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the residuals are of other levels, a number of the prior is not positive, or they do not depend on some
    /// direction of the parameters.
    pub fn estimated(misfit: &Misfit, white: &Residuals, parameters: usize, prior: &Self) -> Result<Self> {
        if prior.log_values().iter().any(|x| !x.is_finite()) {
            let action = "give the numbers of [identify] that begin with prior_ above zero";
            return Err(Diagnostic::new(
                "the discrepancy of the films cannot be estimated",
                "a size or a length is not positive",
                action,
            ));
        }
        let raw = misfit.unwhiten_residuals(white, parameters)?;
        let rows = raw.values.len();
        let of_prior =
            Residuals { values: white.values[rows..].to_vec(), jacobian: white.jacobian[rows * parameters..].to_vec() };
        let loss = |deviations: &[f64]| -> f64 {
            let fit = negative_log_likelihood(misfit, (&raw, &of_prior), parameters, &prior.scaled_by(deviations));
            fit.unwrap_or(f64::INFINITY) + 0.5 * deviations.iter().map(|x| x * x).sum::<f64>()
        };
        let best = minimise_loss(&loss)?;
        Ok(prior.scaled_by(&best))
    }
}

/// −ln of the restricted likelihood; none where S or JᵀS⁻¹J is singular.
fn negative_log_likelihood(
    misfit: &Misfit,
    (raw, of_prior): (&Residuals, &Residuals),
    parameters: usize,
    noise: &Discrepancy,
) -> Option<f64> {
    let whitening = noise.whitening(misfit).ok()?;
    let mut white = whitening.apply(raw, parameters).ok()?;
    // With the prior's rows the information stays regular along a parameter that the films do not determine.
    white.values.extend(&of_prior.values);
    white.jacobian.extend(&of_prior.jacobian);
    let jacobian = DMatrix::from_row_slice(white.values.len(), parameters, &white.jacobian);
    let values = DVector::from_column_slice(&white.values);
    let information = jacobian.tr_mul(&jacobian).cholesky()?;
    let projected = jacobian.tr_mul(&values);
    let explained = projected.dot(&information.solve(&projected));
    let half_log_information: f64 = information.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
    Some(0.5 * (values.dot(&values) - explained) + whitening.half_log_determinant() + half_log_information)
}

/// The point of the least loss, in deviations of the prior. CMA-ES, because the likelihood has no derivative at hand and may be flat.
fn minimise_loss(loss: &dyn Fn(&[f64]) -> f64) -> Result<Vec<f64>> {
    let bounds = Bounds { low: vec![-WIDTH; NAMES.len()], high: vec![WIDTH; NAMES.len()] };
    let problem = Problem::new(&NAMES, vec![0.0; NAMES.len()], bounds)?;
    let settings = cma_es::Settings { step: 0.1, step_tolerance: TOLERANCE, ..cma_es::Settings::default() };
    let mut search = optimisers::cma_es::CmaEs::new(&problem, &settings)?;
    let mut evaluate = |batch: &[Vec<f64>], _: Needs| -> std::result::Result<Vec<Evaluation>, OptimiseError> {
        Ok(batch.iter().map(|point| Evaluation::of_loss(point.clone(), loss(point))).collect())
    };
    Ok(optimize::minimise(&mut search, &mut evaluate)?.best.at)
}

#[cfg(test)]
pub(super) mod testing {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::Rng;

    /// A normal number.
    pub(crate) fn draw_normal(draw: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| f64::from(draw.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::PressureLevel;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::testing::draw_normal;
    use crate::noise::NoiseModel;

    const MARKERS: usize = 6;

    /// Two films of four levels: markers along a body that bends in proportion to the pressure.
    fn levels() -> Vec<PressureLevel> {
        let place = |m: usize| 0.02 + 0.01 * m as f64;
        let level = |pressure: f64, side: f64| PressureLevel {
            pressures: if side > 0.0 { vec![pressure, 0.0] } else { vec![0.0, pressure] },
            measured: (0..MARKERS).map(|m| [0.0, side * pressure * 1e-4 * place(m).powi(2)]).collect(),
            covariance: vec![[1e-10, 0.0, 1e-10]; MARKERS],
            shared: vec![[5e-11, 0.0, 5e-11]; MARKERS],
            rest: (0..MARKERS).map(|m| [place(m), 0.0]).collect(),
        };
        [1.0, -1.0].iter().flat_map(|side| [5e3, 1e4, 1.5e4, 2e4].map(|p| level(p, *side))).collect()
    }

    /// Residuals drawn under `truth`, whitened as a misfit does; one parameter scales all.
    fn drawn(truth: &Discrepancy, seed: u64) -> (Misfit, Residuals) {
        let (levels, mut draw) = (levels(), ChaCha8Rng::seed_from_u64(seed));
        let jacobian: Vec<f64> = levels.iter().flat_map(|l| l.measured.iter().flatten().copied()).collect();
        let noise = NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.01 };
        let misfit = Misfit::new(levels, &[4, 4], &noise, 0.1).unwrap();
        let values = (0..jacobian.len()).map(|_| draw_normal(&mut draw)).collect();
        let raw = truth.whitening(&misfit).unwrap().invert(&Residuals { values, jacobian: Vec::new() }, 0).unwrap();
        let white = misfit.whiten_residuals(&Residuals { jacobian, ..raw }, 1).unwrap();
        (misfit, white)
    }

    #[test]
    fn the_sizes_by_which_residuals_were_drawn_come_back() {
        let truth = Discrepancy {
            scale_sigma: 0.03,
            film_sigma: 0.01,
            shape_sigma: 0.004,
            correlation_length_m: 0.015,
            correlation_log_pressure: 0.6,
        };
        let prior = Discrepancy {
            scale_sigma: 0.02,
            film_sigma: 0.01,
            shape_sigma: 0.01,
            correlation_length_m: 0.025,
            correlation_log_pressure: 1.0,
        };
        let found: Vec<Discrepancy> = (0..12)
            .map(|seed| {
                let (misfit, white) = drawn(&truth, seed);
                Discrepancy::estimated(&misfit, &white, 1, &prior).unwrap()
            })
            .collect();
        let mean = |of: &dyn Fn(&Discrepancy) -> f64| (found.iter().map(|n| of(n).ln()).sum::<f64>() / 12.0).exp();
        // two films show one difference of their scales, and the prior holds the rest of what it leaves open
        let (scale, shape, length) =
            (mean(&|n| n.scale_sigma), mean(&|n| n.shape_sigma), mean(&|n| n.correlation_length_m));
        assert!((0.015..0.04).contains(&scale), "{scale}");
        assert!((shape / 0.004).ln().abs() < 0.3, "{shape}");
        assert!((length / 0.015).ln().abs() < 0.3, "{length}");
    }

    #[test]
    fn a_size_of_zero_is_refused_with_its_setting() {
        let prior = Discrepancy {
            scale_sigma: 0.02,
            film_sigma: 0.01,
            shape_sigma: 0.01,
            correlation_length_m: 0.025,
            correlation_log_pressure: 1.0,
        };
        let (misfit, white) = drawn(&prior, 1);
        let refused = Discrepancy::estimated(&misfit, &white, 1, &Discrepancy { shape_sigma: 0.0, ..prior })
            .unwrap_err()
            .to_string();
        assert!(refused.contains("prior_"), "{refused}");
    }
}
