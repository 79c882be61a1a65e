//! A dark spot on light background: its centroid, weighted by darkness.
//!
//! Darkness is relative to the sloped background and cut off softly, so that neither uneven light nor noise far from the spot shifts the
//! centroid, nor does a rotation of the spot. Only pixels connected to the spot count.

use super::background::{Background, Disc, RING, Ring};
use crate::Gray;
use si::Point2;

/// Less than this many times the background's noise is background.
const NOISES: f64 = 3.5;
/// Bounds of that, as a share of the full darkness: rounding to whole levels, and a quarter of the way.
const CUT: (f64, f64) = (0.02, 0.25);
/// The full darkness is the one that this share of the window reaches: the least share of it that a thin cross fills.
const CORE: f64 = 0.08;
/// Rounds of moving the window to the centroid.
const ROUNDS: usize = 12;
/// The window has converged when it moves by less, px.
const CONVERGED: f64 = 2e-3;
/// Width of the rim inside the window that a spot must leave light, px.
const RIM: f64 = 1.5;

/// A dark spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blob {
    /// Centroid, px.
    pub(crate) at: Point2,
    /// Second moments of the pixels' pull on the centroid per grey level of noise, px² / level².
    pub(super) pull: [[f64; 2]; 2],
    /// Difference between background and spot, grey levels.
    pub(crate) contrast: f64,
    /// Share of the window's rim that is dark, no unit.
    pub(super) spread: f64,
    /// The background around it.
    pub(super) background: Background,
    /// How darkness became weight.
    pub(super) soft: Soft,
    /// Sum of the weights, px².
    pub(super) sum: f64,
}

impl Blob {
    /// The step from the place where the background was read to the centroid, px.
    pub(super) fn centroid_shift(&self) -> Point2 {
        let background_middle = self.background.middle();
        [self.at[0] - background_middle[0], self.at[1] - background_middle[1]]
    }
}

/// A soft cut between background and spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Soft {
    /// Darkness of the spot's core, no unit.
    full: f64,
    /// Share of it that is still background.
    cut: f64,
}

impl Soft {
    /// Weight of a pixel, 0 for background to 1 for spot, linear in its darkness.
    pub(super) fn pixel_weight(&self, darkness: f64) -> f64 {
        if self.full <= 0.0 {
            return 0.0;
        }
        ((darkness / self.full - self.cut) / (1.0 - 2.0 * self.cut)).clamp(0.0, 1.0)
    }
}

/// Why a window holds no spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Miss {
    /// The window, or the ring around it, reaches out of the picture.
    Outside,
    /// Nothing is darker than the background.
    Empty,
}

/// The spot nearest to `near` (px) in a window of `radius` (px) that follows it.
///
/// # Errors
/// [`Miss`] when the window leaves the picture or holds nothing darker than its background.
pub(crate) fn find_blob(picture: &Gray, near: Point2, radius: f64) -> Result<Blob, Miss> {
    find_distinct(picture, near, radius, f64::NEG_INFINITY)
}

/// The same, where the first look already shows a contrast of `min_contrast` (grey levels): a window on patterned ground is then not followed.
///
/// # Errors
/// [`Miss`] as [`find_blob`], and where the first look shows less.
pub(super) fn find_distinct(picture: &Gray, near: Point2, radius: f64, min_contrast: f64) -> Result<Blob, Miss> {
    let (mut blob, mut ring) = measure_spot(picture, near, radius)?;
    if blob.contrast < min_contrast {
        return Err(Miss::Empty);
    }
    let mut previous = near;
    for _ in 1..ROUNDS {
        if (blob.at[0] - previous[0]).hypot(blob.at[1] - previous[1]) < CONVERGED {
            break;
        }
        previous = blob.at;
        (blob, ring) = measure_spot(picture, previous, radius)?;
    }
    Ok(Blob { background: blob.background.with_bend(&ring), ..blob })
}

fn measure_spot(picture: &Gray, middle: Point2, radius: f64) -> Result<(Blob, Ring), Miss> {
    // a pixel more for the template, which is cut between pixels
    if !picture.holds_with_margin(middle, radius + RING + 1.0) {
        return Err(Miss::Outside);
    }
    let window = Window::open(picture, middle, radius);
    let blob = window.measured_blob().ok_or(Miss::Empty)?;
    Ok((blob, window.ring))
}

/// Share of a window of `radius` (px) around the spot near a place that is as dark as a spot and not connected to it,
/// no unit; 0 where there is no window or no spot.
pub fn clutter_share(picture: &Gray, near: Point2, radius: f64) -> f64 {
    let Ok(blob) = find_blob(picture, near, radius) else { return 0.0 };
    if !picture.holds_with_margin(blob.at, radius + RING + 1.0) {
        return 0.0;
    }
    let window = Window::open(picture, blob.at, radius);
    let inside = window.cells.iter().filter(|c| c.r2.is_finite()).count();
    let dark = window.cells.iter().filter(|c| c.weight > 0.5).count();
    let spot_pixels = window.nearest_spot().map_or(0, |spot| spot.iter().filter(|c| c.weight > 0.5).count());
    (dark - spot_pixels) as f64 / inside as f64
}

/// One pixel of a window: its place from the middle, px, that squared, its darkness (no unit) and its weight once known.
#[derive(Clone, Copy)]
struct Cell {
    x: f64,
    y: f64,
    r2: f64,
    darkness: f64,
    weight: f64,
}

/// The pixels around a place, as a square of `side` × `side` so that neighbours are known.
struct Window {
    middle: Point2,
    radius: f64,
    side: usize,
    cells: Vec<Cell>,
    background: Background,
    ring: Ring,
    contrast: f64,
    soft: Soft,
}

