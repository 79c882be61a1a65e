//! Edges of a two-level signal, to a fraction of a sample.
//!
//! A camera's sample is a mean over its exposure, so a lamp that lights during an exposure gives an intermediate level, from which the
//! time of the edge follows. A log's sample is an instant: the edge is then placed half way between two samples.

use si::{Second, Series};

/// The averaging window of a sample at time t: the mean over t − `lead` … t − `lead` + `width`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// How long before the sample's time it begins, s.
    pub lead: Second,
    /// How long it lasts, s; 0 for an instant.
    pub width: Second,
}

impl Window {
    /// An instantaneous sample, as a log's.
    pub const INSTANT: Self = Self { lead: 0.0, width: 0.0 };

    /// A sample whose time is the start of an exposure of `width` (s), as a camera's.
    pub fn exposure(width: Second) -> Self {
        Self { lead: 0.0, width }
    }
}

/// Why edges cannot be located.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum EdgeError {
    /// One level only, or too much noise.
    #[error(
        "the signal does not have two levels\n  why: they would be {low:.4} and {high:.4} with a noise of {noise:.4}; the difference must be {limit} times the noise\n  do:  check that the disc covers the lamp, or that the column is the lamp's"
    )]
    NoLevels {
        /// Lower level, in the signal's unit.
        low: f64,
        /// Upper level.
        high: f64,
        /// Scatter within the levels.
        noise: f64,
        /// How many times the noise the levels must lie apart.
        limit: f64,
    },
    /// A window that overlaps the next.
    #[error(
        "an exposure of {width} s does not fit\n  why: a sample is taken every {period} s\n  do:  correct the exposure"
    )]
    Overlap {
        /// Width of the window, s.
        width: Second,
        /// Time from sample to sample, s.
        period: Second,
    },
}

/// Times (s) at which the signal goes from its lower to its upper level.
///
/// # Errors
/// [`EdgeError`] when the signal has no two levels or the window does not fit between samples.
pub fn rising(signal: &Series, window: Window) -> Result<Vec<Second>, EdgeError> {
    Ok(edges(signal, window)?.into_iter().filter(|e| e.up).map(|e| e.time).collect())
}

/// Times (s) at which the signal goes from its upper to its lower level.
///
/// # Errors
/// [`EdgeError`] when the signal has no two levels or the window does not fit between samples.
pub fn falling(signal: &Series, window: Window) -> Result<Vec<Second>, EdgeError> {
    Ok(edges(signal, window)?.into_iter().filter(|e| !e.up).map(|e| e.time).collect())
}

/// One edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// When, s.
    pub time: Second,
    /// Whether to the upper level.
    pub up: bool,
    /// Standard deviation of its time, s.
    pub sigma: Second,
}

/// Least difference of the two levels, as a multiple of their scatter.
const LEVELS_APART: f64 = 6.0;
/// Within this share of the difference from a level, a sample counts as that level: lamps flicker by a level or two of 255.
const NEAR: f64 = 0.02;

/// Least uncertainty of a level, as a share of the difference: half a quantisation step of 200.
const LEVEL: f64 = 2.5e-3;

/// All edges in the order of time.
///
/// # Errors
/// [`EdgeError`] when the signal has no two levels or the window does not fit between samples.
pub fn edges(signal: &Series, window: Window) -> Result<Vec<Edge>, EdgeError> {
    let times: Vec<Second> = (0..signal.values().len()).map(|k| signal.time(k)).collect();
    edges_at(&times, signal.values(), |_| window)
}

/// All edges of samples `values` at uneven `times` (s), in their order; `window` gives the window of sample k.
///
/// # Errors
/// As [`edges`].
pub fn edges_at(times: &[Second], values: &[f64], window: impl Fn(usize) -> Window) -> Result<Vec<Edge>, EdgeError> {
    for (k, pair) in times.windows(2).enumerate() {
        let (width, period) = (window(k).width, pair[1] - pair[0]);
        // An exposure of the whole period, a shutter of 360°, must pass although times of frames are rounded.
        if !(0.0..=period * (1.0 + 1e-9)).contains(&width) {
            return Err(EdgeError::Overlap { width, period });
        }
    }
    let Levels { low, high, noise } = signal_levels(values)?;
    let share: Vec<f64> = values.iter().map(|v| ((v - low) / (high - low)).clamp(0.0, 1.0)).collect();
    let flicker = noise / (high - low);
    let upper: Vec<bool> = share.iter().map(|&s| s >= 0.5).collect();
    let crossings = (1..share.len()).filter(|&i| upper[i] != upper[i - 1]);
    let normalised = NormalisedSignal { times, share: &share, window: &window, flicker };
    let edge = |i: usize| {
        let (time, sigma) = normalised.edge_crossing(i);
        Edge { time, up: upper[i], sigma }
    };
    Ok(crossings.map(edge).collect())
}

