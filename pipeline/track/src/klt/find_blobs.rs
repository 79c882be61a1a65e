//! Detection of markers as dark spots in a region, the most distinct first.

use super::Settings;
use super::blob;
use crate::Gray;
use si::Point2;

/// A spot's middle is dark against the middle of this many px around it, as a share of the window's radius.
const CORE: f64 = 0.45;
/// Places are tried this far apart, as a share of the window's radius.
const STRIDE: f64 = 0.35;
/// A spot that is found from two places is one when they agree to this, px.
const SAME: f64 = 2.0;
/// Share of the least contrast that the first look at a place must show.
// Some place holds the whole of a spot at first sight; where a window would have to be moved before it sees one, it is
// not moved. On a patterned ground that takes most windows twelve looks, and took two seconds for a picture of
// 1280 × 720 px.
const FIRST_LOOK: f64 = 0.5;
/// Share of the window's rim that may be dark.
const RIM: f64 = 0.02;

/// The `count` most distinct dark spots inside a region (left, top, right, bottom, px), from left to right: px each.
///
/// Distinct is the contrast to a background that is even: spots on a patterned background come last. Fewer come back when there are
/// fewer, and none of a picture that lacks grey levels.
pub fn find_blobs(
    picture: &Gray,
    [left, top, right, bottom]: [f64; 4],
    count: usize,
    settings: &Settings,
) -> Vec<Point2> {
    if picture.check().is_err() {
        return Vec::new();
    }
    let sums = Sums::of_picture(picture);
    let step = (STRIDE * settings.radius).max(1.0);
    let columns = ((right - left) / step).max(0.0) as usize;
    let rows = ((bottom - top) / step).max(0.0) as usize;
    let cells = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
    let mut candidates: Vec<(Point2, f64)> = Vec::new();
    for near in cells.map(|(i, j)| [left + step * i as f64, top + step * j as f64]) {
        if !picture.holds_with_margin(near, settings.radius + 6.0)
            || sums.core_darkness(near, settings.radius) < settings.contrast_limit / 3.0
        {
            continue;
        }
        let min_contrast = FIRST_LOOK * settings.contrast_limit;
        let Ok(blob) = blob::find_distinct(picture, near, settings.radius, min_contrast) else { continue };
        let [x, y] = blob.at;
        let inside = (left..=right).contains(&x) && (top..=bottom).contains(&y);
        let is_duplicate = candidates.iter().any(|(point, _)| (point[0] - x).hypot(point[1] - y) < SAME);
        if inside && !is_duplicate && blob.contrast >= settings.contrast_limit && blob.spread <= RIM {
            candidates.push((blob.at, blob.contrast / (1.0 + blob.background.noise)));
        }
    }
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut accepted = separate_spots(&candidates, count, settings.radius);
    accepted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    accepted
}

/// The first `count` of the candidates that are at least `distance` (px) from those before them.
fn separate_spots(candidates: &[(Point2, f64)], count: usize, distance: f64) -> Vec<Point2> {
    let mut accepted: Vec<Point2> = Vec::new();
    for (point, _) in candidates {
        let is_separate = accepted.iter().all(|k| (k[0] - point[0]).hypot(k[1] - point[1]) >= distance);
        if is_separate && accepted.len() < count {
            accepted.push(*point);
        }
    }
    accepted
}

/// Sums of a picture's levels over every rectangle from its corner.
struct Sums {
    width: usize,
    sums: Vec<u64>,
}

impl Sums {
    fn of_picture(picture: &Gray) -> Self {
        let width = picture.width + 1;
        let mut sums = vec![0; width * (picture.height + 1)];
        for y in 0..picture.height {
            let mut row = 0;
            for x in 0..picture.width {
                row += u64::from(picture.pixels[y * picture.width + x]);
                sums[(y + 1) * width + x + 1] = sums[y * width + x + 1] + row;
            }
        }
        Self { width, sums }
    }

    /// Mean level of the square of half side `half` (px) around a place, which lies inside.
    fn square_mean(&self, [x, y]: Point2, half: f64) -> f64 {
        let [left, right] = [x - half, x + half + 1.0].map(|v| v.round() as usize);
        let [top, bottom] = [y - half, y + half + 1.0].map(|v| v.round() as usize);
        let sum_to = |column: usize, row: usize| self.sums[row * self.width + column];
        let sum = sum_to(right, bottom) + sum_to(left, top) - sum_to(left, bottom) - sum_to(right, top);
        sum as f64 / ((right - left) * (bottom - top)) as f64
    }

    /// How much darker the core of a window is than the whole of it, grey levels.
    fn core_darkness(&self, middle: Point2, radius: f64) -> f64 {
        self.square_mean(middle, radius) - self.square_mean(middle, CORE * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_around_a_place_is_that_of_its_square() {
        let picture = Gray::from_fn(40, 30, |x, y| 2.0 * x as f64 + 3.0 * y as f64);
        assert!((Sums::of_picture(&picture).square_mean([20.0, 12.0], 5.0) - 76.0).abs() < 1e-12);
    }

    #[test]
    fn three_discs_are_found_from_left_to_right_and_neither_a_line_nor_what_lies_outside() {
        let discs = [[200.4, 90.3], [80.2, 120.7], [140.8, 60.1], [290.0, 200.0]];
        let picture = Gray::from_fn(320, 240, |x, y| {
            let near = |p: &Point2| (10.5 - (x as f64 - p[0]).hypot(y as f64 - p[1])).clamp(0.0, 1.0);
            let line = if (150..154).contains(&y) { 90.0 } else { 0.0 };
            180.0 - line - 140.0 * discs.iter().map(near).fold(0.0, f64::max) + 0.02 * x as f64
        });
        let found = find_blobs(&picture, [30.0, 30.0, 260.0, 210.0], 5, &Settings::default());
        assert_eq!(found.len(), 3, "{found:?}");
        for (at, truth) in found.iter().zip([discs[1], discs[2], discs[0]]) {
            assert!((at[0] - truth[0]).hypot(at[1] - truth[1]) < 0.05, "{at:?} {truth:?}");
        }
    }
}
