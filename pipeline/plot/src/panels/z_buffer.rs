//! A small renderer with a depth buffer: triangles on a grid of pixels, with outlines where the depth jumps.
//!
//! Each pixel is the mean of `FINE` × `FINE` samples.

use si::Point3;

use crate::Colour;
use crate::raster::Raster;

/// A triangle ready to be filled: corners [across, down, depth] in pixels, depth increasing away from the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// The corners.
    pub corners: [Point3; 3],
    /// The colours of the corners, between which is mixed.
    pub colours: [Colour; 3],
    /// 1 hides what is behind.
    pub opacity: f64,
}

/// Samples of a pixel in each direction.
const FINE: usize = 3;
/// Brightness of an outline, relative to its surface.
const OUTLINE: f64 = 0.45;

/// The samples of a picture.
struct Samples {
    width: usize,
    height: usize,
    depth: Vec<f64>,
    /// red, green, blue, 0 to 255, multiplied by alpha; and alpha.
    light: Vec<[f64; 4]>,
}

/// Renders all facets; opaque ones first, then transparent ones from far to near (painter's algorithm), which do not
/// write to the depth buffer.
///
/// An outline is drawn where the depth of solid facets jumps by more than `jump` (in the facets' unit of depth).
pub(crate) fn render_facets(facets: &[Facet], width: usize, height: usize, jump: f64) -> Raster {
    let (w, h) = (width * FINE, height * FINE);
    let mut samples = Samples { width: w, height: h, depth: vec![f64::INFINITY; w * h], light: vec![[0.0; 4]; w * h] };
    facets.iter().filter(|f| f.opacity >= 1.0).for_each(|f| samples.fill_facet(f));
    samples.draw_outlines(jump);
    let mut clear: Vec<&Facet> = facets.iter().filter(|f| f.opacity < 1.0).collect();
    let depth = |f: &Facet| f.corners.iter().map(|c| c[2]).sum::<f64>();
    clear.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    clear.into_iter().for_each(|f| samples.fill_facet(f));
    samples.average_samples(width, height)
}

