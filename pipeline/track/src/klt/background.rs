//! The light background around a marker: its level, slope and noise.

use crate::Gray;
use nalgebra::{Matrix3, Vector3};
use si::Point2;

/// Width of the ring in which the background is read, px.
pub(super) const RING: f64 = 3.0;
/// Error of any codec, grey levels: the least tolerance.
const TOLERANCE: f64 = 6.0;

/// A plane of grey levels about a place, with the scatter of the picture around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Background {
    middle: Point2,
    /// Level at the middle, then its rise along x and y, grey levels (a px).
    plane: [f64; 3],
    /// Scatter of the kept pixels, grey levels.
    pub(super) noise: f64,
    /// How far the background leaves the plane in large, grey levels: root mean square over sectors of the ring; 0 until
    /// [`Background::with_bend`].
    pub(super) bend: f64,
}

/// The pixels of a ring that its background was read from: x, y from the middle (px) and level.
#[derive(Debug, Clone)]
pub(super) struct Ring(Vec<(f64, f64, f64)>);

/// Sectors of the ring in which the background's bend is read.
const SECTORS: usize = 8;

impl Background {
    /// Reads the ring outside `radius` (px) around `middle`; what is much darker or lighter than the rest is left out.
    ///
    /// The ring must lie inside the picture.
    pub(super) fn around_point(picture: &Gray, middle: Point2, radius: f64) -> (Self, Ring) {
        let mut ring = Vec::new();
        Disc { middle, radius: radius + RING, stride: 1 }.visit_pixels(picture, |x, y, r2, level| {
            if r2 > radius * radius {
                ring.push((x, y, level));
            }
        });
        let mut levels: Vec<f64> = ring.iter().map(|p| p.2).collect();
        // Median and median deviation: the ring may cross a line of the grid or the tail's edge, which a mean and its
        // standard deviation would take in.
        let centre = median(&mut levels);
        let mut deviations: Vec<f64> = ring.iter().map(|p| (p.2 - centre).abs()).collect();
        let tolerance = 3.0 * 1.4826 * median(&mut deviations) + TOLERANCE;
        ring.retain(|p| (p.2 - centre).abs() <= tolerance);
        let plane = fit_plane(&ring).unwrap_or([centre, 0.0, 0.0]);
        let squared_residual = |p: &(f64, f64, f64)| (p.2 - plane[0] - plane[1] * p.0 - plane[2] * p.1).powi(2);
        let noise =
            (ring.iter().map(squared_residual).sum::<f64>() / ring.len().saturating_sub(3).max(1) as f64).sqrt();
        (Self { middle, plane, noise, bend: 0.0 }, Ring(ring))
    }

    /// The same, with its bend. It takes as long as everything else here, and is of use once a window has converged.
    pub(super) fn with_bend(self, ring: &Ring) -> Self {
        Self { bend: sector_deviation(&ring.0, self.plane), ..self }
    }

    /// The background's level at (x, y), counted from the middle, grey levels; at least one, so that it can divide.
    pub(super) fn level_at(&self, x: f64, y: f64) -> f64 {
        (self.plane[0] + self.plane[1] * x + self.plane[2] * y).max(1.0)
    }

    /// Around which place it was read, px.
    pub(super) fn middle(&self) -> Point2 {
        self.middle
    }
}

/// The pixels of a picture within a circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    /// Centre of the circle, px.
    pub(super) middle: Point2,
    /// Radius of the circle, px.
    pub(super) radius: f64,
    /// Distance of successive pixels each way, px: 2 takes every second one.
    pub(super) stride: usize,
}

impl Disc {
    /// Calls `see` with (x, y, x² + y², level) of every pixel, places counted from the middle.
    pub(super) fn visit_pixels(self, picture: &Gray, mut see: impl FnMut(f64, f64, f64, f64)) {
        let Self { middle, radius, stride } = self;
        let span = |c: f64, size: usize| {
            (c - radius).ceil().max(0.0) as usize..((c + radius).max(-1.0) as usize + 1).min(size)
        };
        for row in span(middle[1], picture.height).step_by(stride) {
            let y = row as f64 - middle[1];
            for column in span(middle[0], picture.width).step_by(stride) {
                let x = column as f64 - middle[0];
                let r2 = x * x + y * y;
                if r2 <= radius * radius {
                    see(x, y, r2, picture.pixel_level(column, row));
                }
            }
        }
    }
}

/// Root mean square over sectors of what a ring's pixels are off its plane on average.
fn sector_deviation(ring: &[(f64, f64, f64)], plane: [f64; 3]) -> f64 {
    let mut sums = [(0.0, 0.0_f64); SECTORS];
    for (x, y, level) in ring {
        let turn = (y.atan2(*x) / std::f64::consts::TAU + 0.5) * SECTORS as f64;
        let sum = &mut sums[(turn as usize).min(SECTORS - 1)];
        *sum = (sum.0 + level - plane[0] - plane[1] * x - plane[2] * y, sum.1 + 1.0);
    }
    (sums.iter().map(|(sum, count)| (sum / count.max(1.0)).powi(2)).sum::<f64>() / SECTORS as f64).sqrt()
}

/// Least squares for level = a + b x + c y.
fn fit_plane(places: &[(f64, f64, f64)]) -> Option<[f64; 3]> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for &(x, y, level) in places {
        let row = Vector3::new(1.0, x, y);
        normal += row * row.transpose();
        right += row * level;
    }
    Some(normal.cholesky()?.solve(&right).into())
}

/// The middle value; 0 of nothing.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_read_past_a_stain() {
        let slope = |x: usize, y: usize| 150.0 + 0.4 * x as f64 - 0.2 * y as f64;
        let stained = |x: usize, y: usize| if x > 45 && y > 45 { 20.0 } else { slope(x, y) };
        let (background, ring) = Background::around_point(&Gray::from_fn(64, 64, stained), [32.3, 31.6], 18.0);
        for (x, y) in [(32, 32), (20, 40), (45, 25)] {
            let found = background.level_at(x as f64 - 32.3, y as f64 - 31.6);
            assert!((found - slope(x, y)).abs() < 0.3, "{found} {}", slope(x, y));
        }
        assert!(background.noise < 0.5 && background.with_bend(&ring).bend < 0.1);
    }
}
