//! The ladder: every law fitted to the recordings that are marked so, compared by what it predicts of the others.

use rayon::prelude::*;
use si::Series;

use super::condition::Condition;
use super::features::{Features, aligned_difference};
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
        let omitted_difference = |row: &Row| {
            let omitted = self.joint.used.iter().find(|k| !row.used.contains(k)).copied().unwrap_or_default();
            row.predictions[omitted].difference.powi(2)
        };
        let count = self.left_out.len();
        (count > 0).then(|| (self.left_out.iter().map(omitted_difference).sum::<f64>() / count as f64).sqrt())
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
    fn recording_trial(&self, k: usize) -> Trial<'_> {
        Trial { recorded: &self.recorded[k], condition: &self.conditions[self.of[k]] }
    }

    /// Fits every law of the ladder.
    ///
    /// # Errors
    /// A diagnostic when a motion is not found.
    pub(super) fn fit_all(&self) -> Result<Vec<LawResult>> {
        let used: Vec<usize> = (0..self.recorded.len()).filter(|k| self.page.recording[*k].fitted).collect();
        let mut results: Vec<LawResult> =
            LADDER.iter().map(|law| self.law_result(*law, &used)).collect::<Result<_>>()?;
        // The laws are compared by residuals of one correlation time, that of the richest.
        let independent = results.last().map_or(1.0, |result| result.joint.fitted.independent);
        let criteria: Vec<f64> =
            results.iter().map(|result| result.joint.fitted.information_criterion(independent)).collect();
        let best = criteria.iter().copied().fold(f64::INFINITY, f64::min);
        results.iter_mut().zip(criteria).for_each(|(result, criterion)| result.criterion = criterion - best);
        Ok(results)
    }

    fn law_result(&self, law: Law, used: &[usize]) -> Result<LawResult> {
        let without = |omitted: &usize| used.iter().copied().filter(|k| k != omitted).collect::<Vec<_>>();
        let left_out = if used.len() > 1 { used.iter().map(without).collect() } else { Vec::new() };
        let left_out = left_out.iter().map(|used| self.fit_row(law, used)).collect::<Result<_>>()?;
        Ok(LawResult { joint: self.fit_row(law, used)?, left_out, criterion: 0.0 })
    }

    fn fit_row(&self, law: Law, used: &[usize]) -> Result<Row> {
        let fit = Fit { page: self.page, law, trials: used.iter().map(|k| self.recording_trial(*k)).collect() };
        let fitted = fit.run()?;
        let predict = |k: usize| self.predict_recording(&fit, &fitted, k);
        let predictions = (0..self.recorded.len()).into_par_iter().map(predict).collect::<Result<_>>()?;
        Ok(Row { used: used.to_vec(), fitted, predictions })
    }

    /// What a fit says of recording `k`, released as the fitted ones of its case were on the mean.
    fn predict_recording(&self, fit: &Fit, fitted: &Fitted, k: usize) -> Result<Prediction> {
        let trial = self.recording_trial(k);
        let ramp = fit.expected_ramp(&fitted.at, trial.condition);
        let fall = predicted(self.page, (fitted.law, &fitted.values), ramp, trial)?;
        let features = Features::of(self.page, &fall)?;
        let half_widths = self.half_widths(fit, fitted, trial, features)?;
        let difference = aligned_difference(&fall, &trial.recorded.fall, trial.recorded.deflection());
        Ok(Prediction { features, half_widths, fall, difference })
    }

    /// Half widths of the 95 % intervals: the parameters' covariance, the scatter of releases, the discrepancy of displacements and the
    /// measurement itself.
    fn half_widths(&self, fit: &Fit, fitted: &Fitted, trial: Trial, prediction: Features) -> Result<[f64; 4]> {
        let law = fitted.law.parameters.len();
        let ramp = fit.expected_ramp(&fitted.at, trial.condition);
        let features = |values: &[f64], ramp: f64| -> Result<[f64; 4]> {
            let fall = predicted(self.page, (fitted.law, values), ramp, trial)?;
            Ok(Features::of(self.page, &fall)?.to_array())
        };
        let nominal = prediction.to_array();
        let mut slopes = Vec::new();
        for p in 0..law {
            // A part of the deviation, so that the slope is that over the interval; bounded where a parameter is known
            // exactly, or not at all.
            let step = (0.3 * fitted.covariance[(p, p)].sqrt()).clamp(1e-4, 0.05);
            let mut perturbed = fitted.at.clone();
            perturbed[p] += step;
            let perturbed_features = features(&fit.values(&perturbed), ramp)?;
            slopes.push([0, 1, 2, 3].map(|n| (perturbed_features[n] - nominal[n]) / step));
        }
        let step = 2e-3;
        let longer = features(&fitted.values, ramp + step)?;
        let by_ramp = [0, 1, 2, 3].map(|n| (longer[n] - nominal[n]) / step);
        let ramp_variance = ramp_variance(fitted, fit.trials.len());
        let measurement_sigma = prediction.measurement_sigma(self.page.sigma);
        Ok([0, 1, 2, 3].map(|n| {
            let pairs = (0..law).flat_map(|p| (0..law).map(move |q| (p, q)));
            let parameters: f64 = pairs.map(|(p, q)| slopes[p][n] * fitted.covariance[(p, q)] * slopes[q][n]).sum();
            let discrepancy = if n == 1 || n == 2 { fitted.discrepancy * nominal[1] } else { 0.0 };
            let variance =
                parameters + by_ramp[n].powi(2) * ramp_variance + discrepancy.powi(2) + measurement_sigma[n].powi(2);
            WITHIN_95 * variance.max(0.0).sqrt()
        }))
    }
}

