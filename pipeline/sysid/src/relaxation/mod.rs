//! Identification of a relaxation spectrum from the transients of films.
//!
//! After each change of its command a body vibrates, then creeps while the pressure is held, or recovers while it is not. All of it is
//! simulated in reduced coordinates with a generalised Maxwell model: relaxation times are given, and Gauss-Newton identifies the logarithms
//! of the strengths under a wide prior, first at a few knots with branches interpolated between them, then of every branch. The moduli belong to a stated time after loading, so that every spectrum that is tried gives the
//! same held shapes: residuals are taken about their mean, and to the best scale, in each window between two changes.

mod film;
mod identified;
mod spectrum;

pub use film::{Film, Footage, Transient, Window};
pub use identified::{IdentifiedBranch, IdentifiedSpectrum, dynamic_modulus};

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use optimize::optimisers::gauss_newton::{GaussNewton, Settings as Newton};
use optimize::posterior::integrated_correlation;
use optimize::{Bounds, Evaluation, Needs, Optimiser, Problem, Residuals};
use rayon::prelude::*;
use si::{Metre, Second};

use crate::model::{Elastic, Model, Viscoelastic};
use crate::reduced::ReducedBody;
use crate::search::Interrupted;
use crate::stiffening::residuals_of;
use diagnostics::{Diagnostic, Result};
use fem::{Branch, Relaxation};
use spectrum::Knots;

/// How a spectrum is sought.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumSettings {
    /// Relaxation times of the knots, rising, s.
    pub times: Vec<Second>,
    /// Branches from one knot to the next, at least one.
    pub branches_per_interval: usize,
    /// Median of the prior of each strength, no unit.
    pub prior_strength: f64,
    /// Standard deviation of its logarithm.
    pub prior_sigma: f64,
    /// Standard deviation of a marker's position before that of the discrepancy is estimated, m.
    pub sigma: Metre,
    /// Iterations of Gauss-Newton at most.
    pub iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    pub step_tolerance: f64,
}

/// A body and the films of its transients.
#[derive(Clone)]
pub struct SpectrumProblem<'a> {
    /// How it is sought.
    pub settings: &'a SpectrumSettings,
    /// The whole model.
    pub model: &'a Model,
    /// The same in reduced coordinates.
    pub reduced: &'a ReducedBody,
    /// Its constants `modulus_time` after loading.
    pub held: Elastic,
    /// s.
    pub modulus_time: Second,
    /// At least one.
    pub films: &'a [Film],
}

/// An identified spectrum and what it leaves of the films.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The spectrum.
    pub spectrum: IdentifiedSpectrum,
    /// Root mean square error of all windows, each about its mean, m.
    pub rmse: Metre,
    /// The same of the elastic model, m.
    pub elastic_rmse: Metre,
    /// Correlation time of the residuals, s.
    pub correlation_time: Second,
    /// The windows of the first film.
    pub transients: Vec<Transient>,
}

/// Step of the finite difference, in the logarithm.
const NUDGE: f64 = 0.03;
/// Iterations after the weights have changed and the branches are free: the search at the knots has come close.
const REWEIGHTED: usize = 2;
/// Bounds of a strength.
const BOUNDS: [f64; 2] = [1e-4, 2.0];

fn maxwell_relaxation(knots: &Knots, point: &[f64]) -> Result<Relaxation> {
    Relaxation::maxwell(&knots.branches(point)).map_err(Diagnostic::from)
}

/// One search: of the strengths at which knots, where it begins, the deviation of a residual (m), and iterations at most.
struct Search<'a> {
    knots: &'a Knots,
    start: Vec<f64>,
    sigma: Metre,
    iterations: usize,
}

