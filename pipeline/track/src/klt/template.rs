//! The first view of a marker, and the residual against it.
//!
//! The rotation of the marker is estimated in each frame, starting from that of the frame before. Levels are compared as shares of the
//! background, so that a change of light does not count.

use super::background::Disc;
use super::blob::Blob;
use crate::Gray;
use si::{Point2, Radian};

/// A marker turns by less between two frames, rad: 35° to either side at 4 Hz and 60 frames/s is 0.26.
const FASTEST: Radian = 0.35;
/// Steps in which turns up to that are tried on either side of the last one.
const TRIES: i32 = 4;
/// Half width of the parabola through the best of them, rad.
const FINE: Radian = 0.04;
/// The tries look at every second pixel each way.
const SPARSE: usize = 2;
/// The template is kept this much beyond the window, px, so that a turned window stays on it.
const MARGIN: f64 = 2.0;

/// An angle is accepted when it lowers the sum of squares to this share.
const BETTER: f64 = 0.98;

/// First view of a marker.
#[derive(Debug, Clone)]
pub(super) struct Template {
    radius: f64,
    /// Side of the square of shares, px.
    side: usize,
    /// Place of the marker's middle in the square, px.
    middle: Point2,
    /// Level over background, no unit, `side` × `side`.
    shares: Vec<f64>,
}

/// How a marker differs from its template.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Difference {
    /// Turn since the first frame, rad.
    pub(super) turn: Radian,
    /// Mean absolute difference, grey levels a pixel.
    pub(super) mean: f64,
}

impl Template {
    /// Keeps the window of `radius` (px) around a spot, which lies in the picture with a margin.
    pub(super) fn cut_window(picture: &Gray, blob: &Blob, radius: f64) -> Self {
        let half = (radius + MARGIN).ceil();
        let first = blob.at.map(|c| c.round() - half);
        let side = 2 * half as usize + 1;
        let shift = blob.centroid_shift();
        let middle = [blob.at[0] - first[0], blob.at[1] - first[1]];
        let share = |k: usize| {
            let (x, y) = ((k % side) as f64, (k / side) as f64);
            let background = blob.background.level_at(x - middle[0] + shift[0], y - middle[1] + shift[1]);
            picture.interpolated_level([first[0] + x, first[1] + y]) / background
        };
        Self { radius, side, middle, shares: (0..side * side).map(share).collect() }
    }

    /// Compares a spot with the template near the turn `last` (rad).
    pub(super) fn compare_spot(&self, picture: &Gray, blob: &Blob, last: Radian) -> Difference {
        let rough = |turn: Radian| self.window_distance(picture, blob, turn, SPARSE).squares;
        let tries = (-TRIES..=TRIES).map(|k| last + FASTEST * f64::from(k) / f64::from(TRIES));
        let best = tries.map(|turn| (rough(turn), turn)).min_by(|a, b| a.0.total_cmp(&b.0));
        let start = best.map_or(last, |(_, turn)| turn);
        let turn = Self::parabola_vertex(rough, start);
        // A disc fits at any rotation: an angle that fits no better than the last is not estimated and does not drift.
        let turn = if rough(turn) < BETTER * rough(last) { turn } else { last };
        Difference { turn, mean: self.window_distance(picture, blob, turn, 1).mean }
    }

    /// The lowest point of the parabola through three turns about `start`.
    fn parabola_vertex(squares: impl Fn(Radian) -> f64, start: Radian) -> Radian {
        let [before, here, after] = [-FINE, 0.0, FINE].map(|t| squares(start + t));
        let shift = 0.5 * FINE * (before - after) / (before - 2.0 * here + after);
        // A parabola through three nearly equal values has its vertex anywhere; no better place lies beyond the next
        // try.
        let max_shift = FASTEST / f64::from(TRIES);
        if shift.is_finite() { start + shift.clamp(-max_shift, max_shift) } else { start }
    }

    /// The distance between the window, turned by `turn` (rad), and the template, over every `stride`-th pixel each way.
    fn window_distance(&self, picture: &Gray, blob: &Blob, turn: Radian, stride: usize) -> Distance {
        let (at, background) = (blob.at, &blob.background);
        let shift = blob.centroid_shift();
        let sine_cosine = turn.sin_cos();
        let (mut squares, mut sum, mut number) = (0.0, 0.0, 0.0);
        Disc { middle: at, radius: self.radius, stride }.visit_pixels(picture, |x, y, _, level| {
            let miss = level - self.level_share([x, y], sine_cosine) * background.level_at(x + shift[0], y + shift[1]);
            squares += miss * miss;
            sum += miss.abs();
            number += 1.0;
        });
        Distance { squares, mean: sum / number }
    }

    /// Radius of the window, px.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Level over background at a place counted from the marker's middle (px), linear between pixels.
    ///
    /// The marker is turned by the angle of which sine and cosine are given.
    pub(super) fn level_share(&self, [x, y]: Point2, (sine, cosine): (f64, f64)) -> f64 {
        let [x, y] = [self.middle[0] + cosine * x + sine * y, self.middle[1] - sine * x + cosine * y];
        let last = (self.side - 2) as f64;
        let (left, top) = (x.clamp(0.0, last) as usize, y.clamp(0.0, last) as usize);
        let (u, v) = (x - left as f64, y - top as f64);
        let s = &self.shares[top * self.side + left..];
        (s[0] * (1.0 - u) + s[1] * u) * (1.0 - v) + (s[self.side] * (1.0 - u) + s[self.side + 1] * u) * v
    }
}

struct Distance {
    squares: f64,
    mean: f64,
}