/// A signal scaled so that its lower level is 0 and its upper level 1.
struct NormalisedSignal<'a> {
    /// Times of the samples, s.
    times: &'a [Second],
    /// Value of each sample, no unit.
    share: &'a [f64],
    /// The averaging window of each sample.
    window: &'a dyn Fn(usize) -> Window,
    /// Scatter within the levels, no unit.
    flicker: f64,
}

impl NormalisedSignal<'_> {
    /// The time of the edge between samples `i` − 1 and `i`, which lie on different sides of the mean level.
    ///
    /// The sample that lies between the levels has the edge inside its window, a share of the new level before the window's
    /// end. Without such a sample the edge lies between the two windows and is placed half way. The second value is the standard
    /// deviation: from the flicker of the level, or that of a uniform distribution over the gap.
    fn edge_crossing(&self, i: usize) -> (Second, Second) {
        let Self { times, share, window, flicker } = *self;
        let new_level_share = |k: usize| if share[i] >= 0.5 { share[k] } else { 1.0 - share[k] };
        let exposure_start = |k: usize| times[k] - window(k).lead;
        let nearest = if (share[i - 1] - 0.5).abs() < (share[i] - 0.5).abs() { i - 1 } else { i };
        if (NEAR..=1.0 - NEAR).contains(&share[nearest]) {
            let width = window(nearest).width;
            (exposure_start(nearest) + (1.0 - new_level_share(nearest)) * width, flicker.hypot(LEVEL) * width)
        } else {
            let (gap_start, gap_end) = (exposure_start(i - 1) + window(i - 1).width, exposure_start(i));
            let gap_width = gap_end - gap_start + NEAR * (window(i - 1).width + window(i).width);
            (0.5 * (gap_start + gap_end), gap_width / 12.0_f64.sqrt())
        }
    }
}

/// Two levels and the scatter within them.
struct Levels {
    low: f64,
    high: f64,
    noise: f64,
}

/// The two levels: medians of the samples on either side of the middle, those in mid edge left out.
fn signal_levels(values: &[f64]) -> Result<Levels, EdgeError> {
    let minimum = values.iter().copied().fold(f64::INFINITY, f64::min);
    let maximum = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut low, mut high) = (minimum, maximum);
    for _ in 0..3 {
        let quarter = 0.25 * (high - low);
        low = upper_median(values.iter().copied().filter(|&v| v <= low + quarter)).unwrap_or(low);
        high = upper_median(values.iter().copied().filter(|&v| v >= high - quarter)).unwrap_or(high);
    }
    let midpoint = 0.5 * (low + high);
    let deviations = values.iter().map(|&v| (v - if v < midpoint { low } else { high }).abs());
    // The median absolute deviation, 1/1.4826 of σ for a normal distribution: samples in mid edge would dominate a
    // standard deviation, and the more so the faster the lamp blinks.
    let noise = 1.4826 * upper_median(deviations).unwrap_or(0.0);
    if high - low > LEVELS_APART * noise && high > low {
        Ok(Levels { low, high, noise })
    } else {
        Err(EdgeError::NoLevels { low, high, noise, limit: LEVELS_APART })
    }
}

