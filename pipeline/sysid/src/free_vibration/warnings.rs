//! Warnings of a fit: a result that lies on its bound, that is less certain than it is large, or that recordings contradict.
//!
//! None of them is an error, since numbers were computed as asked; each stands in the report and in the table, beside the number.

use super::recorded::FreeVibration;
use super::{ByLaw, Report};
use si::{Metre, Pascal};

/// Relative distance below which a modulus counts as lying on its bound; the search ends within 1e-5.
const ON_BOUND: f64 = 1e-4;
/// Reduced χ² of the recordings' static deflections above which they contradict each other: three standard deviations.
const CONTRADICTION: f64 = 9.0;
/// Standard deviations by which the frequencies of recordings may differ, and the relative difference that is always accepted.
const FREQUENCIES_APART: f64 = 4.0;
const SAME_FREQUENCY: f64 = 0.01;

/// All warnings of a report.
pub(super) fn warnings(report: &Report) -> Vec<String> {
    let range = report.page.range;
    let of_laws = report.laws.iter().flat_map(|law| [bound(law, range), uncertain(law)]);
    let settled: Vec<&[Metre]> = report.recorded.iter().map(|recorded| recorded.settled.as_slice()).collect();
    of_laws.chain([deflections(&settled, report.page.sigma), frequencies(&report.vibrations)]).flatten().collect()
}

/// Whether a modulus lies on an end of its range.
pub(super) fn on_bound(youngs_modulus: Pascal, range: [Pascal; 2]) -> bool {
    range.iter().any(|end| (youngs_modulus / end - 1.0).abs() < ON_BOUND)
}

fn bound(law: &ByLaw, range: [Pascal; 2]) -> Option<String> {
    let [low, high] = range.map(|end| 1e-3 * end);
    let name = &law.law;
    on_bound(law.found.youngs_modulus, range).then(|| {
        format!("Young's modulus ({name}) lies on an end of its range, {low} to {high} kPa: it is not identified; widen `range`")
    })
}

fn uncertain(law: &ByLaw) -> Option<String> {
    let (name, percent) = (&law.law, 100.0 * law.found.sigma);
    (law.found.sigma >= 1.0).then(|| {
        format!("the standard deviation of Young's modulus ({name}) is {percent:.0} % of it: the recordings do not determine it")
    })
}

/// Static deflections (recordings × markers, m) that differ by more than the page's `sigma` (m) explains.
fn deflections(settled: &[&[Metre]], sigma: Metre) -> Option<String> {
    let (recordings, markers) = (settled.len(), settled.first().map_or(0, |of| of.len()));
    if recordings < 2 || markers == 0 {
        return None;
    }
    let mean = |marker: usize| settled.iter().map(|of| of[marker]).sum::<f64>() / recordings as f64;
    let square = |marker: usize| settled.iter().map(|of| ((of[marker] - mean(marker)) / sigma).powi(2)).sum::<f64>();
    let chi = (0..markers).map(square).sum::<f64>() / (markers * (recordings - 1)) as f64;
    (chi > CONTRADICTION).then(|| {
        format!(
            "the recordings contradict each other: their static deflections differ by {:.1} times `sigma` = {sigma} m",
            chi.sqrt()
        )
    })
}

/// Frequencies that differ by more than their standard deviations explain.
fn frequencies(vibrations: &[FreeVibration]) -> Option<String> {
    let by_frequency = |a: &&FreeVibration, b: &&FreeVibration| a.frequency.total_cmp(&b.frequency);
    let (low, high) = (vibrations.iter().min_by(by_frequency)?, vibrations.iter().max_by(by_frequency)?);
    let apart = high.frequency - low.frequency;
    let explained = FREQUENCIES_APART * low.frequency_sigma.hypot(high.frequency_sigma);
    (apart > explained.max(SAME_FREQUENCY * low.frequency)).then(|| {
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
    fn a_modulus_on_its_bound_is_found_and_one_beside_it_is_not() {
        assert!(on_bound(3e5, [3e5, 2e6]) && on_bound(1.99999e6, [3e5, 2e6]));
        assert!(!on_bound(3.01e5, [3e5, 2e6]));
    }

    #[test]
    fn recordings_that_differ_by_more_than_their_noise_contradict_each_other() {
        let sigma = 1e-4;
        assert_eq!(deflections(&[&[-6.4e-3, -6.5e-3], &[-6.5e-3, -6.4e-3]], sigma), None);
        let apart = deflections(&[&[-6.4e-3, -6.5e-3], &[-7.4e-3, -7.5e-3]], sigma);
        assert!(apart.is_some_and(|warning| warning.contains("7.1 times")));
        assert_eq!(deflections(&[&[-6.4e-3]], sigma), None, "one recording contradicts nothing");
    }

    #[test]
    fn frequencies_beyond_their_deviations_contradict_each_other() {
        let at = |frequency| FreeVibration { frequency, frequency_sigma: 0.01, decay: 2.0, lowest: -1e-2, when: 0.07 };
        assert_eq!(frequencies(&[at(7.70), at(7.75)]), None);
        assert!(frequencies(&[at(7.70), at(8.40)]).is_some_and(|warning| warning.contains("7.70 to 8.40 Hz")));
    }
}
