//! A rasteriser of shaded triangles with a depth buffer and four samples a pixel.

use si::Point2;

use super::Canvas;

/// Samples along each side of a pixel.
pub(super) const SAMPLES: usize = 2;

/// A corner in the picture: sample coordinates, depth (m) and grey.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) at: Point2,
    pub(super) depth: f64,
    pub(super) grey: f32,
}

/// Depth and grey of the samples in a part of the picture.
pub(super) struct Samples {
    corner: [i64; 2],
    size: [usize; 2],
    depth: Vec<f32>,
    grey: Vec<f32>,
}

impl Samples {
    /// Empty samples over the box around `corners`.
    pub(super) fn around_corners<'a>(corners: impl Iterator<Item = &'a Corner> + Clone) -> Option<Self> {
        let end = |k: usize, start: f64, pick: fn(f64, f64) -> f64| corners.clone().map(|c| c.at[k]).fold(start, pick);
        let low = [0, 1].map(|k| end(k, f64::INFINITY, f64::min));
        let high = [0, 1].map(|k| end(k, f64::NEG_INFINITY, f64::max));
        if !low.iter().chain(&high).all(|x| x.abs() < 20_000.0) {
            return None;
        }
        let step = SAMPLES as i64;
        let corner = low.map(|x| (x.floor() as i64).div_euclid(step) * step);
        let size = [0, 1].map(|k| ((high[k].ceil() as i64 - corner[k]) / step + 1) as usize * SAMPLES);
        let count = size[0] * size[1];
        Some(Self { corner, size, depth: vec![f32::INFINITY; count], grey: vec![0.0; count] })
    }

    /// Draws one triangle of either orientation with a depth test, row by row.
    pub(super) fn draw_triangle(&mut self, [a, b, c]: [Corner; 3]) {
        let [p, q] = [b, c].map(|v| [v.at[0] - a.at[0], v.at[1] - a.at[1]]);
        let area = p[0] * q[1] - p[1] * q[0];
        if area.abs() < 1e-12 {
            return;
        }
        // increments of a linear function over the triangle per column and row
        let gradient = |u: f64, v: f64| [(u * q[1] - v * p[1]) / area, (v * p[0] - u * q[0]) / area];
        let depth = gradient(b.depth - a.depth, c.depth - a.depth);
        let grey = gradient(f64::from(b.grey - a.grey), f64::from(c.grey - a.grey));
        let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| Edge::between_ends(from.at, to.at));
        let (low, high) = (a.at[1].min(b.at[1]).min(c.at[1]), a.at[1].max(b.at[1]).max(c.at[1]));
        for row in ceil_to_integer(low)..=floor_to_integer(high) {
            let (first, last) = crossed_columns(&edges, row as f64);
            if last < first {
                continue;
            }
            let offset = [first as f64 - a.at[0], row as f64 - a.at[1]];
            let first_sample = (row - self.corner[1]) as usize * self.size[0] + (first - self.corner[0]) as usize;
            let start = (a.depth + depth[0] * offset[0] + depth[1] * offset[1]) as f32;
            let level = a.grey + (grey[0] * offset[0] + grey[1] * offset[1]) as f32;
            let count = (last - first + 1) as usize;
            let nearest = self.depth[first_sample..first_sample + count]
                .iter_mut()
                .zip(&mut self.grey[first_sample..first_sample + count]);
            for (k, (nearest, shade)) in nearest.enumerate() {
                let depth = start + depth[0] as f32 * k as f32;
                if depth < *nearest {
                    *nearest = depth;
                    *shade = level + grey[0] as f32 * k as f32;
                }
            }
        }
    }

    /// Blends the samples into the canvas, each pixel weighted by the fraction of its samples that are covered.
    pub(super) fn blend_into(&self, canvas: &mut Canvas) {
        let each = (SAMPLES * SAMPLES) as f32;
        for row in (0..self.size[1]).step_by(SAMPLES) {
            for column in (0..self.size[0]).step_by(SAMPLES) {
                let places = (0..SAMPLES * SAMPLES)
                    .map(|k| (row + k / SAMPLES) * self.size[0] + column + k % SAMPLES)
                    .filter(|i| self.depth[*i].is_finite());
                let (sum, covered) = places.fold((0.0, 0.0), |(sum, covered), i| (sum + self.grey[i], covered + 1.0));
                if covered > 0.0 {
                    let pixel = [0, 1].map(|k| (self.corner[k] + [column, row][k] as i64).div_euclid(SAMPLES as i64));
                    canvas.blend_pixel(pixel[0], pixel[1], sum / covered, covered / each);
                }
            }
        }
    }
}