fn upper_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lamp of levels 12 and 210 that is lit from `on` to `off` (s), as the mean over each window.
    fn lamp(rate: f64, window: Window, on: f64, off: f64) -> Series {
        let lit = |t: f64| (t.clamp(on, off) - on) / (off - on) * (off - on);
        let value = |k: usize| {
            let begin = 0.5 + k as f64 / rate - window.lead;
            let share = match window.width {
                0.0 => f64::from(u8::from((on..off).contains(&begin))),
                width => (lit(begin + width) - lit(begin)) / width,
            };
            12.0 + 198.0 * share
        };
        Series::new(0.5, rate, (0..240).map(value).collect()).unwrap()
    }

    #[test]
    fn an_exposure_gives_the_edge_to_a_fraction_of_a_frame() {
        let window = Window::exposure(1.0 / 120.0);
        for k in 0..20 {
            let on = 1.0002 + 0.0004 * f64::from(k); // inside the exposure of the frame at 1.0 s, which ends at 1.0083
            let signal = lamp(60.0, window, on, 3.0213);
            let tolerance = NEAR / 120.0 + 1e-12;
            assert!((rising(&signal, window).unwrap()[0] - on).abs() < tolerance);
            assert!((falling(&signal, window).unwrap()[0] - 3.0213).abs() < 0.5 / 120.0 + 1e-9);
        }
    }

    #[test]
    fn an_edge_between_exposures_is_placed_half_way() {
        let window = Window::exposure(1.0 / 120.0);
        let signal = lamp(60.0, window, 1.0 + 1.3 / 120.0, 3.0);
        assert!((rising(&signal, window).unwrap()[0] - (1.0 + 1.5 / 120.0)).abs() < 1e-12);
    }

    #[test]
    fn exposures_without_a_gap_give_every_edge() {
        let window = Window { lead: 1.0 / 60.0, width: 1.0 / 60.0 };
        for k in 0..50 {
            let (on, off) = (1.0 + 0.0011 * f64::from(k), 3.0 + 0.0007 * f64::from(k));
            let found = edges(&lamp(60.0, window, on, off), window).unwrap();
            assert_eq!(found.len(), 2);
            assert!(
                (found[0].time - on).abs() < NEAR / 60.0 + 1e-12 && (found[1].time - off).abs() < NEAR / 60.0 + 1e-12
            );
        }
    }

    #[test]
    fn an_instantaneous_log_gives_the_edge_to_half_a_sample() {
        let found = edges(&lamp(200.0, Window::INSTANT, 0.9713, 1.2), Window::INSTANT).unwrap();
        assert!((found[0].time - 0.9713).abs() <= 0.0025 && found[0].up);
    }

    #[test]
    fn an_edge_lies_within_three_of_its_deviations_wherever_it_falls() {
        for (width, most) in [(0.0, 5e-3), (0.5 / 60.0, 3e-3), (1.0 / 60.0, 5e-4)] {
            let window = Window { lead: 0.5 * width, width };
            for k in 0..60 {
                let on = 1.0 + 0.00031 * f64::from(k);
                let edge = edges(&lamp(60.0, window, on, 3.1), window).unwrap()[0];
                // a uniformly distributed error reaches 1.74 deviations
                assert!((edge.time - on).abs() <= 1.75 * edge.sigma + 1e-12, "{width} {on}: {edge:?}");
                assert!(edge.sigma < most);
            }
        }
    }

    #[test]
    fn a_brighter_lamp_on_a_lighter_ground_has_the_same_edges_with_the_same_deviations() {
        let window = Window { lead: 0.5 / 60.0, width: 0.5 / 60.0 };
        let signal = lamp(60.0, window, 1.003, 3.1);
        let flickering = |ground: f64, gain: f64| {
            let value = |(k, v): (usize, &f64)| ground + gain * (v + if k % 2 == 0 { 3.0 } else { -3.0 });
            let values = signal.values().iter().enumerate().map(value).collect();
            edges(&Series::new(0.5, 60.0, values).unwrap(), window).unwrap()
        };
        for (dark, light) in flickering(0.0, 0.5).iter().zip(flickering(500.0, 2.0)) {
            assert!((dark.time - light.time).abs() < 1e-9 && (dark.sigma / light.sigma - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn uneven_frames_give_an_edge_by_their_own_times() {
        let times: Vec<f64> = (0..80).map(|k| f64::from(k) / 60.0 + 0.004 * (1.7 * f64::from(k)).sin()).collect();
        let width = 0.5 / 60.0;
        let on = times[31] + 0.3 * width;
        let level = |t: &f64| ((t + width - on) / width).clamp(0.0, 1.0) * 180.0 + 20.0;
        let values: Vec<f64> = times.iter().map(level).collect();
        let found = edges_at(&times, &values, |_| Window::exposure(width)).unwrap();
        assert!(found.len() == 1 && (found[0].time - on).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn noise_shifts_an_edge_by_no_more_than_its_own_size() {
        let window = Window::exposure(1.0 / 60.0);
        let clean = lamp(60.0, window, 1.0042, 3.1);
        let noisy = clean.values().iter().enumerate().map(|(i, v)| v + 2.0 * (i as f64 * 12.9898).sin()).collect();
        let noisy = Series::new(clean.start(), clean.rate(), noisy).unwrap();
        assert!((rising(&noisy, window).unwrap()[0] - 1.0042).abs() < 4.0 / 198.0 / 60.0 + NEAR / 60.0);
    }

    #[test]
    fn a_lamp_that_never_lights_is_refused() {
        let dark = (0..100).map(|i| 12.0 + (f64::from(i) * 0.618034).fract()).collect();
        let dark = Series::new(0.0, 60.0, dark).unwrap();
        assert!(matches!(rising(&dark, Window::INSTANT), Err(EdgeError::NoLevels { .. })));
        let flat = Series::new(0.0, 60.0, vec![4.0; 30]).unwrap();
        assert!(matches!(rising(&flat, Window::INSTANT), Err(EdgeError::NoLevels { .. })));
    }
}
