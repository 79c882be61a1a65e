//! How a log is sampled: rate, jitter, gaps, times that do not rise, and a clock whose rate changes.

use serde::{Deserialize, Serialize};
use si::{Hertz, Second};

use super::parabola::solve_normal;
use super::spikes::Spike;

/// A log whose stamps all lie within this share of a step from an even clock is taken as even: stamps are rounded.
const EVEN: f64 = 0.01;
/// Median steps beyond which a step is a gap where the card does not say.
const GAP: f64 = 3.0;
/// Jitter of up to half a sample is normal, so that no step of up to one and a half is a gap.
const LEAST_GAP: f64 = 1.5;
/// Least change of a clock's rate that is reported, no unit: ten times the drift of a poor crystal.
const LEAST_CHANGE: f64 = 1e-3;
/// A change of rate is reported where it exceeds so many of its standard deviations.
const DEVIATIONS: f64 = 6.0;
/// Places at which a change of rate is searched for.
const PLACES: usize = 200;
/// Fewer samples do not determine a change of rate.
const FEWEST: usize = 50;

/// How the samples of a log lie in time, and what was made of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// Number of samples.
    pub samples: usize,
    /// Mean sampling rate, that of the even clock, Hz.
    pub rate_hz: Hertz,
    /// Root mean square departure of the stamps from the even clock, s.
    pub jitter_rms_s: Second,
    /// Largest one, s.
    pub jitter_s: Second,
    /// The line on which it stands.
    pub jitter_line: usize,
    /// Longest time between two samples, s.
    pub longest_step_s: Second,
    /// The line at its end.
    pub longest_step_line: usize,
    /// A longer one is a gap, s.
    pub longest_gap_s: Second,
    /// What was made of the samples.
    pub method: Method,
    /// Error bound of the interpolation, a line a column; none of a log that is read as stamped.
    pub bounds: Vec<InterpolationBound>,
    /// Samples that are no readings: each is taken from the line between its neighbours.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spikes: Vec<Spike>,
}

/// What is made of the samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The stamps are those of an even clock.
    #[default]
    AsStamped,
    /// Linear interpolation between the stamped samples, onto the even clock from the first to the last; commands from the nearest one.
    LinearInterpolation,
    /// The samples were taken evenly and stamped late: they stay what they are, on the line through their stamps.
    EvenSampling,
}

/// Bound h²/8 |f″| of linear interpolation over each step h; f″ from divided differences of three samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InterpolationBound {
    /// The column.
    pub column: String,
    /// Root mean square over the steps, unit of the column.
    pub rms: f64,
    /// Largest, unit of the column.
    pub max: f64,
}

/// Something in the stamps of a log, with its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampFault {
    /// The line of the later sample, from 1.
    pub line: usize,
    /// Time of the sample before, s.
    pub before: Second,
    /// Its own time, s.
    pub time: Second,
    /// What it is.
    pub kind: StampFaultKind,
}

/// What is wrong with a stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampFaultKind {
    /// No sample for longer than the longest gap.
    Gap,
    /// The time of the sample before.
    Repeated,
    /// Before the time of the sample before.
    Backward,
}

/// A change of the clock's rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateChange {
    /// The line from which on it holds.
    pub line: usize,
    /// Rate before and after, Hz.
    pub rates: [Hertz; 2],
}

/// Times (s) of the samples of a log, and the line of each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stamps<'a> {
    pub times: &'a [Second],
    pub lines: &'a [usize],
}