impl SpectrumProblem<'_> {
    /// The spectrum: a first fit gives the size and the correlation time of the discrepancy, which weigh the second against the prior.
    /// `progress` receives the part that is done.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a motion is not found or a branch is one that no solid can have.
    pub fn identify(&self, progress: &dyn Fn(f64)) -> Result<Found> {
        let set = self.settings;
        let median = vec![set.prior_strength.ln(); set.times.len()];
        let knots = Knots { times: set.times.clone(), per_interval: set.branches_per_interval, median };
        let start = knots.median.clone();
        let search = Search { knots: &knots, start, sigma: set.sigma, iterations: set.iterations };
        let first = self.minimise_misfit(search, progress)?;
        let (knots, start) = knots.free_every_branch(&first.at);
        let values = self.film_residuals(maxwell_relaxation(&knots, &start)?)?;
        let correlation = self.correlation_frames(&values);
        // Frames err alike over their correlation: with this deviation so many of them weigh as one.
        let sigma = rms_distance(&values) * correlation.sqrt();
        let best = self.minimise_misfit(Search { knots: &knots, start, sigma, iterations: REWEIGHTED }, progress)?;
        self.assemble_result((&knots, sigma), &best, correlation)
    }

    fn relaxed_body(&self, relaxation: Relaxation) -> ReducedBody {
        self.reduced.with(self.model, &Viscoelastic::measured_at(self.modulus_time, self.held.clone(), relaxation))
    }

    /// Residuals of every film with a relaxation, m.
    fn film_residuals(&self, relaxation: Relaxation) -> Result<Vec<f64>> {
        let body = self.relaxed_body(relaxation);
        let by_film: Vec<Vec<f64>> = self.films.par_iter().map(|film| film.residuals(&body)).collect::<Result<_>>()?;
        Ok(by_film.concat())
    }

    /// Residuals over `sigma` (m) with those of the prior behind them, and the Jacobian of both.
    fn evaluate_point(&self, knots: &Knots, point: &[f64], sigma: Metre) -> Result<Evaluation> {
        let nudged = |k: Option<usize>| -> Vec<f64> {
            point.iter().enumerate().map(|(i, x)| x + if Some(i) == k { NUDGE } else { 0.0 }).collect()
        };
        let points: Vec<Vec<f64>> = std::iter::once(None).chain((0..point.len()).map(Some)).map(nudged).collect();
        let simulated: Vec<Vec<f64>> = points
            .par_iter()
            .map(|point| self.film_residuals(maxwell_relaxation(knots, point)?))
            .collect::<Result<_>>()?;
        let mut residuals = Residuals { values: Vec::new(), jacobian: Vec::new() };
        for (i, value) in simulated[0].iter().enumerate() {
            residuals.values.push(value / sigma);
            residuals.jacobian.extend(simulated[1..].iter().map(|s| (s[i] - value) / (NUDGE * sigma)));
        }
        let width = self.settings.prior_sigma;
        for (k, x) in point.iter().enumerate() {
            residuals.values.push((x - knots.median[k]) / width);
            residuals.jacobian.extend((0..point.len()).map(|j| if j == k { 1.0 / width } else { 0.0 }));
        }
        let loss = residuals.half_sum_of_squares();
        Ok(Evaluation { at: point.to_vec(), loss, gradient: None, residuals: Some(residuals) })
    }

    fn minimise_misfit(
        &self,
        Search { knots, start, sigma, iterations }: Search,
        progress: &dyn Fn(f64),
    ) -> Result<Evaluation> {
        let (set, count) = (self.settings, start.len());
        let names: Vec<String> = knots.times.iter().map(|time| format!("strength at {time} s")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let [low, high] = BOUNDS.map(|bound| vec![bound.ln(); count]);
        let bounds = Bounds { low, high };
        let search = Problem::new(&names, bounds.clamp(&start), bounds)?;
        let newton = Newton { step_tolerance: set.step_tolerance, iterations, ..Newton::default() };
        let mut optimiser = GaussNewton::new(&search, &newton)?;
        let mut evaluated = 0;
        let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            evaluated += batch.len();
            progress((evaluated as f64 / iterations as f64).min(1.0));
            batch.iter().map(|point| self.evaluate_point(knots, point, sigma).map_err(Interrupted)).collect()
        };
        Ok(optimize::minimise(&mut optimiser as &mut dyn Optimiser, &mut problem).map_err(|stop| stop.0)?.best)
    }

    /// Frames that count as one independent one, the mean over windows and axes.
    fn correlation_frames(&self, residuals: &[f64]) -> f64 {
        let (mut remaining, mut correlations) = (residuals, Vec::new());
        for frames in self.films.iter().flat_map(Film::frames).flat_map(|frames| [frames; 2]) {
            let (window, following) = remaining.split_at(frames);
            remaining = following;
            correlations.push(integrated_correlation(window));
        }
        correlations.iter().sum::<f64>() / correlations.len().max(1) as f64
    }

    /// Covariance of the parameters at the best point, whose residuals are in units of their deviations.
    // The law errs alike in all frames of a window, and otherwise in the next one: frames of a window are no independent witnesses, windows
    // nearly are. What errs alike in all windows is not in it. On the bench's paper profile the errors of storage and loss from 1 to 8 Hz are 1.5
    // of these deviations, root mean square over three tails, and at most 2.8; with one branch a decade, whose ripple is none of the silicone's,
    // they were 2.2 and at most 4.8.
    fn parameter_covariance(&self, best: &Evaluation) -> Result<DMatrix<f64>> {
        let best = residuals_of(best)?;
        let count = best.jacobian.len() / best.values.len();
        let jacobian = DMatrix::from_row_slice(best.values.len(), count, &best.jacobian);
        let data = best.values.len() - count;
        let [expected, prior] =
            [(0, data), (data, count)].map(|(first, rows)| fisher_information(&jacobian, first, rows));
        let windows: Vec<usize> = self.films.iter().flat_map(Film::frames).map(|frames| 2 * frames).collect();
        (godambe_information(best, &windows, expected) + prior).try_inverse().ok_or_else(|| {
            let reason = "its prior is infinitely wide";
            Diagnostic::new("the relaxation has no covariance", reason, "correct prior_sigma in study.toml")
        })
    }

    /// By how much the strengths follow each modulus at the best point, all in logarithms: moduli × strengths.
    fn modulus_response(&self, best: &Evaluation, knots: &Knots, sigma: Metre) -> Result<Vec<Vec<f64>>> {
        let (relaxation, nominal) = (maxwell_relaxation(knots, &best.at)?, residuals_of(best)?);
        let follows = |k: usize| {
            let mut perturbed_problem = self.clone();
            perturbed_problem.held.youngs_moduli[k] *= NUDGE.exp();
            let perturbed = perturbed_problem.film_residuals(relaxation.clone())?;
            let prior = vec![0.0; best.at.len()];
            let change =
                perturbed.iter().zip(&nominal.values).map(|(perturbed, nominal)| (perturbed / sigma - nominal) / NUDGE);
            Ok(nominal.parameter_response(&change.chain(prior).collect::<Vec<_>>(), best.at.len())?)
        };
        (0..self.held.youngs_moduli.len()).into_par_iter().map(follows).collect()
    }

    /// The spectrum at the best point, whose residuals are in units of `sigma` (m).
    fn identified_spectrum(&self, knots: &Knots, best: &Evaluation, sigma: Metre) -> Result<IdentifiedSpectrum> {
        let covariance = self.parameter_covariance(best)?;
        let count = covariance.nrows();
        let deviation: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        let branch = |(k, branch): (usize, Branch)| IdentifiedBranch {
            time_s: branch.time,
            strength: branch.strength,
            sigma: deviation[k],
            over_prior: deviation[k] / self.settings.prior_sigma,
        };
        let pairs = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        Ok(IdentifiedSpectrum {
            branches: knots.branches(&best.at).into_iter().enumerate().map(branch).collect(),
            correlation: pairs.map(|(i, j)| covariance[(i, j)] / (deviation[i] * deviation[j])).collect(),
            modulus_time_s: self.modulus_time,
            modulus_response: self.modulus_response(best, knots, sigma)?,
        })
    }

    fn assemble_result(&self, (knots, sigma): (&Knots, Metre), best: &Evaluation, correlation: f64) -> Result<Found> {
        let relaxation = maxwell_relaxation(knots, &best.at)?;
        Ok(Found {
            spectrum: self.identified_spectrum(knots, best, sigma)?,
            rmse: rms_distance(&self.film_residuals(relaxation.clone())?),
            elastic_rmse: rms_distance(&self.film_residuals(Relaxation::default())?),
            correlation_time: correlation * self.films[0].frame_interval(),
            transients: self.films[0].transients(&self.relaxed_body(relaxation))?,
        })
    }
}

