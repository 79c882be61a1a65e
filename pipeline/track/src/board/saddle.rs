//! Corners of a checkerboard one by one: saddle points of the grey level.

use crate::Gray;
use si::Point2;

/// A saddle of the grey level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Saddle {
    /// Its place, px.
    pub(super) at: Point2,
    /// −det of the second derivatives of the blurred picture, grey levels² / px⁴.
    pub(super) strength: f64,
}

/// A blurred picture with its second derivatives at hand.
pub(super) struct Blurred {
    width: usize,
    height: usize,
    // Single precision: only rough places come from here, and the refinement reads the picture itself.
    levels: Vec<f32>,
}

/// Weaker than this share of the strongest, a saddle is noise.
const WEAKEST: f64 = 0.02;
/// The least strength that a real corner shows: 20 grey levels across it, blurred by 4 px.
const LEAST_STRENGTH: f64 = 0.02;
/// More saddles than this are a texture, not a board: the strongest are kept.
const MOST: usize = 4000;
/// Points on the ring around a corner at which black and white must alternate.
const RING: usize = 24;

/// The saddles of a picture blurred by `sigma` (px), strongest first, none nearer than 2 `sigma` to another.
pub(super) fn find_saddles(picture: &Gray, sigma: f64) -> Vec<Saddle> {
    if (picture.width.min(picture.height) as f64) < 8.0 * sigma {
        return Vec::new();
    }
    let blurred = Blurred::new(picture, sigma);
    let min_distance = (2.0 * sigma).round() as usize;
    let strength = blurred.saddle_strengths();
    let mut candidates = find_peaks(&strength, blurred.width, blurred.height, min_distance);
    let limit = candidates.first().map_or(f64::INFINITY, |s| (WEAKEST * s.strength).max(LEAST_STRENGTH));
    candidates.retain(|s| s.strength >= limit);
    candidates.truncate(MOST);
    candidates.retain(|s| alternates_on_ring(&blurred, s.at, 2.5 * sigma));
    candidates
}

/// The place of the saddle near `start`, to a hundredth of a pixel: the flat point of a quadratic fitted around it.
///
/// Levels in a disc of `radius` (px), weighted to its edge by a cone; repeated around each new place. None when there is
/// no saddle, or it lies further than `radius` away.        \[lucchese2002\]
pub(super) fn refine_saddle(picture: &Gray, start: Point2, radius: f64) -> Option<Point2> {
    let mut centre = start;
    for _ in 0..REFINEMENTS {
        let step = flat_point(picture, centre, radius)?;
        centre = [centre[0] + step[0], centre[1] + step[1]];
        if (centre[0] - start[0]).hypot(centre[1] - start[1]) > radius {
            return None;
        }
        if step[0].hypot(step[1]) < 1e-3 {
            break;
        }
    }
    Some(centre)
}

/// Refinements of a corner; the third moves it by less than a thousandth of a pixel.
const REFINEMENTS: usize = 8;

/// The step from `at` to the flat point of a quadratic q = a x² + b xy + c y² + d x + e y + f fitted around it.
fn flat_point(picture: &Gray, at: Point2, radius: f64) -> Option<Point2> {
    let reach = radius.ceil() as i64;
    if !picture.holds_with_margin(at, reach as f64 + 1.0) {
        return None;
    }
    let middle = at.map(|v| v.round() as i64);
    let mut normal = nalgebra::SMatrix::<f64, 6, 6>::zeros();
    let mut right = nalgebra::SVector::<f64, 6>::zeros();
    for row in middle[1] - reach..=middle[1] + reach {
        for column in middle[0] - reach..=middle[0] + reach {
            let (x, y) = (column as f64 - at[0], row as f64 - at[1]);
            // A cone and no step at the edge: pixels that enter and leave as the centre moves would shift the fit by
            // jumps, and the iteration could alternate.
            let weight = 1.0 - x.hypot(y) / (radius + 0.5);
            if weight > 0.0 {
                let basis = nalgebra::SVector::<f64, 6>::from([x * x, x * y, y * y, x, y, 1.0]);
                normal += basis * basis.transpose() * weight;
                right += basis * (weight * picture.pixel_level(column as usize, row as usize));
            }
        }
    }
    let [a, b, c, d, e, _]: [f64; 6] = normal.cholesky()?.solve(&right).into();
    let is_saddle = 4.0 * a * c - b * b < 0.0;
    let step = crate::lens::solve([[2.0 * a, b], [b, 2.0 * c]], [-d, -e])?;
    (is_saddle && step[0].hypot(step[1]) <= radius).then_some(step)
}

