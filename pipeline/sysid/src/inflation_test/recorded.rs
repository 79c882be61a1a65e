//! Recorded displacement of the tip since the step of pressure.

use std::path::Path;

use nalgebra::Vector3;
use si::{Metre, Second, Series};

use super::page::{Page, Recording};
use crate::free_vibration::recorded::{find, marker_displacements, marker_tracks};
use diagnostics::{Diagnostic, Result};

/// The mean displacements by which an inflation is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Features {
    /// In the interval after the step, m.
    pub early: Metre,
    /// At the end of the hold, m.
    pub late: Metre,
}

impl Features {
    /// Growth over the hold, no unit.
    pub(crate) fn creep(&self) -> f64 {
        self.late / self.early - 1.0
    }

    /// Of a displacement at `times` after the step, over a hold of `duration`, s.
    pub fn of(page: &Page, duration: Second, course: &[(Second, Metre)]) -> Self {
        Self {
            early: mean_displacement(course, page.early),
            late: mean_displacement(course, [duration - page.late, duration]),
        }
    }
}

/// Mean of a course over an interval of time, by its values at 20 times.
fn mean_displacement(course: &[(Second, Metre)], [begin, end]: [Second; 2]) -> Metre {
    const SAMPLES: usize = 20;
    let (times, values): (Vec<f64>, Vec<f64>) = course.iter().copied().unzip();
    // At even times: samples of a simulated course are densest where its adaptive steps are short, and would count
    // there most.
    let time = |k: usize| begin + (k as f64 + 0.5) / SAMPLES as f64 * (end - begin);
    let value = |k: usize| crate::free_vibration::fitting::interpolate_series(&times, &values, time(k));
    (0..SAMPLES).map(value).sum::<f64>() / SAMPLES as f64
}

/// Displacement below which nothing moves, m: no camera resolves it, and ratios to it mean nothing.
const STILL: Metre = 1e-9;

/// One recorded inflation.
pub(crate) struct Recorded {
    /// Mean displacement of the compared markers along the page's axis since the step, m.
    pub tip: Series,
    pub features: Features,
}

impl Recorded {
    /// Reads `recording` from the first folder below `root` that has it.
    ///
    /// # Errors
    /// A [`Diagnostic`] when it lies nowhere, is refused, or is shorter than the page says.
    pub fn read(page: &Page, recording: &Recording, root: &Path) -> Result<Self> {
        let path = find(&page.name, &page.folders, &recording.files, root)?;
        let (rate, tracks) = marker_tracks(&page.marker, &path)?;
        let frame = |time: Second| (time * rate).round() as usize;
        let [first, last] = recording.hold.map(frame);
        let frames = tracks[0].len();
        if last >= frames {
            let message = format!("{} holds {:.2} s", path.display(), frames as f64 / rate);
            let reason = format!("the hold of `{}` ends at {} s", recording.name, recording.hold[1]);
            return Err(Diagnostic::new(message, reason, "correct `hold` on the page"));
        }
        let displacements = marker_displacements(&page.marker, &tracks, frame(page.held).max(1));
        let compared: Vec<&Vec<Vector3<f64>>> = displacements
            .iter()
            .zip(&page.marker)
            .filter(|(_, marker)| marker.compared)
            .map(|(displacement, _)| displacement)
            .collect();
        let mean = |i: usize| {
            compared.iter().map(|displacement| displacement[i][page.along as usize]).sum::<f64>()
                / compared.len() as f64
        };
        let tip = Series::new(0.0, rate, (first..=last).map(mean).collect())?;
        let course: Vec<_> = tip.values().iter().enumerate().map(|(i, u)| (tip.time(i), *u)).collect();
        let features = Features::of(page, recording.duration(), &course);
        if features.early.abs() < STILL {
            let message = format!("the tip does not move in `{}`", recording.name);
            let reason = format!(
                "{:.1e} m on average from {} to {} s of its hold",
                features.early, page.early[0], page.early[1]
            );
            return Err(Diagnostic::file(&path, message, reason, "correct `hold`, `early` or `along` on the page"));
        }
        Ok(Self { tip, features })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_line_is_its_middle_and_creep_is_relative() {
        let line: Vec<_> = (0..=30).map(|i| (0.1 * f64::from(i), 1.0 + 0.1 * f64::from(i))).collect();
        assert!((mean_displacement(&line, [0.5, 1.5]) - 2.0).abs() < 1e-12);
        assert!((Features { early: -2.0, late: -2.2 }.creep() - 0.1).abs() < 1e-12);
    }
}
