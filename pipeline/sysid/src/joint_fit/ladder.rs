//! Every law fitted to all conditions, and to all but each; the law that predicts what was left out is supported.

use rayon::prelude::*;

use super::fit::{Fit, Fitted, Which};
use super::laws::Law;
use super::test::{Predicted, Test};
use diagnostics::Result;

/// A prediction of one condition, or why there is none.
pub(super) type Prediction = std::result::Result<Vec<(Predicted, f64)>, String>;

/// Everything that is known of one law.
pub(super) struct LawResult {
    pub law: &'static Law,
    /// Fitted to the conditions `used`.
    pub joint: Fitted,
    pub used: Vec<Which>,
    /// What the joint fit says of every condition, by test and condition.
    pub all: Vec<Vec<Prediction>>,
    /// What a fit to the others says of each condition that is fitted.
    pub left_out: Vec<(Which, Prediction)>,
}

/// The tests of a page.
pub(super) struct Bench<'a> {
    pub tests: &'a [Box<dyn Test>],
    /// Names of conditions that are never fitted.
    pub held_out: &'a [String],
    /// Says what is being done.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

impl Bench<'_> {
    /// Conditions that are fitted.
    pub fn used(&self) -> Vec<Which> {
        let mut used = Vec::new();
        for (t, test) in self.tests.iter().enumerate() {
            for (c, condition) in test.conditions().iter().enumerate() {
                if condition.fitted && !self.held_out.contains(&condition.name) {
                    used.push((t, c));
                }
            }
        }
        used
    }

    /// The results of a law, or why there are none.
    pub(crate) fn law_results(&self, laws: &[&'static Law]) -> Vec<(&'static Law, Result<LawResult>)> {
        laws.par_iter().map(|law| (*law, self.law_result(law))).collect()
    }

    fn law_result(&self, law: &'static Law) -> Result<LawResult> {
        let (fit, used) = (Fit { law, tests: self.tests }, self.used());
        let joint = fit.run(fit.start(), &used)?;
        (self.progress)(&format!(
            "{:<18} fitted to {} conditions, {} evaluations",
            law.name,
            used.len(),
            joint.evaluations
        ));
        let mut memory = joint.memory.clone();
        let mut predict = |t: usize| -> Vec<Prediction> {
            (0..self.tests[t].conditions().len())
                .map(|c| prediction_interval(&fit, &joint, (t, c), &mut memory))
                .collect()
        };
        let predictions = (0..self.tests.len()).map(&mut predict).collect();
        let leave_one_out = |omitted: &Which| {
            let remaining: Vec<Which> = used.iter().copied().filter(|which| which != omitted).collect();
            let start = super::fit::Start {
                point: joint.point.clone(),
                scales: joint.scales.clone(),
                memory: joint.memory.clone(),
                rounds: 1,
            };
            let predicted = fit
                .run(start, &remaining)
                .map_err(|error| error.to_string())
                .and_then(|fitted| prediction_interval(&fit, &fitted, *omitted, &mut fitted.memory.clone()));
            (self.progress)(&format!("{:<18} {}", law.name, self.left_out_text(*omitted, &predicted)));
            (*omitted, predicted)
        };
        let left_out = if used.len() > 1 { used.par_iter().map(leave_one_out).collect() } else { Vec::new() };
        Ok(LawResult { law, joint, used, all: predictions, left_out })
    }
}

impl Bench<'_> {
    /// A condition that was left out, with the errors of its prediction in per cent.
    fn left_out_text(&self, (t, c): Which, prediction: &Prediction) -> String {
        let condition = &self.tests[t].conditions()[c];
        let error = |(quantity, (predicted, _)): (&super::test::Quantity, &(Predicted, f64))| {
            Some(format!("{:+.1}", 100.0 * (predicted.value / quantity.measured? - 1.0)))
        };
        match prediction {
            Ok(values) => {
                let errors: Vec<String> = condition.quantities.iter().zip(values).filter_map(error).collect();
                format!("predicted {}, left out: errors of {} %", condition.name, errors.join(", "))
            }
            Err(cause) => format!("does not predict {}: {}", condition.name, cause.lines().next().unwrap_or_default()),
        }
    }
}

/// The quantities of a condition with the half widths of their intervals.
fn prediction_interval(fit: &Fit, fitted: &Fitted, which: Which, memory: &mut super::test::Memory) -> Prediction {
    let (t, c) = which;
    let predicted = fit.predict_condition(&fitted.point, (t, c), memory).map_err(|error| error.to_string())?;
    let quantities = &fit.tests[t].conditions()[c].quantities;
    let with_width = |(predicted, quantity): (Predicted, &super::test::Quantity)| {
        let width = fitted.half_width(&predicted, (t, quantity.sigma));
        (predicted, width)
    };
    Ok(predicted.into_iter().zip(quantities).map(with_width).collect())
}

impl LawResult {
    /// The mean square of the errors of each condition that was left out, over the deviations by which a good model misses; none where one is
    /// not predicted.
    pub fn scores(&self, tests: &[Box<dyn Test>]) -> Option<Vec<f64>> {
        let score = |((t, c), prediction): &(Which, Prediction)| {
            let quantities = &tests[*t].conditions()[*c].quantities;
            let predicted = prediction.as_ref().ok()?;
            let errors: Vec<f64> = quantities
                .iter()
                .zip(predicted)
                .filter_map(|(quantity, (predicted, _))| {
                    Some(((predicted.value / quantity.measured? - 1.0) / quantity.sigma).powi(2))
                })
                .collect();
            Some(errors.iter().sum::<f64>() / errors.len() as f64)
        };
        self.left_out.iter().map(score).collect()
    }
}

/// The plainest law within one standard error of the one that predicts best what was left out: of the mean over conditions of the logarithm
/// of the mean square error, paired by condition with the best law's, so that one bad condition does not decide.
pub(super) fn supported_law(results: &[LawResult], tests: &[Box<dyn Test>]) -> Option<usize> {
    let scores: Vec<Option<Vec<f64>>> = results.iter().map(|result| result.scores(tests)).collect();
    // One is added, which a good model misses by: without it a condition that is met by chance would decide by the
    // logarithm of almost nothing.
    let logarithms = |scores: &Vec<f64>| -> Vec<f64> { scores.iter().map(|score| (1.0 + score).ln()).collect() };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let law_logarithms: Vec<(usize, Vec<f64>)> =
        scores.iter().enumerate().filter_map(|(k, scores)| Some((k, logarithms(scores.as_ref()?)))).collect();
    let (_, best) = law_logarithms.iter().min_by(|a, b| mean(&a.1).total_cmp(&mean(&b.1)))?;
    let within_error = |scores: &Vec<f64>| {
        let differences: Vec<f64> = scores.iter().zip(best).map(|(score, best)| score - best).collect();
        let (centre, count) = (mean(&differences), differences.len() as f64);
        let scatter: f64 = differences.iter().map(|difference| (difference - centre).powi(2)).sum();
        centre <= (scatter / (count - 1.0).max(1.0) / count).sqrt()
    };
    law_logarithms.iter().find(|(_, scores)| within_error(scores)).map(|(k, _)| *k)
}