/// JᵀJ of the rows from `first` on.
fn fisher_information(jacobian: &DMatrix<f64>, first: usize, rows: usize) -> DMatrix<f64> {
    let part = jacobian.rows(first, rows);
    part.tr_mul(&part)
}

/// The information of residuals that are alike within windows, of so many rows each: Godambe's J S⁻¹ J of the `expected` information J and
/// the scatter S of the windows' gradients, but in no direction more than J [liang1986].
fn godambe_information(best: &Residuals, windows: &[usize], expected: DMatrix<f64>) -> DMatrix<f64> {
    let (count, parameters) = (windows.len(), expected.nrows());
    // At the best point the gradients of all windows nearly add up to zero: the scatter of no more windows than
    // parameters is singular.
    let Some(factor) = expected.clone().cholesky().filter(|_| count > parameters) else { return expected };
    let (mut scatter, mut first) = (DMatrix::zeros(parameters, parameters), 0);
    for rows in windows {
        let range = first * parameters..(first + rows) * parameters;
        let window_jacobian = DMatrix::from_row_slice(*rows, parameters, &best.jacobian[range]);
        let gradient = window_jacobian.tr_mul(&DVector::from_column_slice(&best.values[first..first + rows]));
        scatter += &gradient * gradient.transpose();
        first += rows;
    }
    scatter *= count as f64 / (count - parameters) as f64;
    // with J = L Lᵀ and L⁻¹ S L⁻ᵀ = V D Vᵀ, J S⁻¹ J = L V D⁻¹ Vᵀ Lᵀ
    let lower = factor.l();
    let whitened =
        lower.solve_lower_triangular(&scatter).and_then(|half| lower.solve_lower_triangular(&half.transpose()));
    let Some(split) = whitened.map(|both| SymmetricEigen::new(0.5 * (&both + both.transpose()))) else {
        return expected;
    };
    // Few windows may scatter less, by chance, than their own residuals allow.
    let inverse_eigenvalues = DMatrix::from_diagonal(&split.eigenvalues.map(|value| 1.0 / value.max(1.0)));
    let turned = lower * split.eigenvectors;
    &turned * inverse_eigenvalues * turned.transpose()
}

