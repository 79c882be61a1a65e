//! Dark quadrilaterals of a picture: the black borders of markers that stand on light ground.

use crate::Gray;
use crate::board::dark::{Patch, dark_patches};
use si::Point2;

/// Four corners, px, clockwise as seen.
pub(super) type Quad = [Point2; 4];

/// Shortest side, px: six cells of two pixels.
const SHORTEST_SIDE: f64 = 12.0;
/// Pixels of a marker, at most, as a share of the picture.
const LARGEST: f64 = 0.25;
/// By how much the area of a patch's hull may exceed that of its quadrilateral, as a share; corners are a pixel wide.
const BULGE: f64 = 0.12;

/// The quadrilaterals among the dark patches; `window` is half the side of the square with whose mean a pixel is compared, px.
pub(super) fn find_quads(picture: &Gray, window: usize) -> Vec<Quad> {
    let largest = (LARGEST * picture.pixels.len() as f64) as usize;
    dark_patches(picture, window)
        .filter(|patch| patch.len() <= largest)
        .filter_map(|patch| quad_of_patch(&patch))
        .collect()
}

fn quad_of_patch(patch: &Patch) -> Option<Quad> {
    if (patch.len() as f64) < SHORTEST_SIDE * SHORTEST_SIDE * 0.3 {
        return None;
    }
    let hull = convex_hull(row_ends(patch));
    let quad = inscribed_quad(&hull)?;
    let (area, hull_area) = (polygon_area(&quad), polygon_area(&hull));
    let sides = (0..4).map(|k| distance(quad[k], quad[(k + 1) % 4]));
    let is_quad = hull_area - area < BULGE * area && sides.fold(f64::INFINITY, f64::min) >= SHORTEST_SIDE;
    is_quad.then(|| widen_quad(quad))
}

/// The first and last pixel of each row.
fn row_ends(patch: &Patch) -> Vec<Point2> {
    let mut rows: std::collections::BTreeMap<usize, (usize, usize)> = std::collections::BTreeMap::new();
    for &[x, y] in patch {
        let (first, last) = rows.entry(y).or_insert((x, x));
        (*first, *last) = ((*first).min(x), (*last).max(x));
    }
    rows.into_iter().flat_map(|(y, (first, last))| [[first as f64, y as f64], [last as f64, y as f64]]).collect()
}

/// The convex hull by the monotone chain of Andrew, clockwise as seen (y runs down).
fn convex_hull(mut points: Vec<Point2>) -> Vec<Point2> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let chain = |points: &mut dyn Iterator<Item = Point2>| {
        let mut chain: Vec<Point2> = Vec::new();
        for point in points {
            while chain.len() > 1 && cross(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0 {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// The two points of a hull that are furthest apart, and the furthest from their line on either side.
// of a square seen at up to 60° the diagonal is longer than any side, so the first two are opposite corners
fn inscribed_quad(hull: &[Point2]) -> Option<Quad> {
    let pairs = (0..hull.len()).flat_map(|i| (i + 1..hull.len()).map(move |j| (i, j)));
    let (i, j) = pairs.max_by(|a, b| distance(hull[a.0], hull[a.1]).total_cmp(&distance(hull[b.0], hull[b.1])))?;
    let farthest_on_side = |side: f64| {
        let height = |p: &Point2| side * cross(hull[i], hull[j], *p);
        hull.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b))).filter(|p| height(p) > 0.0)
    };
    Some([hull[i], farthest_on_side(-1.0)?, hull[j], farthest_on_side(1.0)?])
}

/// From the middles of the outermost pixels to their outer edges: half a pixel from the middle of the whole.
fn widen_quad(quad: Quad) -> Quad {
    let middle = [0, 1].map(|k| quad.iter().map(|p| p[k]).sum::<f64>() / 4.0);
    quad.map(|p| {
        let reach = distance(p, middle);
        let factor = 1.0 + std::f64::consts::FRAC_1_SQRT_2 / reach;
        [0, 1].map(|k| middle[k] + factor * (p[k] - middle[k]))
    })
}

/// Positive where c lies to the right of the way from a to b, as seen.
fn cross(a: Point2, b: Point2, c: Point2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn polygon_area(polygon: &[Point2]) -> f64 {
    let term = |k: usize| {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        p[0] * q[1] - p[1] * q[0]
    };
    0.5 * (0..polygon.len()).map(term).sum::<f64>().abs()
}

pub(super) fn distance(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a point lies in a convex polygon that is given clockwise.
    fn inside(polygon: &Quad, p: Point2) -> bool {
        (0..4).all(|k| cross(polygon[k], polygon[(k + 1) % 4], p) >= 0.0)
    }

    #[test]
    fn the_corners_of_a_dark_quadrilateral_come_back_clockwise() {
        let truth: Quad = [[60.0, 40.0], [120.0, 55.0], [110.0, 130.0], [45.0, 110.0]];
        let picture = Gray::from_fn(200, 180, |x, y| if inside(&truth, [x as f64, y as f64]) { 40.0 } else { 200.0 });
        let [quad] = find_quads(&picture, 40)[..] else { panic!("one quadrilateral is dark") };
        for corner in truth {
            let off = quad.iter().map(|p| distance(*p, corner)).fold(f64::INFINITY, f64::min);
            assert!(off < 1.5, "{corner:?} {quad:?}");
        }
        assert!((0..4).all(|k| cross(quad[k], quad[(k + 1) % 4], quad[(k + 2) % 4]) > 0.0));
    }

    #[test]
    fn a_disc_a_triangle_and_a_speck_are_none() {
        let disc = |x: f64, y: f64| (x - 50.0).hypot(y - 60.0) < 30.0;
        let triangle = |x: f64, y: f64| y > 20.0 && y < 100.0 && (x - 150.0).abs() < 0.5 * (y - 20.0);
        let speck = |x: f64, y: f64| (x - 220.0).abs() < 5.0 && (y - 60.0).abs() < 5.0;
        let dark = |x: f64, y: f64| disc(x, y) || triangle(x, y) || speck(x, y);
        let picture = Gray::from_fn(260, 130, |x, y| if dark(x as f64, y as f64) { 40.0 } else { 200.0 });
        assert!(find_quads(&picture, 50).is_empty());
    }
}