/// Variance of the ramp of another release, s²: how well each is known, and how they differ.
fn ramp_variance(fitted: &Fitted, trials: usize) -> f64 {
    let first = fitted.law.parameters.len();
    let ramps: Vec<f64> = (0..trials).map(|k| fitted.at[first + 2 * k]).collect();
    let mean = ramps.iter().sum::<f64>() / trials as f64;
    let mean_variance =
        (0..trials).map(|k| fitted.covariance[(first + 2 * k, first + 2 * k)]).sum::<f64>() / trials as f64;
    let scatter = ramps.iter().map(|ramp| (ramp - mean).powi(2)).sum::<f64>();
    // One release does not show how others differ: they are taken to differ by half of it.
    mean_variance + if trials > 1 { scatter / (trials - 1) as f64 } else { 0.25 * mean * mean }
}

/// The law that the recordings support: the least difference at recordings that were left out, where at least two remain to be
/// fitted; one alone determines neither how the stress grows with strain nor how it depends on time, and the information criterion
/// decides.
pub(super) fn supported_law(results: &[LawResult]) -> usize {
    let key = |result: &LawResult| {
        let left_out = result.left_out_difference().filter(|_| result.joint.used.len() > 2);
        left_out.unwrap_or(result.criterion)
    };
    (0..results.len()).min_by(|a, b| key(&results[*a]).total_cmp(&key(&results[*b]))).unwrap_or_default()
}

#[cfg(test)]
#[allow(non_snake_case)] // the F of a transform
mod tests {
    use super::*;
    use crate::free_vibration::testing;

    /// A bar stiff enough to stay nearly straight, as it is released within 10 ms: it moves by its first mode.
    const E: f64 = 1e6;
    const BETA: f64 = 1e-3;
    const RAMP: f64 = 0.01;
    /// 95 % of a normal distribution, deviations.
    const WITHIN: f64 = 1.96;

    struct Bar {
        page: Page,
        condition: Condition,
        recorded: Recorded,
    }

    impl Bar {
        fn new() -> Self {
            let page = Page { step: 1e-3, sigma: 3e-5, range: [1e5, 1e7], ..testing::page() };
            let condition = Condition::new(&page, &testing::examples().join("beam_ds10_case.toml"), None).unwrap();
            let fall = Series::new(0.0, 500.0, vec![0.0; 1250]).unwrap();
            Self { page, condition, recorded: Recorded { name: "made".into(), fall, settled: vec![-1.7e-3] } }
        }

        /// Features and half widths of a fit of [`LADDER`]'s first law whose parameters have such deviations and correlation.
        fn half_widths(
            &self,
            deviations: [f64; 2],
            correlation: f64,
            change: impl Fn(&mut Fitted),
        ) -> ([f64; 4], [f64; 4]) {
            let mut fitted = testing::fitted(LADDER[0], &[E, BETA], &deviations, &[RAMP]);
            fitted.covariance[(0, 1)] = correlation * deviations[0] * deviations[1];
            fitted.covariance[(1, 0)] = fitted.covariance[(0, 1)];
            fitted.covariance[(2, 2)] = 0.0;
            fitted.discrepancy = 0.0;
            change(&mut fitted);
            let trial = Trial { recorded: &self.recorded, condition: &self.condition };
            let fit = Fit { page: &self.page, law: LADDER[0], trials: vec![trial] };
            let fall = predicted(&self.page, (LADDER[0], &fitted.values), RAMP, trial).unwrap();
            let features = Features::of(&self.page, &fall).unwrap();
            let bench = Bench { page: &self.page, recorded: &[], conditions: &[], of: Vec::new() };
            (features.to_array(), bench.half_widths(&fit, &fitted, trial, features).unwrap())
        }
    }

    fn near(found: f64, should: f64, within: f64) {
        assert!((found / should - 1.0).abs() < within, "{found} for {should}");
    }