impl Window {
    fn open(picture: &Gray, middle: Point2, radius: f64) -> Self {
        let (background, ring) = Background::around_point(picture, middle, radius);
        let half = radius.ceil() as usize + 1;
        let side = 2 * half + 1;
        let first = middle.map(|c| c.round() - half as f64);
        let outside = Cell { x: 0.0, y: 0.0, r2: f64::INFINITY, darkness: 0.0, weight: 0.0 };
        let mut cells = vec![outside; side * side];
        let mut core = Vec::new();
        Disc { middle, radius, stride: 1 }.visit_pixels(picture, |x, y, r2, level| {
            let darkness = 1.0 - level / background.level_at(x, y);
            core.push(darkness);
            let [column, row] = [middle[0] + x - first[0], middle[1] + y - first[1]].map(|v| v.round() as usize);
            cells[row * side + column] = Cell { x, y, r2, darkness, weight: 0.0 };
        });
        // A quantile: the darkest pixel alone is set by noise, and the more so the larger the window.
        let rank = core.len() - 1 - (CORE * core.len() as f64) as usize;
        let full = *core.select_nth_unstable_by(rank, f64::total_cmp).1;
        let contrast = full * background.level_at(0.0, 0.0);
        let cut = (NOISES * background.noise / contrast).clamp(CUT.0, CUT.1);
        let soft = Soft { full, cut };
        cells.iter_mut().for_each(|cell| cell.weight = soft.pixel_weight(cell.darkness));
        Self { middle, radius, side, cells, background, ring, contrast, soft }
    }

    /// The pixels of the spot nearest to the middle.
    fn nearest_spot(&self) -> Option<Vec<Cell>> {
        let seeds = (0..self.cells.len()).filter(|&i| self.cells[i].weight > 0.5);
        let seed = seeds.min_by(|&a, &b| self.cells[a].r2.total_cmp(&self.cells[b].r2))?;
        Some(self.connected_cells(seed))
    }

    /// That spot's middle and what is known of it.
    fn measured_blob(&self) -> Option<Blob> {
        let spot = self.nearest_spot()?;
        let sum: f64 = spot.iter().map(|c| c.weight).sum();
        let mean = |value: fn(&Cell) -> f64| spot.iter().map(|c| c.weight * value(c)).sum::<f64>() / sum;
        let [x, y] = [mean(|c| c.x), mean(|c| c.y)];
        let slope = 1.0 / ((1.0 - 2.0 * self.soft.cut) * self.contrast * sum);
        let mut pull = [[0.0; 2]; 2];
        for cell in spot.iter().filter(|c| c.weight < 1.0) {
            let arm = [(cell.x - x) * slope, (cell.y - y) * slope];
            for (row, a) in pull.iter_mut().zip(arm) {
                row[0] += a * arm[0];
                row[1] += a * arm[1];
            }
        }
        let inner = (self.radius - RIM).powi(2);
        let rim = |c: &&Cell| c.r2 > inner && c.r2.is_finite();
        let dark = spot.iter().filter(rim).filter(|c| c.weight > 0.5).count();
        let rim_cells = self.cells.iter().filter(rim).count();
        Some(Blob {
            at: [self.middle[0] + x, self.middle[1] + y],
            pull,
            contrast: self.contrast,
            spread: dark as f64 / rim_cells as f64,
            background: self.background,
            soft: self.soft,
            sum,
        })
    }

    /// All cells of positive weight connected to `seed` by sides or corners, in reading order.
    fn connected_cells(&self, seed: usize) -> Vec<Cell> {
        let mut taken = vec![false; self.cells.len()];
        let mut open = vec![seed];
        taken[seed] = true;
        while let Some(i) = open.pop() {
            // the outermost cells never have weight, so every neighbour exists
            for neighbour in [i - self.side - 1, i - self.side, i - self.side + 1, i - 1, i + 1].into_iter().chain([
                i + self.side - 1,
                i + self.side,
                i + self.side + 1,
            ]) {
                if !taken[neighbour] && self.cells[neighbour].weight > 0.0 {
                    taken[neighbour] = true;
                    open.push(neighbour);
                }
            }
        }
        taken.iter().zip(&self.cells).filter(|(taken, _)| **taken).map(|(_, cell)| *cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of radius 11 px at `at`, edge pixels by their share, on a background that slopes.
    fn disc(at: Point2) -> Gray {
        Gray::from_fn(90, 80, |x, y| {
            let background = 170.0 + 0.5 * x as f64 + 0.3 * y as f64;
            let share = (0..64)
                .filter(|k| {
                    let fine = |v: usize, i: usize| v as f64 + (i as f64 + 0.5) / 8.0 - 0.5;
                    (fine(x, k % 8) - at[0]).hypot(fine(y, k / 8) - at[1]) < 11.0
                })
                .count();
            background * (1.0 - 0.7 * share as f64 / 64.0)
        })
    }

    #[test]
    fn a_disc_on_a_slope_of_light_is_centred_to_a_hundredth_of_a_pixel() {
        for k in 0..10 {
            let truth = [44.0 + 0.13 * f64::from(k), 39.0 + 0.29 * f64::from(k)];
            let blob = find_blob(&disc(truth), [47.0, 36.0], 18.0).unwrap();
            let miss = (blob.at[0] - truth[0]).hypot(blob.at[1] - truth[1]);
            assert!(miss < 0.01, "{truth:?}: {miss}");
            assert!((blob.contrast - 0.7 * 204.0).abs() < 8.0 && blob.spread == 0.0);
        }
    }

    #[test]
    fn an_even_background_contains_no_spot() {
        let blob = find_blob(&Gray::filled(90, 80, 200), [45.0, 40.0], 18.0);
        assert!(blob.is_ok_and(|b| b.contrast < 1.0) || blob == Err(Miss::Empty));
    }
}
