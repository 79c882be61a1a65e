//! The ladder: every law fitted to the recordings that are marked so, compared by what it predicts of the others.

use rayon::prelude::*;
use si::Series;

use super::condition::Condition;
use super::features::{Features, difference};
use super::fitting::{Fit, Fitted, Trial, predicted};
use super::laws::{LADDER, Law};
use super::page::Page;
use super::recorded::Recorded;
use diagnostics::Result;

/// 95 % of a normal distribution lie within so many deviations.
const WITHIN_95: f64 = 1.959_964;

/// A fit and what it says of every recording.
pub(super) struct Row {
    pub fitted: Fitted,
    /// Which recordings were fitted.
    pub used: Vec<usize>,
    /// One per recording.
    pub predictions: Vec<Prediction>,
}

/// What a fit says of one recording.
pub(super) struct Prediction {
    pub features: Features,
    /// Half widths of their 95 % intervals, in the units of [`super::features::NAMES`].
    pub half_widths: [f64; 4],
    pub fall: Series,
    /// Root mean square difference over the recording's static deflection.
    pub difference: f64,
}

/// Everything that is known of one law.
pub(super) struct LawResult {
    /// Fitted to all recordings that are marked so.
    pub joint: Row,
    /// With one of them left out each.
    pub left_out: Vec<Row>,
    /// Bayes' information criterion of the joint fit, relative to the best law's.
    pub criterion: f64,
}

impl LawResult {
    /// Root mean square of the differences at the recordings that were left out; none when only one is fitted.
    pub(super) fn left_out_difference(&self) -> Option<f64> {
        let of = |row: &Row| {
            let omitted = self.joint.used.iter().find(|k| !row.used.contains(k)).copied().unwrap_or_default();
            row.predictions[omitted].difference.powi(2)
        };
        let count = self.left_out.len();
        (count > 0).then(|| (self.left_out.iter().map(of).sum::<f64>() / count as f64).sqrt())
    }
}

/// The recordings of a page with their conditions.
pub(super) struct Bench<'a> {
    pub page: &'a Page,
    pub recorded: &'a [Recorded],
    pub conditions: &'a [Condition],
    /// Condition of each recording.
    pub of: Vec<usize>,
}