    /// Of independent parts, the one that is in `all` and not in `none`.
    fn added([all, none]: [[f64; 4]; 2], n: usize) -> f64 {
        (all[n] * all[n] - none[n] * none[n]).max(0.0).sqrt()
    }

    /// Of a single mode at the angular frequency ω: the first extremum is 1 + D F(ω r/2) deflections away where the load rises within r,
    /// F(u) = 3 (sin u − u cos u) / u³ being the transform of its rate 6 s (1 − s) / r.
    #[test]
    fn half_widths_hold_the_release_the_wave_the_displacement_and_the_discrepancy() {
        let bar = Bar::new();
        let (at, own) = bar.half_widths([0.0, 0.0], 0.0, |fitted| fitted.at[2] = 0.0);
        assert!(own[0] < 1e-3 && own[3] < 1e-3, "the wave is a line of four digits: {own:?}");
        near(own[1], WITHIN * 1e3 * bar.page.sigma, 1e-4);
        // another release is taken to differ by half of the 10 ms of this one
        let (_, release) = bar.half_widths([0.0, 0.0], 0.0, |_| ());
        let F = |ramp: f64| {
            let u = 0.5 * std::f64::consts::TAU * at[0] * ramp;
            3.0 * (u.sin() - u * u.cos()) / u.powi(3)
        };
        let amplitude = (at[2] - at[1]).abs() / F(RAMP);
        let slope = amplitude * (F(RAMP) - F(RAMP + 2e-3)) / 2e-3;
        near(added([release, [0.0, own[1], own[1], 0.0]], 2), WITHIN * slope * 0.5 * RAMP, 0.03);
        near(release[1], own[1], 1e-4);
        // 5 % of the static deflection in every displacement
        let (_, wrong) = bar.half_widths([0.0, 0.0], 0.0, |fitted| fitted.discrepancy = 0.05);
        [1, 2].into_iter().for_each(|n| near(added([wrong, release], n), WITHIN * 0.05 * at[1].abs(), 1e-4));
        assert_eq!([wrong[0], wrong[3]], [release[0], release[3]]);
    }

    /// Frequency ~ E^½, deflection ~ E⁻¹, decay ~ E β.
    #[test]
    fn half_widths_follow_from_the_parameters_as_a_damped_beam_says() {
        let bar = Bar::new();
        let (_, none) = bar.half_widths([0.0, 0.0], 0.0, |_| ());
        for (correlation, both) in [(0.0, 2.0_f64.sqrt()), (0.9, 3.8_f64.sqrt()), (-0.9, 0.2_f64.sqrt())] {
            let (at, all) = bar.half_widths([0.02, 0.02], correlation, |_| ());
            near(added([all, none], 0), WITHIN * 0.5 * 0.02 * at[0], 0.01);
            near(added([all, none], 1), WITHIN * 0.02 * at[1].abs(), 0.01);
            near(added([all, none], 3), WITHIN * both * 0.02 * at[3], 0.02);
        }
    }

    #[test]
    fn another_release_varies_as_those_that_were_fitted_or_by_half_of_a_single_one() {
        let of = |ramps: &[f64]| {
            let mut fitted = testing::fitted(LADDER[3], &[1e5, 0.1, 0.3], &[0.1, 0.1, 0.1], ramps);
            for (k, variance) in [1e-6, 4e-6, 7e-6].into_iter().enumerate().take(ramps.len()) {
                fitted.covariance[(3 + 2 * k, 3 + 2 * k)] = variance;
            }
            ramp_variance(&fitted, ramps.len())
        };
        // about their mean of 60 ms by −20, −10 and 30 ms; each is known by 2 ms, root mean square
        near(of(&[0.04, 0.05, 0.09]), 4e-6 + 14e-4 / 2.0, 1e-9);
        near(of(&[0.04]), 1e-6 + 0.02 * 0.02, 1e-9);
    }

    #[test]
    fn what_was_left_out_counts_by_its_root_mean_square() {
        let mut result = testing::report().results.remove(0);
        near(result.left_out_difference().unwrap(), (12.5e-4_f64).sqrt(), 1e-9);
        result.left_out.clear();
        assert_eq!(result.left_out_difference(), None);
    }

    /// Two recordings may decide by what they cost to describe, three by what is predicted of those left out.
    #[test]
    fn the_supported_law_is_that_of_the_least_criterion_until_two_remain_to_be_fitted() {
        let mut results = testing::report().results;
        results[1].left_out.iter_mut().flat_map(|row| &mut row.predictions).for_each(|p| p.difference *= 2.0);
        assert_eq!(supported_law(&results), 1);
        results.iter_mut().for_each(|result| result.joint.used = vec![0, 2, 1]);
        assert_eq!(supported_law(&results), 0);
    }
}
