//! Baselines: predictions of a motion without a simulation of it.
//!
//! Rest: nothing moves. Quasi-static: at each instant the identified model's equilibrium under the pressures; no baseline without a model. Last
//! cycle: the measurement one cycle before, which no simulation may use.

use si::{Hertz, Metre, Pascal, Point2, Second};

use super::repeats::{AlignedRepeats, rms};
use records::{Identified, Level, ScoredModel};

/// The quasi-static model of a motion.
pub struct QuasiStatic<'a> {
    /// Measured pressure at each frame, Pa: chambers × frames.
    pub pressures: &'a [Vec<Pascal>],
    /// The simulated levels.
    pub identified: &'a Identified,
    /// Index of the observed marker.
    pub marker: usize,
}

/// The error of each baseline; `frequency` (Hz) is that of a periodic motion.
pub(crate) fn baseline_errors(
    repeats: &AlignedRepeats,
    quasi_static: &QuasiStatic,
    frequency: Option<Hertz>,
) -> Vec<ScoredModel> {
    let scored = |name: &str, rmse: Metre| ScoredModel { name: name.into(), rmse };
    let count = repeats.mean.len();
    let mut scores = vec![
        scored("rest", rms(&repeats.mean, &vec![[0.0; 2]; count])),
        scored("quasi_static", rms(&repeats.mean, &quasi_static.static_path(count))),
    ];
    scores.extend(frequency.map(|f| scored("last_cycle", last_cycle(repeats, 1.0 / f))));
    scores
}

impl QuasiStatic<'_> {
    /// The sum of the static displacements under each chamber's pressure alone, interpolated between the simulated levels.
    fn static_path(&self, frames: usize) -> Vec<Point2> {
        let curves: Vec<Vec<(Pascal, Point2)>> =
            (0..self.pressures.len()).map(|chamber| self.static_curve(chamber)).collect();
        let superposed = |frame: usize| {
            let parts = curves.iter().zip(self.pressures).map(|(curve, p)| interpolated(curve, p[frame]));
            parts.fold([0.0; 2], |sum, contribution| [sum[0] + contribution[0], sum[1] + contribution[1]])
        };
        (0..frames).map(superposed).collect()
    }

    /// Static displacement by the pressure of one chamber, in rising order.
    fn static_curve(&self, chamber: usize) -> Vec<(Pascal, Point2)> {
        let filled = |l: &&Level| l.pressures_pa[chamber] >= l.pressure();
        let levels = self.identified.levels.iter().filter(filled);
        let mut curve: Vec<(Pascal, Point2)> = levels.map(|l| (l.pressure(), l.simulated_m[self.marker])).collect();
        curve.push((0.0, [0.0; 2]));
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        curve
    }
}

/// Linear between the points of a curve, and beyond its last one.
fn interpolated(curve: &[(Pascal, Point2)], pressure: Pascal) -> Point2 {
    if curve.len() < 2 {
        return [0.0; 2];
    }
    let right = curve.partition_point(|(p, _)| *p < pressure).clamp(1, curve.len() - 1);
    let ((p, a), (q, b)) = (curve[right - 1], curve[right]);
    let part = ((pressure - p) / (q - p)).max(0.0);
    [0, 1].map(|k| a[k] + part * (b[k] - a[k]))
}

/// From the second cycle on.
fn last_cycle(repeats: &AlignedRepeats, period: Second) -> Metre {
    let frame_interval =
        (repeats.time[repeats.time.len() - 1] - repeats.time[0]) / (repeats.time.len() - 1).max(1) as f64;
    let frames_per_cycle = (period / frame_interval).round() as usize;
    let moves = repeats.mean.iter().position(|p| p[0].hypot(p[1]) > 1e-3).unwrap_or(0);
    let first_frame = (moves + frames_per_cycle).min(repeats.mean.len() - 1);
    rms(&repeats.mean[first_frame..], &repeats.mean[first_frame - frames_per_cycle.min(first_frame)..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_levels_a_quasi_static_shape_is_their_mean() {
        let curve = [(0.0, [0.0, 0.0]), (100.0, [0.0, 1.0]), (200.0, [-1.0, 3.0])];
        assert_eq!(interpolated(&curve, 150.0), [-0.5, 2.0]);
        assert_eq!(interpolated(&curve, -5.0), [0.0, 0.0]);
        assert_eq!(interpolated(&curve, 250.0), [-1.5, 4.0]);
    }

    #[test]
    fn a_periodic_motion_equals_that_of_the_cycle_before() {
        let time: Vec<f64> = (0..180).map(|i| f64::from(i) / 60.0).collect();
        let mean = time.iter().map(|t| [0.0, (std::f64::consts::TAU * 2.0 * t).sin()]).collect();
        let seen = AlignedRepeats { moves: 0.0, deviation: Vec::new(), gauges: Vec::new(), time, mean };
        assert!(last_cycle(&seen, 0.5) < 1e-9);
        assert!(last_cycle(&seen, 0.25) > 1.0);
    }
}