/// An edge of a triangle for the intersection with rows.
#[derive(Clone, Copy)]
struct Edge {
    rows: [f64; 2],
    /// Column at row 0, and columns a row.
    line: [f64; 2],
}

impl Edge {
    /// None along a row: its ends are those of the other two.
    fn between_ends([x, y]: Point2, [u, v]: Point2) -> Option<Self> {
        let slope = (u - x) / (v - y);
        slope.is_finite().then(|| Self { rows: [y.min(v), y.max(v)], line: [x - slope * y, slope] })
    }
}

/// First and last whole column inside a triangle on a row; the last is before the first where there is none.
fn crossed_columns(edges: &[Option<Edge>; 3], row: f64) -> (i64, i64) {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for edge in edges.iter().flatten().filter(|e| e.rows[0] <= row && row <= e.rows[1]) {
        let crossing = edge.line[0] + edge.line[1] * row;
        (left, right) = (left.min(crossing), right.max(crossing));
    }
    if left <= right { (ceil_to_integer(left), floor_to_integer(right)) } else { (0, -1) }
}

/// ⌈x⌉ and ⌊x⌋ by conversion: `f64::ceil` and `floor` are calls, and each frame needs millions.
fn ceil_to_integer(x: f64) -> i64 {
    let truncated = x as i64;
    truncated + i64::from(x > truncated as f64)
}

fn floor_to_integer(x: f64) -> i64 {
    let truncated = x as i64;
    truncated - i64::from(x < truncated as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_filled_with_its_area_and_its_gradient_of_grey() {
        let corner = |x: f64, y: f64| Corner { at: [x, y], depth: 0.1, grey: (2.0 * x + 3.0 * y) as f32 };
        let face = [corner(3.2, 4.1), corner(81.7, 20.4), corner(30.5, 66.9)];
        let mut samples = Samples::around_corners(face.iter()).unwrap();
        samples.draw_triangle(face);
        let [a, b, c] = face.map(|corner| corner.at);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let met: Vec<usize> = (0..samples.depth.len()).filter(|i| samples.depth[*i].is_finite()).collect();
        // as many samples as area, but for half a perimeter's worth of chance
        assert!((met.len() as f64 - area).abs() < 30.0, "{} {area}", met.len());
        for i in met {
            let (x, y) = (i % samples.size[0], i / samples.size[0]);
            let at = [(x as i64 + samples.corner[0]) as f64, (y as i64 + samples.corner[1]) as f64];
            assert!((f64::from(samples.grey[i]) - 2.0 * at[0] - 3.0 * at[1]).abs() < 1e-3);
        }
    }

    #[test]
    fn the_nearer_of_two_triangles_is_drawn() {
        let face = |depth: f64, grey: f32| [[2.0, 2.0], [40.0, 3.0], [20.0, 30.0]].map(|at| Corner { at, depth, grey });
        for order in [[(0.2, 50.0), (0.1, 90.0)], [(0.1, 90.0), (0.2, 50.0)]] {
            let faces = order.map(|(depth, grey)| face(depth, grey));
            let mut samples = Samples::around_corners(faces.iter().flatten()).unwrap();
            faces.into_iter().for_each(|face| samples.draw_triangle(face));
            assert!(samples.grey.iter().all(|grey| *grey == 0.0 || *grey == 90.0));
        }
    }
}