impl Samples {
    fn fill_facet(&mut self, facet: &Facet) {
        let [a, b, c] = facet.corners.map(|p| [p[0] * FINE as f64, p[1] * FINE as f64, p[2]]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice == 0.0 || !twice.is_finite() {
            return;
        }
        let range = |k: usize, most: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize
        };
        for row in range(1, self.height) {
            for column in range(0, self.width) {
                let p = [column as f64 + 0.5, row as f64 + 0.5];
                let side = |u: Point3, v: Point3| (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0]);
                let parts = [side(b, c) / twice, side(c, a) / twice, side(a, b) / twice];
                if parts.iter().all(|t| *t >= 0.0) {
                    self.set_sample(row * self.width + column, facet, parts);
                }
            }
        }
    }

    fn set_sample(&mut self, index: usize, facet: &Facet, parts: [f64; 3]) {
        let depth: f64 = (0..3).map(|k| parts[k] * facet.corners[k][2]).sum();
        if depth >= self.depth[index] {
            return;
        }
        let channel = |channel_value: fn(&Colour) -> u8| {
            (0..3).map(|k| parts[k] * f64::from(channel_value(&facet.colours[k]))).sum::<f64>()
        };
        let (new, alpha) = ([channel(|c| c.0), channel(|c| c.1), channel(|c| c.2), 1.0], facet.opacity.min(1.0));
        for (old, new) in self.light[index].iter_mut().zip(new) {
            *old = *old * (1.0 - alpha) + new * alpha;
        }
        if facet.opacity >= 1.0 {
            self.depth[index] = depth;
        }
    }

    /// Darkens the near side of every jump in depth.
    fn draw_outlines(&mut self, jump: f64) {
        let (w, h) = (self.width, self.height);
        let far = |index: usize, beside: usize| self.depth[beside] - self.depth[index] > jump;
        let edge = |index: &usize| {
            let (column, row) = (index % w, index / w);
            self.depth[*index].is_finite()
                && ((column > 0 && far(*index, index - 1))
                    || (column + 1 < w && far(*index, index + 1))
                    || (row > 0 && far(*index, index - w))
                    || (row + 1 < h && far(*index, index + w)))
        };
        let edges: Vec<usize> = (0..w * h).filter(edge).collect();
        for index in edges {
            self.light[index][..3].iter_mut().for_each(|v| *v *= OUTLINE);
        }
    }

    fn average_samples(&self, width: usize, height: usize) -> Raster {
        let mut pixels = Vec::with_capacity(width * height * 4);
        for (row, column) in (0..height).flat_map(|r| (0..width).map(move |c| (r, c))) {
            let mut sum = [0.0; 4];
            for k in 0..FINE * FINE {
                let sample = self.light[(row * FINE + k / FINE) * self.width + column * FINE + k % FINE];
                sum.iter_mut().zip(sample).for_each(|(s, v)| *s += v);
            }
            let cover = sum[3];
            let shown = |v: f64| if cover > 0.0 { (v / cover).round().clamp(0.0, 255.0) as u8 } else { 255 };
            let alpha = (255.0 * cover / (FINE * FINE) as f64).round() as u8;
            pixels.extend([shown(sum[0]), shown(sum[1]), shown(sum[2]), alpha]);
        }
        Raster { width, height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Colour = Colour(255, 0, 0);
    const BLUE: Colour = Colour(0, 0, 255);

    fn facet(depth: f64, colour: Colour, opacity: f64) -> Facet {
        let corners = [[-50.0, -50.0, depth], [50.0, -50.0, depth], [0.0, 50.0, depth]];
        Facet { corners, colours: [colour; 3], opacity }
    }

    fn middle(facets: &[Facet]) -> Vec<u8> {
        let picture = render_facets(facets, 5, 5, f64::INFINITY);
        picture.pixels[4 * 12..4 * 13].to_vec()
    }

    #[test]
    fn the_nearer_triangle_is_seen_whatever_the_order() {
        let (near, far) = (facet(1.0, RED, 1.0), facet(2.0, BLUE, 1.0));
        assert_eq!(middle(&[near, far]), [255, 0, 0, 255]);
        assert_eq!(middle(&[far, near]), [255, 0, 0, 255]);
    }

    #[test]
    fn a_clear_triangle_in_front_lets_the_solid_one_through() {
        let (near, far) = (facet(1.0, RED, 0.25), facet(2.0, BLUE, 1.0));
        assert_eq!(middle(&[near, far]), [64, 0, 191, 255]);
    }

    #[test]
    fn two_triangles_that_share_an_edge_leave_no_seam() {
        let square = [[1.0, 1.0, 0.0], [8.0, 1.0, 0.0], [8.0, 8.0, 0.0], [1.0, 8.0, 0.0]];
        let half = |i: usize, j: usize, k: usize| Facet {
            corners: [square[i], square[j], square[k]],
            colours: [RED; 3],
            opacity: 1.0,
        };
        let picture = render_facets(&[half(0, 1, 2), half(0, 2, 3)], 9, 9, f64::INFINITY);
        for (row, column) in (1..8).flat_map(|r| (1..8).map(move |c| (r, c))) {
            assert_eq!(picture.pixels[4 * (9 * row + column) + 3], 255);
        }
    }

    #[test]
    fn half_a_pixel_is_half_covered() {
        let corners = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 3.0, 0.0]];
        let other = [[0.0, 0.0, 0.0], [0.5, 3.0, 0.0], [0.0, 3.0, 0.0]];
        let facets = [corners, other].map(|corners| Facet { corners, colours: [RED; 3], opacity: 1.0 });
        // 3 samples a dot: a half is met as one or two thirds
        let cover = render_facets(&facets, 1, 1, f64::INFINITY).pixels[3];
        assert!((80..=175).contains(&cover), "{cover}");
    }
}