/// Root mean square distance, of x and y one after the other.
fn rms_distance(values: &[f64]) -> Metre {
    (2.0 * values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line through the origin: windows of ten equal rows, each off by an error of its own.
    fn windows(errors: &[f64]) -> Residuals {
        let values = errors.iter().flat_map(|error| [*error; 10]).collect();
        Residuals { values, jacobian: vec![1.0; 10 * errors.len()] }
    }

    #[test]
    fn rows_that_err_alike_in_a_window_count_as_one_witness() {
        let errors = [1.0, -1.0, 2.0, -2.0, 1.0, -1.0];
        let found = godambe_information(&windows(&errors), &[10; 6], DMatrix::from_element(1, 1, 60.0))[(0, 0)];
        // S = 6/5 Σ (10 e)² = 6/5 · 1200, and 60² / S = 2.5
        assert!((found - 2.5).abs() < 1e-9, "{found}");
    }

    #[test]
    fn windows_that_agree_by_chance_or_are_too_few_leave_the_information_as_it_is() {
        let expected = || DMatrix::from_element(1, 1, 60.0);
        let alike = godambe_information(&windows(&[1e-3, -1e-3, 1e-3, -1e-3, 1e-3, -1e-3]), &[10; 6], expected());
        assert!((alike[(0, 0)] - 60.0).abs() < 1e-9);
        assert_eq!(godambe_information(&windows(&[5.0; 6]), &[60], expected()), expected());
    }

    /// Two lines through the origin that are seen in windows in turn: each is as certain as if it were alone.
    #[test]
    fn windows_of_another_parameter_are_no_witnesses_of_the_first() {
        let errors = [1.0, 2.0, -1.0, -2.0, 2.0, 4.0, -2.0, -4.0, 1.0, 2.0, -1.0, -2.0];
        let values = errors.iter().flat_map(|error| [*error; 10]).collect();
        let jacobian = (0..120).flat_map(|row| if row / 10 % 2 == 0 { [1.0, 0.0] } else { [0.0, 1.0] }).collect();
        let found =
            godambe_information(&Residuals { values, jacobian }, &[10; 12], DMatrix::from_diagonal_element(2, 2, 60.0));
        // S = 12/10 Σ (10 e)², and 60² / S
        let should = DMatrix::from_row_slice(2, 2, &[2.5, 0.0, 0.0, 0.625]);
        assert!((&found - should).norm() < 1e-9, "{found}");
    }
}
