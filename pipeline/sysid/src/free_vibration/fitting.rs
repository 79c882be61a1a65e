//! A joint fit of one law to several recordings, with the posterior of its parameters.
//!
//! Residuals are differences of displacement over the static deflection of each recording. They are not noise: a law that is not the
//! silicone's own leaves a smooth discrepancy. Its size and its correlation time are estimated from the residuals, and the covariance
//! of the parameters is that of so many independent residuals as the recordings are long in correlation times.

use nalgebra::DMatrix;
use optimize::optimisers::gauss_newton::{GaussNewton, Settings};
use optimize::posterior::integrated_correlation;
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals, minimise};
use rayon::prelude::*;
use si::{Second, Series};

use super::condition::{Condition, times};
use super::laws::{Law, Scale};
use super::page::Page;
use super::recorded::Recorded;
use diagnostics::{Diagnostic, Result};

/// Bounds of the time in which the hand lets go, and of the error of the page's time of release, s.
const RAMP: [Second; 2] = [1e-3, 0.25];
const SHIFT: [Second; 2] = [-0.08, 0.08];
/// Starts of both, s.
const RAMP_START: Second = 0.04;
const SHIFT_START: Second = -0.01;
/// Forward differences, in units of the search.
// About the root of the 1e-8 to which motions are solved, where truncation and noise of a slope balance.
const DIFFERENCE: f64 = 3e-4;

/// A recording with the condition under which it was made.
#[derive(Clone, Copy)]
pub(super) struct Trial<'a> {
    pub recorded: &'a Recorded,
    pub condition: &'a Condition,
}

/// The result of a fit.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub law: Law,
    /// Law's parameters in SI units, in its order.
    pub values: Vec<f64>,
    /// Point of the search: the law's parameters, then ramp and shift of each recording.
    pub at: Vec<f64>,
    /// Its covariance, in units of the search.
    pub covariance: DMatrix<f64>,
    /// Root mean square of the residuals over the static deflection.
    pub discrepancy: f64,
    /// Correlation time of the residuals, s.
    pub correlation_time: Second,
    /// Independent residuals.
    pub independent: f64,
    /// Names of parameters on their bounds.
    pub on_bounds: Vec<String>,
}

/// One fit's problem.
pub(super) struct Fit<'a> {
    pub page: &'a Page,
    pub law: Law,
    pub trials: Vec<Trial<'a>>,
}

