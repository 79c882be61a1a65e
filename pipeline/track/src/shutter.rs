//! Correction of a rolling shutter: a path seen at the times of its rows is interpolated at the times of the frames.
//!
//! A frame's time is that of its middle row. Tracks keep what was seen; only positions are interpolated, by a cubic, because a linear
//! interpolation over a tenth of a frame would lose the acceleration of a flapping tail.

use si::{Point2, Second};

/// A rolling shutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shutter {
    /// Time from the first row to the last, s.
    pub readout: Second,
    /// Rows of a picture.
    pub height: usize,
}

impl Shutter {
    /// How much later than its frame's time, which is the middle row's, row `v` (px) is read, s.
    pub fn row_delay(&self, v: f64) -> Second {
        let last = self.height.max(2) as f64 - 1.0;
        self.readout * (v / last - 0.5)
    }
}

/// Places of a path around a time, for a cubic.
const AROUND: usize = 4;

/// The path that was seen at the times `read`, at the times `wanted` (s), by the cubic through the four places around each.
pub fn at_times(wanted: &[Second], read: &[Second], path: &[Point2]) -> Vec<Point2> {
    if path.len() < AROUND || wanted == read {
        return path.to_vec();
    }
    let interpolate = |(frame, t): (usize, &Second)| {
        // The wanted time lies between the two middle ones of the four, where the error of a cubic is least.
        let points_before = if *t < read[frame] { 2 } else { 1 };
        let first = frame.saturating_sub(points_before).min(path.len() - AROUND);
        let weights = lagrange_weights(&read[first..first + AROUND], *t);
        weights.iter().zip(&path[first..]).fold([0.0; 2], |sum, (w, p)| [sum[0] + w * p[0], sum[1] + w * p[1]])
    };
    wanted.iter().enumerate().map(interpolate).collect()
}

/// Weights of the values at `nodes` in the cubic through them, at `t`.
fn lagrange_weights(nodes: &[Second], t: Second) -> [f64; AROUND] {
    let weight = |i: usize| (0..AROUND).filter(|j| *j != i).map(|j| (t - nodes[j]) / (nodes[i] - nodes[j])).product();
    std::array::from_fn(weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_of_4_hz_read_late_is_met_at_its_frames_to_a_hundredth_of_its_shift() {
        let shutter = Shutter { readout: 0.006, height: 720 };
        let wave = |t: Second| [360.0 + 10.0 * t, 360.0 + 300.0 * (25.0 * t).sin()];
        let wanted: Vec<Second> = (0..90).map(|k| f64::from(k) / 60.0).collect();
        let row = |t: &Second| (0..20).fold(*t, |read, _| t + shutter.row_delay(wave(read)[1]));
        let read: Vec<Second> = wanted.iter().map(row).collect();
        let seen: Vec<Point2> = read.iter().map(|t| wave(*t)).collect();
        let found = at_times(&wanted, &read, &seen);
        // at the film's ends the cubic has places on one side only
        let off = |path: &[Point2]| {
            wanted.iter().zip(path).skip(2).take(86).map(|(t, p)| (p[1] - wave(*t)[1]).abs()).fold(0.0, f64::max)
        };
        assert!(off(&found) < 0.02 * off(&seen), "{} {}", off(&found), off(&seen));
    }

    #[test]
    fn the_middle_row_is_read_at_the_frame_s_time_and_the_ends_half_a_read_out_away() {
        let shutter = Shutter { readout: 0.006, height: 721 };
        assert_eq!(shutter.row_delay(360.0), 0.0);
        assert!((shutter.row_delay(0.0) + 0.003).abs() < 1e-15 && (shutter.row_delay(720.0) - 0.003).abs() < 1e-15);
    }
}