impl Bench<'_> {
    fn trial(&self, k: usize) -> Trial<'_> {
        Trial { recorded: &self.recorded[k], condition: &self.conditions[self.of[k]] }
    }

    /// Fits every law of the ladder.
    ///
    /// # Errors
    /// A diagnostic when a motion is not found.
    pub(super) fn fit_all(&self) -> Result<Vec<LawResult>> {
        let used: Vec<usize> = (0..self.recorded.len()).filter(|k| self.page.recording[*k].fitted).collect();
        let mut results: Vec<LawResult> = LADDER.iter().map(|law| self.result(*law, &used)).collect::<Result<_>>()?;
        // The laws are compared by residuals of one correlation time, that of the richest.
        let independent = results.last().map_or(1.0, |result| result.joint.fitted.independent);
        let criteria: Vec<f64> =
            results.iter().map(|result| result.joint.fitted.information_criterion(independent)).collect();
        let best = criteria.iter().copied().fold(f64::INFINITY, f64::min);
        results.iter_mut().zip(criteria).for_each(|(result, criterion)| result.criterion = criterion - best);
        Ok(results)
    }

    fn result(&self, law: Law, used: &[usize]) -> Result<LawResult> {
        let without = |omitted: &usize| used.iter().copied().filter(|k| k != omitted).collect::<Vec<_>>();
        let left_out = if used.len() > 1 { used.iter().map(without).collect() } else { Vec::new() };
        let left_out = left_out.iter().map(|used| self.row(law, used)).collect::<Result<_>>()?;
        Ok(LawResult { joint: self.row(law, used)?, left_out, criterion: 0.0 })
    }

    fn row(&self, law: Law, used: &[usize]) -> Result<Row> {
        let fit = Fit { page: self.page, law, trials: used.iter().map(|k| self.trial(*k)).collect() };
        let fitted = fit.run()?;
        let predict = |k: usize| self.prediction(&fit, &fitted, k);
        let predictions = (0..self.recorded.len()).into_par_iter().map(predict).collect::<Result<_>>()?;
        Ok(Row { used: used.to_vec(), fitted, predictions })
    }

    /// What a fit says of recording `k`, released as the fitted ones of its case were on the mean.
    fn prediction(&self, fit: &Fit, fitted: &Fitted, k: usize) -> Result<Prediction> {
        let trial = self.trial(k);
        let ramp = fit.expected_ramp(&fitted.at, trial.condition);
        let fall = predicted(self.page, (fitted.law, &fitted.values), ramp, trial)?;
        let features = Features::of(self.page, &fall)?;
        let half_widths = self.half_widths(fit, fitted, trial, features)?;
        let difference = difference(&fall, &trial.recorded.fall, trial.recorded.deflection());
        Ok(Prediction { features, half_widths, fall, difference })
    }

    /// Half widths of the 95 % intervals: the parameters' covariance, the scatter of releases, the discrepancy of displacements and the
    /// measurement itself.
    fn half_widths(&self, fit: &Fit, fitted: &Fitted, trial: Trial, at: Features) -> Result<[f64; 4]> {
        let law = fitted.law.parameters.len();
        let ramp = fit.expected_ramp(&fitted.at, trial.condition);
        let features = |values: &[f64], ramp: f64| -> Result<[f64; 4]> {
            let fall = predicted(self.page, (fitted.law, values), ramp, trial)?;
            Ok(Features::of(self.page, &fall)?.to_array())
        };
        let here = at.to_array();
        let mut slopes = Vec::new();
        for p in 0..law {
            let step = (0.3 * fitted.covariance[(p, p)].sqrt()).clamp(1e-4, 0.05);
            let mut moved = fitted.at.clone();
            moved[p] += step;
            let there = features(&fit.values(&moved), ramp)?;
            slopes.push([0, 1, 2, 3].map(|n| (there[n] - here[n]) / step));
        }
        let step = 2e-3;
        let longer = features(&fitted.values, ramp + step)?;
        let by_ramp = [0, 1, 2, 3].map(|n| (longer[n] - here[n]) / step);
        let ramp_variance = ramp_variance(fitted, fit.trials.len());
        let own = at.measurement_sigma(self.page.sigma);
        Ok([0, 1, 2, 3].map(|n| {
            let pairs = (0..law).flat_map(|p| (0..law).map(move |q| (p, q)));
            let parameters: f64 = pairs.map(|(p, q)| slopes[p][n] * fitted.covariance[(p, q)] * slopes[q][n]).sum();
            let discrepancy = if n == 1 || n == 2 { fitted.discrepancy * here[1] } else { 0.0 };
            let variance = parameters + by_ramp[n].powi(2) * ramp_variance + discrepancy.powi(2) + own[n].powi(2);
            WITHIN_95 * variance.max(0.0).sqrt()
        }))
    }
}

/// Variance of the ramp of another release, s²: how well each is known, and how they differ.
fn ramp_variance(fitted: &Fitted, trials: usize) -> f64 {
    let first = fitted.law.parameters.len();
    let ramps: Vec<f64> = (0..trials).map(|k| fitted.at[first + 2 * k]).collect();
    let mean = ramps.iter().sum::<f64>() / trials as f64;
    let own = (0..trials).map(|k| fitted.covariance[(first + 2 * k, first + 2 * k)]).sum::<f64>() / trials as f64;
    let scatter = ramps.iter().map(|ramp| (ramp - mean).powi(2)).sum::<f64>();
    // One release does not show how others differ: they are taken to differ by half of it.
    own + if trials > 1 { scatter / (trials - 1) as f64 } else { 0.25 * mean * mean }
}

/// The law that the recordings support: the least difference at recordings that were left out, where at least two remain to be
/// fitted; one alone determines neither how the stress grows with strain nor how it depends on time, and the information criterion
/// decides.
pub(super) fn supported(results: &[LawResult]) -> usize {
    let key = |result: &LawResult| {
        let left_out = result.left_out_difference().filter(|_| result.joint.used.len() > 2);
        left_out.unwrap_or(result.criterion)
    };
    (0..results.len()).min_by(|a, b| key(&results[*a]).total_cmp(&key(&results[*b]))).unwrap_or_default()
}