impl Fit<'_> {
    fn parameter_scales(&self) -> Vec<Scale> {
        self.law.parameters.iter().map(|quantity| quantity.scale(self.page.range)).collect()
    }

    /// Parameters of the law at a point of the search, SI.
    pub fn values(&self, point: &[f64]) -> Vec<f64> {
        let parameter_value = |(scale, x): (Scale, &f64)| if scale.logarithmic { x.exp() } else { *x };
        self.parameter_scales().into_iter().zip(point).map(parameter_value).collect()
    }

    /// Ramp and shift of recording `k` at a point of the search, s.
    fn ramp_and_shift(&self, point: &[f64], k: usize) -> [Second; 2] {
        let first = self.law.parameters.len() + 2 * k;
        [point[first], point[first + 1]]
    }

    /// The ramp to expect of a release under `condition`, s: the mean of those fitted under it, or of all.
    pub(super) fn expected_ramp(&self, point: &[f64], condition: &Condition) -> Second {
        let same_condition = |k: &usize| std::ptr::eq(self.trials[*k].condition, condition);
        let mut like: Vec<usize> = (0..self.trials.len()).filter(same_condition).collect();
        if like.is_empty() {
            like = (0..self.trials.len()).collect();
        }
        like.iter().map(|k| self.ramp_and_shift(point, *k)[0]).sum::<f64>() / like.len() as f64
    }

    fn search_problem(&self) -> Result<Problem> {
        let line = |scale: &Scale, x: f64| if scale.logarithmic { x.ln() } else { x };
        let scales = self.parameter_scales();
        let (mut start, mut bounds) = (Vec::new(), Bounds { low: Vec::new(), high: Vec::new() });
        let mut add = |initial: f64, low: f64, high: f64| {
            start.push(initial);
            bounds.low.push(low);
            bounds.high.push(high);
        };
        scales.iter().for_each(|s| add(line(s, s.start), line(s, s.range[0]), line(s, s.range[1])));
        for _ in &self.trials {
            add(RAMP_START, RAMP[0], RAMP[1]);
            add(SHIFT_START, SHIFT[0], SHIFT[1]);
        }
        let names = self.parameter_names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Problem::new(&names, start, bounds).map_err(Diagnostic::from)
    }

    fn parameter_names(&self) -> Vec<String> {
        let law = self.parameter_scales().into_iter().map(|scale| scale.name.to_owned());
        let each = self.trials.iter().flat_map(|trial| {
            let name = &trial.recorded.name;
            [format!("ramp of {name}"), format!("shift of {name}")]
        });
        law.chain(each).collect()
    }

    /// Simulated displacement of recording `k` at the times of its frames, m.
    fn simulated_fall(&self, point: &[f64], k: usize) -> Result<Vec<f64>> {
        let [ramp, shift] = self.ramp_and_shift(point, k);
        let properties = self.law.properties(&self.values(point), self.page.modulus_time)?;
        let Trial { recorded, condition } = self.trials[k];
        // A release before the page's time is simulated for longer than it was recorded.
        let times = times(self.page, recorded.fall.end() - shift.min(0.0) + self.page.step);
        let fall = condition.fall(&properties, ramp, &times)?;
        Ok((0..recorded.fall.values().len())
            .map(|i| interpolate_series(&times, &fall, recorded.fall.time(i) - shift))
            .collect())
    }

    /// Residuals of all recordings and their Jacobian, by forward differences.
    fn evaluate_point(&self, point: &[f64]) -> Result<Evaluation> {
        let law = self.law.parameters.len();
        let jobs: Vec<(usize, Option<usize>)> = (0..self.trials.len())
            .flat_map(|k| {
                let release_parameters = law + 2 * k..law + 2 * k + 2;
                std::iter::once((k, None)).chain((0..law).chain(release_parameters).map(move |p| (k, Some(p))))
            })
            .collect();
        let simulate = |&(k, perturbed): &(usize, Option<usize>)| {
            let mut perturbed_point = point.to_vec();
            perturbed.iter().for_each(|p| perturbed_point[*p] += DIFFERENCE);
            self.simulated_fall(&perturbed_point, k)
        };
        let simulated: Vec<Vec<f64>> = jobs.par_iter().map(simulate).collect::<Result<_>>()?;
        let mut residuals = Residuals { values: Vec::new(), jacobian: Vec::new() };
        let each = law + 3;
        for (k, simulated) in simulated.chunks_exact(each).enumerate() {
            let scale = 1.0 / self.trials[k].recorded.deflection().abs();
            for (i, measured) in self.trials[k].recorded.fall.values().iter().enumerate() {
                residuals.values.push(scale * (simulated[0][i] - measured));
                let mut row = vec![0.0; point.len()];
                for (job, (_, perturbed)) in jobs[k * each..(k + 1) * each].iter().enumerate() {
                    perturbed.iter().for_each(|p| row[*p] = scale * (simulated[job][i] - simulated[0][i]) / DIFFERENCE);
                }
                residuals.jacobian.extend(row);
            }
        }
        let (loss, gradient) = (residuals.half_sum_of_squares(), Some(residuals.gradient(point.len())));
        Ok(Evaluation { at: point.to_vec(), loss, gradient, residuals: Some(residuals) })
    }

    /// Fits the law to all recordings.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a motion is not found or the recordings do not determine the parameters.
    pub fn run(&self) -> Result<Fitted> {
        let problem = self.search_problem()?;
        let settings = Settings { damping: 1e-2, step_tolerance: 1e-3, iterations: 40, ..Settings::default() };
        let mut optimiser = GaussNewton::new(&problem, &settings)?;
        let mut diagnostic = None;
        let log = minimise(&mut optimiser, &mut |batch: &[Vec<f64>], _: Needs| {
            let answers: Result<Vec<_>> = batch.iter().map(|point| self.evaluate_point(point)).collect();
            answers.map_err(|error| {
                diagnostic = Some(error.while_doing(self.law.name));
                OptimiseError::Length { what: "the answers", found: 0, expected: batch.len() }
            })
        });
        let best = log.map_err(|e| diagnostic.unwrap_or_else(|| Diagnostic::from(e)))?.best;
        let residuals = best.residuals.unwrap_or(Residuals { values: Vec::new(), jacobian: Vec::new() });
        Ok(self.fit_posterior(&problem, best.at, &residuals))
    }

    fn fit_posterior(&self, problem: &Problem, point: Vec<f64>, residuals: &Residuals) -> Fitted {
        let (count, parameters) = (residuals.values.len(), point.len());
        let jacobian = DMatrix::from_row_slice(count, parameters, &residuals.jacobian);
        let (correlation, rate) = (correlation_frames(self, &residuals.values), self.trials[0].recorded.fall.rate());
        // At least one degree of freedom: strongly correlated residuals would otherwise give a variance without bound,
        // or below zero.
        let independent = (count as f64 / correlation).max(parameters as f64 + 1.0);
        let variance = 2.0 * residuals.half_sum_of_squares() / count as f64 * independent
            / (independent - parameters as f64).max(1.0);
        // A weak prior, as wide as the bounds, keeps the covariance finite along a direction that the recordings do not determine.
        let width = |p: usize| problem.bounds().high[p] - problem.bounds().low[p];
        let mut information = jacobian.tr_mul(&jacobian) / (variance * correlation);
        (0..parameters).for_each(|p| information[(p, p)] += 12.0 / (width(p) * width(p)));
        let covariance = information.try_inverse().unwrap_or_else(|| DMatrix::identity(parameters, parameters));
        let near_bound = |p: &usize| {
            let (low, high) = (problem.bounds().low[*p], problem.bounds().high[*p]);
            (point[*p] - low).min(high - point[*p]) < 1e-4 * (high - low)
        };
        let on_bounds =
            (0..self.law.parameters.len()).filter(near_bound).map(|p| self.parameter_names()[p].clone()).collect();
        Fitted {
            law: self.law,
            values: self.values(&point),
            covariance,
            discrepancy: (2.0 * residuals.half_sum_of_squares() / count as f64).sqrt(),
            correlation_time: correlation / rate,
            independent,
            on_bounds,
            at: point,
        }
    }
}