impl Stamps<'_> {
    fn time_steps(&self) -> impl Iterator<Item = Second> + '_ {
        self.times.windows(2).map(|t| t[1] - t[0])
    }

    /// The median time between two samples that rise, s.
    fn median_step(&self) -> Second {
        let mut steps: Vec<Second> = self.time_steps().filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len().saturating_sub(1) / 2).copied().unwrap_or(f64::INFINITY)
    }

    /// The longest step that is no gap, s.
    pub(crate) fn longest_gap(&self, card: Option<Second>) -> Second {
        let step = self.median_step();
        card.unwrap_or(GAP * step).max(LEAST_GAP * step)
    }

    /// Every gap, repeated and backward time, in the order of the lines.
    pub(crate) fn faults(&self, longest_gap: Second) -> Vec<StampFault> {
        let kind = |step: Second| match step {
            0.0 => Some(StampFaultKind::Repeated),
            step if step < 0.0 => Some(StampFaultKind::Backward),
            // rounded stamps of a step that is exactly as long as the limit are no gap
            step if step > longest_gap * (1.0 + 1e-6) => Some(StampFaultKind::Gap),
            _ => None,
        };
        let fault = |(i, pair): (usize, &[Second])| {
            let kind = kind(pair[1] - pair[0])?;
            Some(StampFault { line: self.lines[i + 1], before: pair[0], time: pair[1], kind })
        };
        self.times.windows(2).enumerate().filter_map(fault).collect()
    }

    /// The sampling of at least two rising stamps.
    pub(crate) fn sampling(&self, longest_gap_s: Second) -> Sampling {
        let last = self.times.len() - 1;
        let step = (self.times[last] - self.times[0]) / last as f64;
        let deviation = |i: usize| (self.times[i] - self.times[0] - step * i as f64).abs();
        let worst = (0..=last).max_by(|a, b| deviation(*a).total_cmp(&deviation(*b))).unwrap_or(0);
        let longest = (0..last).max_by(|a, b| self.time_step(*a).total_cmp(&self.time_step(*b))).unwrap_or(0);
        let sum_of_squares: f64 = (0..=last).map(|i| deviation(i).powi(2)).sum();
        Sampling {
            samples: last + 1,
            rate_hz: 1.0 / step,
            jitter_rms_s: (sum_of_squares / (last + 1) as f64).sqrt(),
            jitter_s: deviation(worst),
            jitter_line: self.lines[worst],
            longest_step_s: self.time_step(longest),
            longest_step_line: self.lines[longest + 1],
            longest_gap_s,
            method: if deviation(worst) <= EVEN * step { Method::AsStamped } else { Method::LinearInterpolation },
            bounds: Vec::new(),
            spikes: Vec::new(),
        }
    }

    fn time_step(&self, i: usize) -> Second {
        self.times[i + 1] - self.times[i]
    }

    /// Where the clock's rate changes, if it does: the continuous pair of lines through the stamps with the least residual, where its
    /// change of slope is significant.
    pub(crate) fn rate_change(&self) -> Option<RateChange> {
        let count = self.times.len();
        if count < FEWEST {
            return None;
        }
        let candidates = (1..PLACES).map(|k| k * count / PLACES).filter(|k| (10..count - 10).contains(k));
        let bends = candidates.filter_map(|k| Some((k, self.fit_bend(k)?)));
        let (k, bend) = bends.min_by(|a, b| a.1.residual.total_cmp(&b.1.residual))?;
        let [slope, change] = bend.slopes;
        let is_significant = change.abs() > LEAST_CHANGE * slope && change.abs() > DEVIATIONS * bend.sigma;
        is_significant.then(|| RateChange { line: self.lines[k], rates: [1.0 / slope, 1.0 / (slope + change)] })
    }

    /// Least squares of a + b i + c max(i − k, 0), i the sample.
    fn fit_bend(&self, k: usize) -> Option<Bend> {
        let centre = 0.5 * (self.times.len() - 1) as f64;
        let columns = |i: usize| [1.0, i as f64 - centre, i.saturating_sub(k) as f64];
        let mut normal = [[0.0; 4]; 3];
        for (i, time) in self.times.iter().enumerate() {
            let (row, value) = (columns(i), time - self.times[0]);
            for a in 0..3 {
                (0..3).for_each(|b| normal[a][b] += row[a] * row[b]);
                normal[a][3] += row[a] * value;
            }
        }
        let (solution, inverse) = solve_normal(normal)?;
        let fitted_time = |i: usize| columns(i).iter().zip(solution).map(|(c, s)| c * s).sum::<f64>();
        let sum_of_squares: f64 =
            self.times.iter().enumerate().map(|(i, t)| (t - self.times[0] - fitted_time(i)).powi(2)).sum();
        let sigma = (sum_of_squares / (self.times.len() - 3) as f64 * inverse).sqrt();
        Some(Bend { residual: sum_of_squares, slopes: [solution[1], solution[2]], sigma })
    }
}

/// Two lines that meet at a sample.
struct Bend {
    /// Sum of squares, s².
    residual: f64,
    /// The first slope and its change, s a sample.
    slopes: [f64; 2],
    /// Standard deviation of the change.
    sigma: f64,
}