impl Blurred {
    /// Blurs by a Gauss curve of `sigma` px in two passes, the border's level continued.
    fn new(picture: &Gray, sigma: f64) -> Self {
        let (width, height) = (picture.width, picture.height);
        let reach = (3.0 * sigma).ceil() as usize;
        let curve: Vec<f64> = (0..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
        let sum = curve[0] + 2.0 * curve[1..].iter().sum::<f64>();
        let kernel: Vec<f32> = curve.iter().map(|c| (c / sum) as f32).collect();
        let pixels: Vec<f32> = picture.pixels.iter().map(|&p| f32::from(p)).collect();
        let mut blurred_rows = vec![0.0; pixels.len()];
        let mut padded = vec![0.0; width + 2 * reach];
        for (row, out) in pixels.chunks(width).zip(blurred_rows.chunks_mut(width)) {
            padded[..reach].fill(row[0]);
            padded[reach..reach + width].copy_from_slice(row);
            padded[reach + width..].fill(row[width - 1]);
            for (x, value) in out.iter_mut().enumerate() {
                let pair = |i: usize| padded[reach + x - i] + padded[reach + x + i];
                *value = kernel[0] * padded[reach + x] + (1..=reach).map(|i| kernel[i] * pair(i)).sum::<f32>();
            }
        }
        let mut levels = vec![0.0; pixels.len()];
        for (y, out) in levels.chunks_mut(width).enumerate() {
            let row = |i: usize| &blurred_rows[i.min(height - 1) * width..][..width];
            for (weight, i) in (0..=2 * reach).map(|i| (kernel[i.abs_diff(reach)], (y + i).saturating_sub(reach))) {
                out.iter_mut().zip(row(i)).for_each(|(value, level)| *value += weight * level);
            }
        }
        Self { width, height, levels }
    }

    /// Iₓᵧ² − Iₓₓ Iᵧᵧ at every pixel, 0 along the border: positive where the level is a saddle.
    fn saddle_strengths(&self) -> Vec<f32> {
        let (w, mut out) = (self.width, vec![0.0; self.levels.len()]);
        for y in 1..self.height.saturating_sub(1) {
            for x in 1..w.saturating_sub(1) {
                let pixel = y * w + x;
                let i = |k: usize| self.levels[k];
                let xx = i(pixel - 1) - 2.0 * i(pixel) + i(pixel + 1);
                let yy = i(pixel - w) - 2.0 * i(pixel) + i(pixel + w);
                let xy = 0.25 * (i(pixel + w + 1) - i(pixel + w - 1) - i(pixel - w + 1) + i(pixel - w - 1));
                out[pixel] = xy * xy - xx * yy;
            }
        }
        out
    }

    /// The level at a place, linear between pixels.
    fn interpolated_level(&self, [x, y]: Point2) -> f64 {
        let (left, top) = (x as usize, y as usize);
        let (u, v) = (x - left as f64, y - top as f64);
        let i = |x: usize, y: usize| f64::from(self.levels[y * self.width + x]);
        (i(left, top) * (1.0 - u) + i(left + 1, top) * u) * (1.0 - v)
            + (i(left, top + 1) * (1.0 - u) + i(left + 1, top + 1) * u) * v
    }
}

/// Pixels larger than all within `min_distance`, strongest first (equals in reading order).
fn find_peaks(strength: &[f32], width: usize, height: usize, min_distance: usize) -> Vec<Saddle> {
    let mut maxima = Vec::new();
    for y in min_distance..height.saturating_sub(min_distance) {
        for x in min_distance..width.saturating_sub(min_distance) {
            let peak_strength = strength[y * width + x];
            let beaten = || {
                (y - min_distance..=y + min_distance).any(|v| {
                    let row = &strength[v * width + x - min_distance..=v * width + x + min_distance];
                    row.iter()
                        .enumerate()
                        .any(|(k, &s)| s > peak_strength || (s == peak_strength && (v, x + k) < (y, x + min_distance)))
                })
            };
            if f64::from(peak_strength) > LEAST_STRENGTH && !beaten() {
                maxima.push(Saddle { at: [x as f64, y as f64], strength: f64::from(peak_strength) });
            }
        }
    }
    maxima.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    maxima
}

/// Whether dark and light change four times around a ring of `radius` (px), opposite sides alike.
fn alternates_on_ring(blurred: &Blurred, centre: Point2, radius: f64) -> bool {
    let margin = radius + 2.0;
    let (right, bottom) = (blurred.width as f64 - 1.0 - margin, blurred.height as f64 - 1.0 - margin);
    if centre[0] < margin || centre[1] < margin || centre[0] > right || centre[1] > bottom {
        return false;
    }
    let ring_point = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / RING as f64;
        [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
    };
    let ring: [f64; RING] = std::array::from_fn(|k| blurred.interpolated_level(ring_point(k)));
    let (low, high) = ring.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let light = ring.map(|v| v > 0.5 * (low + high));
    let changes = (0..RING).filter(|&k| light[k] != light[(k + 1) % RING]).count();
    let opposite = (0..RING / 2).filter(|&k| light[k] == light[k + RING / 2]).count();
    // Of twelve opposite pairs four may differ: the ring's centre is a whole pixel, so that an edge may pass between
    // two of its points on one side and not on the other.
    changes == 4 && opposite >= RING / 3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four quarters that intersect at `at`, turned and sheared, edges as a camera's (supersampled), light 200 and dark 50.
    fn corner(at: Point2) -> Gray {
        const FINE: usize = 8;
        Gray::from_fn(60, 50, |x, y| {
            let place = |k: usize, c: f64| c + (k as f64 + 0.5) / FINE as f64 - 0.5;
            let mut light = 0;
            for i in 0..FINE * FINE {
                let (dx, dy) = (place(i % FINE, x as f64) - at[0], place(i / FINE, y as f64) - at[1]);
                light += usize::from((dx + 0.3 * dy > 0.0) == (dy - 0.2 * dx > 0.0));
            }
            50.0 + 150.0 * light as f64 / (FINE * FINE) as f64
        })
    }

    #[test]
    fn a_corner_is_found_and_refined_to_two_hundredths_of_a_pixel() {
        for k in 0..10 {
            let truth = [28.0 + 0.31 * f64::from(k), 24.3 - 0.17 * f64::from(k)];
            let picture = corner(truth);
            let found = find_saddles(&picture, 2.0);
            assert_eq!(found.len(), 1);
            let at = refine_saddle(&picture, found[0].at, 6.0).unwrap();
            let miss = (at[0] - truth[0]).hypot(at[1] - truth[1]);
            assert!(miss < 0.02, "{truth:?} {at:?} {miss}");
        }
    }

    #[test]
    fn an_edge_and_a_disc_are_no_corners() {
        let edge = Gray::from_fn(60, 50, |x, y| if x + y / 3 > 30 { 200.0 } else { 50.0 });
        let disc =
            Gray::from_fn(60, 50, |x, y| if (x as f64 - 30.0).hypot(y as f64 - 25.0) < 9.0 { 50.0 } else { 200.0 });
        assert!(find_saddles(&edge, 2.0).is_empty() && find_saddles(&disc, 2.0).is_empty());
    }
}