impl Fitted {
    /// Bayes' information criterion, of the residuals that are independent: the least is best.
    pub(super) fn information_criterion(&self, independent: f64) -> f64 {
        2.0 * independent * self.discrepancy.ln() + self.at.len() as f64 * independent.ln()
    }
}

/// Frames that count as one independent one, the mean of all recordings.
fn correlation_frames(fit: &Fit, residuals: &[f64]) -> f64 {
    let mut remaining = residuals;
    let mut sum = 0.0;
    for trial in &fit.trials {
        let (recording_residuals, following) = remaining.split_at(trial.recorded.fall.values().len());
        remaining = following;
        sum += integrated_correlation(recording_residuals);
    }
    sum / fit.trials.len() as f64
}

/// The value at a time between samples; that of the first before it.
pub(crate) fn interpolate_series(times: &[Second], values: &[f64], time: Second) -> f64 {
    let next = times.partition_point(|sample| *sample < time);
    // a motion that ends at once has one sample
    if next == 0 || times.len() == 1 {
        return values[0];
    }
    let next = next.min(times.len() - 1);
    let part = (time - times[next - 1]) / (times[next] - times[next - 1]);
    values[next - 1] + part * (values[next] - values[next - 1])
}

/// A recording's simulated displacement as a series like the recorded one.
///
/// # Errors
/// A [`Diagnostic`] when no motion is found.
pub(super) fn predicted(page: &Page, (law, values): (Law, &[f64]), ramp: Second, trial: Trial) -> Result<Series> {
    let properties = law.properties(values, page.modulus_time)?;
    let recorded = &trial.recorded.fall;
    let times = times(page, recorded.end() + page.step);
    let fall = trial.condition.fall(&properties, ramp.max(RAMP[0]), &times)?;
    let values = (0..recorded.values().len()).map(|i| interpolate_series(&times, &fall, recorded.time(i))).collect();
    Series::new(0.0, recorded.rate(), values).map_err(Diagnostic::from)
}

#[cfg(test)]
mod tests {
    use super::super::laws::LADDER;
    use super::super::testing;
    use super::*;

