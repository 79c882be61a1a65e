//! Warnings of a fit: a result that lies on its bound, that is less certain than it is large, or that recordings contradict.
//!
//! None of them is an error, since numbers were computed as asked; each stands in the report and in the table, beside the number.

use super::Report;
use super::ladder::LawResult;
use super::recorded::FreeVibration;
use si::Metre;

/// Reduced χ² of the recordings' static deflections above which they contradict each other: three standard deviations.
const CONTRADICTION: f64 = 9.0;
/// Standard deviations by which the frequencies of recordings may differ, and the relative difference that is always accepted.
const FREQUENCIES_APART: f64 = 4.0;
const SAME_FREQUENCY: f64 = 0.01;

/// All warnings of a report.
pub(super) fn warnings(report: &Report) -> Vec<String> {
    let of_laws = report
        .results
        .iter()
        .flat_map(|result| bound_warnings(result).into_iter().chain(uncertainty_warnings(report, result)));
    let (_, case_numbers) = super::page_cases(&report.page);
    let conditions = 0..case_numbers.iter().max().map_or(0, |last| last + 1);
    of_laws.chain(conditions.flat_map(|case| case_contradictions(report, &case_numbers, case))).collect()
}

/// Recordings of one case that contradict each other.
fn case_contradictions(report: &Report, case_numbers: &[usize], case: usize) -> Vec<String> {
    let recordings: Vec<usize> = (0..case_numbers.len()).filter(|k| case_numbers[*k] == case).collect();
    let settled: Vec<&[Metre]> = recordings.iter().map(|k| report.recorded[*k].settled.as_slice()).collect();
    let vibrations: Vec<FreeVibration> = recordings.iter().map(|k| report.measured[*k].vibration).collect();
    deflection_warning(&settled, report.page.sigma).into_iter().chain(frequency_warning(&vibrations)).collect()
}

fn bound_warnings(result: &LawResult) -> Vec<String> {
    let fitted = &result.joint.fitted;
    let warning = |name: &String| {
        format!(
            "{name} ({}) lies on an end of its range: it is not identified; widen its range or record another condition",
            fitted.law.name
        )
    };
    fitted.on_bounds.iter().map(warning).collect()
}

/// Parameters that the recordings do not determine: their standard deviation is as large as themselves.
fn uncertainty_warnings(report: &Report, result: &LawResult) -> Vec<String> {
    let fitted = &result.joint.fitted;
    let warning = |(p, quantity): (usize, &super::laws::Quantity)| {
        let scale = quantity.scale(report.page.range);
        let size = if scale.logarithmic { 1.0 } else { fitted.values[p].abs() };
        let percent = 100.0 * fitted.covariance[(p, p)].sqrt() / size;
        (percent >= 100.0 || percent.is_nan()).then(|| {
            let (name, law) = (scale.name, fitted.law.name);
            format!(
                "the standard deviation of {name} ({law}) is {percent:.0} % of it: the recordings do not determine it"
            )
        })
    };
    fitted.law.parameters.iter().enumerate().filter_map(warning).collect()
}

/// Static deflections (recordings × markers, m) that differ by more than the page's `sigma` (m) explains.
fn deflection_warning(settled: &[&[Metre]], sigma: Metre) -> Option<String> {
    let (recordings, markers) = (settled.len(), settled.first().map_or(0, |recording| recording.len()));
    if recordings < 2 || markers == 0 {
        return None;
    }
    let mean = |marker: usize| settled.iter().map(|recording| recording[marker]).sum::<f64>() / recordings as f64;
    let square = |marker: usize| {
        settled.iter().map(|recording| ((recording[marker] - mean(marker)) / sigma).powi(2)).sum::<f64>()
    };
    let chi = (0..markers).map(square).sum::<f64>() / (markers * (recordings - 1)) as f64;
    (chi > CONTRADICTION).then(|| {
        format!(
            "the recordings contradict each other: their static deflections differ by {:.1} times `sigma` = {sigma} m",
            chi.sqrt()
        )
    })
}

/// Frequencies that differ by more than their standard deviations explain.
fn frequency_warning(vibrations: &[FreeVibration]) -> Option<String> {
    let by_frequency = |a: &&FreeVibration, b: &&FreeVibration| a.frequency.total_cmp(&b.frequency);
    let (low, high) = (vibrations.iter().min_by(by_frequency)?, vibrations.iter().max_by(by_frequency)?);
    let difference = high.frequency - low.frequency;
    let explained = FREQUENCIES_APART * low.frequency_sigma.hypot(high.frequency_sigma);
    (difference > explained.max(SAME_FREQUENCY * low.frequency)).then(|| {
        format!(
            "the recordings contradict each other: they vibrate at {:.2} to {:.2} Hz",
            low.frequency, high.frequency
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_that_differ_by_more_than_their_noise_contradict_each_other() {
        let sigma = 1e-4;
        assert_eq!(deflection_warning(&[&[-6.4e-3, -6.5e-3], &[-6.5e-3, -6.4e-3]], sigma), None);
        let apart = deflection_warning(&[&[-6.4e-3, -6.5e-3], &[-7.4e-3, -7.5e-3]], sigma);
        assert!(apart.is_some_and(|warning| warning.contains("7.1 times")));
        assert_eq!(deflection_warning(&[&[-6.4e-3]], sigma), None, "one recording contradicts nothing");
    }

    #[test]
    fn frequencies_beyond_their_deviations_contradict_each_other() {
        let at = |frequency| FreeVibration { frequency, frequency_sigma: 0.01, decay: 2.0, lowest: -1e-2, when: 0.07 };
        assert_eq!(frequency_warning(&[at(7.70), at(7.75)]), None);
        assert!(frequency_warning(&[at(7.70), at(8.40)]).is_some_and(|warning| warning.contains("7.70 to 8.40 Hz")));
    }

    #[test]
    fn a_report_warns_of_bounds_of_uncertain_parameters_and_of_recordings_of_one_case() {
        let report = super::super::testing::report();
        let found = warnings(&report);
        // a and b settle 1 mm apart, which is 7.1 times `sigma` from their mean; c has a case of its own
        let should = [
            "youngs_modulus (elastic_beta) lies on an end",
            "the standard deviation of stiffness_damping (elastic_beta) is 120 % of it",
            "their static deflections differ by 7.1 times `sigma` = 0.0001 m",
            "they vibrate at 7.00 to 8.00 Hz",
        ];
        assert_eq!(found.len(), should.len(), "{found:?}");
        assert!(found.iter().zip(should).all(|(found, should)| found.contains(should)), "{found:?}");
    }

    #[test]
    fn recordings_of_the_last_case_are_compared_too() {
        let mut report = super::super::testing::report();
        report.page.recording.rotate_right(1);
        report.recorded.rotate_right(1);
        report.measured.rotate_right(1);
        let found = warnings(&report);
        assert_eq!(found.iter().filter(|warning| warning.contains("contradict")).count(), 2, "{found:?}");
    }
}
