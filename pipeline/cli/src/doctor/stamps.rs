//! How each log is sampled and what is made of it: rate, jitter, gaps, times that do not rise, a clock that changes its rate.

use std::f64::consts::PI;
use std::path::Path;

use lab::card::Experiment;
use lab::log::{Method, RateChange, Sampling, StampReport};
use si::Hertz;

use super::finding::Finding;

/// Least part of the amplitude of the beat that the averaging of a slow amplifier may leave.
const KEPT: f64 = 0.95;

/// How a log is read, and everything in its stamps that must be or may be looked after.
pub(crate) fn stamp_findings(log_path: &str, report: &StampReport) -> Vec<Finding> {
    let longest_gap = report.sampling.as_ref().map_or(f64::NAN, |sampling| sampling.longest_gap_s);
    let faults = report.faults.iter().map(|fault| Finding::from(fault.in_file(Path::new(log_path), longest_gap)));
    let summary =
        report.sampling.as_ref().map(|sampling| sampling_summary(log_path, sampling, report.faults.is_empty()));
    let rate_change = report.rate_change.map(|change| rate_change_note(log_path, &change));
    let spikes = report.sampling.iter().flat_map(|sampling| &sampling.spikes);
    let spikes = spikes.map(|spike| spike_note(log_path, spike));
    summary.into_iter().chain(faults).chain(rate_change).chain(spikes).collect()
}

fn sampling_summary(log_path: &str, sampling: &Sampling, is_sound: bool) -> Finding {
    let ms = |s: f64| format!("{:.2} ms", 1e3 * s);
    let Sampling { samples, rate_hz, jitter_rms_s, jitter_s, jitter_line, longest_step_s, .. } = sampling;
    let jitter = format!("{} rms, {} on line {jitter_line}", ms(*jitter_rms_s), ms(*jitter_s));
    let step = format!("{} of {} allowed", ms(*longest_step_s), ms(sampling.longest_gap_s));
    let summary = format!("{log_path}: {samples} samples at {rate_hz:.2} Hz, jitter {jitter}, longest step {step}");
    Finding::log(summary, if is_sound { reading_method(sampling) } else { "it is refused".to_owned() })
}

/// What is made of a log.
fn reading_method(sampling: &Sampling) -> String {
    let largest_bound = |b: &lab::log::InterpolationBound| format!("{:.2e} rms in {}", b.rms, b.column);
    let bounds: Vec<String> = sampling.bounds.iter().map(largest_bound).collect();
    match sampling.method {
        Method::AsStamped => "it is read as stamped".to_owned(),
        Method::EvenSampling => {
            let evidence = "its pressures or forces go smoothly from sample to sample and zigzag over their stamps";
            format!(
                "its samples were taken evenly and stamped late ({evidence}): they are read on the line through the stamps"
            )
        }
        Method::LinearInterpolation => {
            format!("it is interpolated linearly onto an even clock, within {}", bounds.join(", "))
        }
    }
}

fn rate_change_note(log_path: &str, change: &RateChange) -> Finding {
    let [before, after] = change.rates;
    let defect = format!("{log_path}, line {}: the rate goes from {before:.2} to {after:.2} Hz", change.line);
    let reason = "times are taken as they are stamped; if the clock was at fault, all after it is late or early";
    Finding::note(defect, reason, "check the clock against the lamp's edges, or log with a crystal clock")
}

fn spike_note(log_path: &str, spike: &lab::log::Spike) -> Finding {
    let reason = "an amplifier gives such numbers between readings; the line between its neighbours stands for it";
    Finding::note(format!("{log_path}, {spike}"), reason, "leave it, or look at the wiring of the amplifier")
}

/// An amplifier that averages over its step flattens the beat of a flapping trial.
pub(crate) fn slow_amplifier(log_path: &str, rate: Hertz, experiment: &Experiment) -> Option<Finding> {
    let Experiment::Flapping { frequency, .. } = experiment else { return None };
    let phase = PI * frequency / rate;
    let attenuation = if phase < PI { phase.sin() / phase } else { 0.0 };
    (attenuation < KEPT).then(|| {
        let defect = format!("{log_path} has {rate:.1} samples a second for a beat of {frequency} Hz");
        let reason = format!(
            "a mean over a step leaves {:.0} % of its amplitude; its mean over cycles is exact",
            100.0 * attenuation
        );
        Finding::note(defect, reason, "set the amplifier to a higher rate if the force within a cycle is wanted")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The note about an amplifier of a rate (Hz) at a beat of 2 Hz.
    fn at(rate: Hertz) -> Option<String> {
        let experiment =
            Experiment::Flapping { channels: vec!["left".into()], amplitude: 2e4, frequency: 2.0, cycles: 10 };
        slow_amplifier("force.csv", rate, &experiment).map(|finding| finding.to_string())
    }

    /// A mean over a step of 1/r leaves sin(π f/r) / (π f/r) of a beat of f.
    #[test]
    fn an_amplifier_is_slow_where_it_leaves_less_than_95_percent_of_the_beat() {
        assert_eq!([80.0, 12.0].map(at), [None, None], "95.5 % at a sixth");
        assert!(at(11.0).is_some_and(|said| said.contains("leaves 95 %") && said.contains("11.0 samples a second")));
        assert!(at(4.0).is_some_and(|said| said.contains("leaves 64 %")), "2/π of two samples a cycle");
        assert!([2.0, 1.0, 0.9].iter().all(|rate| at(*rate).is_some_and(|said| said.contains("leaves 0 %"))));
        let stairs = Experiment::Staircase { channels: Vec::new(), levels: Vec::new(), hold: 1.0, pause: 1.0 };
        assert!(slow_amplifier("force.csv", 1.0, &stairs).is_none(), "a staircase has no beat");
    }
}