    #[test]
    fn a_line_is_interpolated_and_nothing_moves_before_the_release() {
        let (times, values) = ([0.0, 0.1, 0.3], [0.0, 1.0, 5.0]);
        for (at, expected) in [(-0.2, 0.0), (0.05, 0.5), (0.2, 3.0), (0.3, 5.0)] {
            assert!((interpolate_series(&times, &values, at) - expected).abs() < 1e-12);
        }
        assert_eq!(interpolate_series(&[0.0], &[2.0], 0.3), 2.0, "a motion that ends at once");
    }

    #[test]
    fn the_information_criterion_weighs_the_misfit_against_the_parameters() {
        let fitted = testing::fitted(LADDER[0], &[1e5, 1e-3], &[0.1, 0.1], &[0.04]);
        // n ln σ² + k ln n with n = e³, σ = 0.02, and two parameters of the law, a ramp and a shift
        let n = 3.0_f64.exp();
        assert!((fitted.information_criterion(n) - (n * 4e-4_f64.ln() + 4.0 * 3.0)).abs() < 1e-9);
    }

    /// A linear problem of four parameters, each seen by a quarter of 400 residuals of root mean square 0.7, so many of one sign in a row.
    fn fitted(at: Vec<f64>, alike: usize) -> Fitted {
        let page = testing::page();
        let condition = Condition::new(&page, &testing::examples().join("beam_ds10_case.toml"), None).unwrap();
        let fall = Series::new(0.0, 100.0, vec![0.0; 400]).unwrap();
        let recorded = Recorded { name: "made".into(), fall, settled: vec![-6e-3] };
        let trials = vec![Trial { recorded: &recorded, condition: &condition }];
        let fit = Fit { page: &page, law: LADDER[0], trials };
        let values = (0..400).map(|i| if (i / alike).is_multiple_of(2) { 0.7 } else { -0.7 }).collect();
        let jacobian = (0..1600).map(|k| f64::from(u8::from(k % 4 == k / 4 % 4))).collect();
        fit.fit_posterior(&fit.search_problem().unwrap(), at, &Residuals { values, jacobian })
    }

    #[test]
    fn the_posterior_weighs_independent_residuals_against_the_width_of_the_bounds() {
        let found = fitted(vec![3e5_f64.ln(), 1e-3_f64.ln(), 0.04, 0.0], 2);
        assert!((found.discrepancy - 0.7).abs() < 1e-12, "{}", found.discrepancy);
        let correlation = found.correlation_time * 100.0;
        let independent = 400.0 / correlation;
        assert!(correlation >= 1.0 && (found.independent - independent).abs() < 1e-9, "{correlation}");
        // 100 residuals see each parameter, and one in so many is independent; a uniform prior has the variance of width²/12
        let variance = 0.49 * independent / (independent - 4.0);
        let widths = [(6e5_f64 / 1.2e5).ln(), (0.05_f64 / 1e-6).ln(), RAMP[1] - RAMP[0], SHIFT[1] - SHIFT[0]];
        for (p, width) in widths.iter().enumerate() {
            let should = 1.0 / (100.0 / (variance * correlation) + 12.0 / (width * width));
            assert!((found.covariance[(p, p)] / should - 1.0).abs() < 1e-9, "{p}: {}", found.covariance);
        }
        assert!(found.covariance[(0, 1)].abs() < 1e-12 && found.on_bounds.is_empty());
        let slow = fitted(found.at.clone(), 200);
        assert_eq!(slow.independent, 5.0, "no fewer than one more than there are parameters");
        assert!((found.values[0] / 3e5 - 1.0).abs() < 1e-12 && (found.values[1] / 1e-3 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_parameter_of_the_law_within_a_ten_thousandth_of_an_end_lies_on_it() {
        let of = |modulus: f64, damping: f64| fitted(vec![modulus.ln(), damping.ln(), RAMP[0], SHIFT[1]], 2).on_bounds;
        assert_eq!(of(6e5, 1e-3), ["youngs_modulus"], "neither the release nor its time is one of the law");
        assert_eq!(of(1.2e5 * (1.0 + 1e-4), 0.05), ["youngs_modulus", "stiffness_damping"]);
        assert!(of(1.2e5 * 1.001, 1e-3).is_empty());
    }
}
