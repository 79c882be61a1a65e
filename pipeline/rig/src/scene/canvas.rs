//! A canvas: real-valued grey levels, filled with polygons by exact coverage.
//!
//! Pixel coordinates as in `track`: the centre of the first pixel is (0, 0), u to the right, v down.

use ab_glyph_rasterizer::{Rasterizer, point};
use si::Point2;

/// Grey levels, 0 black to 255 white, row after row.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `height` × `width`.
    pub levels: Vec<f32>,
}

/// Polygons that extend further out of the picture than this (px) are not drawn: they would cost memory without effect.
const REACH: f64 = 3000.0;

impl Canvas {
    /// A canvas of one level.
    pub fn filled(width: usize, height: usize, level: f32) -> Self {
        Self { width, height, levels: vec![level; width * height] }
    }

    /// Blends pixel (`x`, `y`), which may lie outside, with `level` by the weight `coverage` (0 to 1).
    pub(crate) fn blend_pixel(&mut self, x: i64, y: i64, level: f32, coverage: f32) {
        if x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height {
            let pixel = &mut self.levels[y as usize * self.width + x as usize];
            *pixel += coverage * (level - *pixel);
        }
    }

    /// Fills a polygon (px), which may extend beyond the picture, with `level`, weighted by each pixel's coverage.
    pub(crate) fn fill_polygon(&mut self, polygon: &[Point2], level: f32) {
        self.cover_pixels(polygon, |canvas, x, y, coverage| canvas.blend_pixel(x, y, level, coverage));
    }

    /// Fills a line of `width` px between two points.
    pub(crate) fn draw_stroke(&mut self, from: Point2, to: Point2, width: f64, level: f32) {
        let direction = [to[0] - from[0], to[1] - from[1]];
        let half = 0.5 * width / direction[0].hypot(direction[1]).max(1e-9);
        let side = [-direction[1] * half, direction[0] * half];
        let corner = |p: Point2, s: f64| [p[0] + s * side[0], p[1] + s * side[1]];
        self.fill_polygon(&[corner(from, 1.0), corner(to, 1.0), corner(to, -1.0), corner(from, -1.0)], level);
    }

    /// Calls `touch` with every pixel that the polygon covers and the coverage.
    fn cover_pixels(&mut self, polygon: &[Point2], mut touch: impl FnMut(&mut Self, i64, i64, f32)) {
        let Some((low, high)) = bounding_box(polygon) else { return };
        if high[0] < -0.5 || high[1] < -0.5 || low[0] > self.width as f64 || low[1] > self.height as f64 {
            return;
        }
        let corner = [low[0].floor() as i64 - 1, low[1].floor() as i64 - 1];
        let size = [0, 1].map(|k| (high[k].ceil() as i64 - corner[k] + 2) as usize);
        let mut raster = Rasterizer::new(size[0], size[1]);
        let raster_point =
            |p: Point2| point((p[0] + 0.5 - corner[0] as f64) as f32, (p[1] + 0.5 - corner[1] as f64) as f32);
        for (i, from) in polygon.iter().enumerate() {
            raster.draw_line(raster_point(*from), raster_point(polygon[(i + 1) % polygon.len()]));
        }
        raster.for_each_pixel_2d(|x, y, coverage| {
            if coverage > 0.0 {
                touch(self, corner[0] + i64::from(x), corner[1] + i64::from(y), coverage.min(1.0));
            }
        });
    }
}

/// Bounding box of a polygon; none if it has no area or extends beyond [`REACH`].
fn bounding_box(polygon: &[Point2]) -> Option<(Point2, Point2)> {
    let fold = |k: usize, start: f64, pick: fn(f64, f64) -> f64| polygon.iter().map(|p| p[k]).fold(start, pick);
    let low = [fold(0, f64::INFINITY, f64::min), fold(1, f64::INFINITY, f64::min)];
    let high = [fold(0, f64::NEG_INFINITY, f64::max), fold(1, f64::NEG_INFINITY, f64::max)];
    let sane = low.iter().chain(&high).all(|x| x.abs() < REACH);
    (polygon.len() > 2 && sane).then_some((low, high))
}

/// Centroid of a polygon's area, px.
pub(crate) fn area_centroid(polygon: &[Point2]) -> Point2 {
    let (mut area, mut sum) = (0.0, [0.0; 2]);
    let first = polygon[0];
    for (i, p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (a, b) = ([p[0] - first[0], p[1] - first[1]], [q[0] - first[0], q[1] - first[1]]);
        let cross = a[0] * b[1] - a[1] * b[0];
        area += cross;
        sum = [sum[0] + (a[0] + b[0]) * cross, sum[1] + (a[1] + b[1]) * cross];
    }
    [first[0] + sum[0] / (3.0 * area), first[1] + sum[1] / (3.0 * area)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(centre: Point2, radius: f64) -> Vec<Point2> {
        let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 48.0;
        (0..48).map(|i| [centre[0] + radius * angle(i).cos(), centre[1] + radius * angle(i).sin()]).collect()
    }

    #[test]
    fn the_centroid_of_a_drawn_disc_is_its_centre_to_a_hundredth_of_a_pixel() {
        for at in [[30.0, 20.0], [30.37, 20.81], [29.5, 21.25]] {
            let mut canvas = Canvas::filled(64, 48, 0.0);
            canvas.fill_polygon(&disc(at, 6.0), 1.0);
            let mass: f32 = canvas.levels.iter().sum();
            let moment =
                |f: fn(usize) -> usize| canvas.levels.iter().enumerate().map(|(i, l)| f(i) as f32 * l).sum::<f32>();
            let (u, v) = (moment(|i| i % 64) / mass, moment(|i| i / 64) / mass);
            assert!((f64::from(u) - at[0]).hypot(f64::from(v) - at[1]) < 0.01, "{at:?}: {u} {v}");
            assert!((area_centroid(&disc(at, 6.0))[0] - at[0]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_polygon_that_extends_beyond_the_picture_is_clipped() {
        let mut canvas = Canvas::filled(10, 10, 0.0);
        canvas.fill_polygon(&[[-50.0, 4.5], [50.0, 4.5], [50.0, 50.0], [-50.0, 50.0]], 8.0);
        assert_eq!((canvas.levels[44], canvas.levels[55]), (0.0, 8.0));
    }
}
