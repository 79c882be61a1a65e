//! Clipping: the part of a line or polygon inside of a rectangle.
//!
//! Lines are clipped by the algorithm of Liang and Barsky, polygons by that of Sutherland and Hodgman.

use si::Point2;

use crate::canvas::Area;

/// The pieces of a line inside of the rectangle (Liang–Barsky, segment by segment).
pub(crate) fn clip_line(points: &[Point2], area: &Area) -> Vec<Vec<Point2>> {
    let mut pieces: Vec<Vec<Point2>> = Vec::new();
    for pair in points.windows(2) {
        let Some([a, b]) = clip_segment(pair[0], pair[1], area) else { continue };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&a) => piece.push(b),
            _ => pieces.push(vec![a, b]),
        }
    }
    pieces
}

/// The part of a segment inside of the rectangle; none when it misses it.
pub(crate) fn clip_segment(a: Point2, b: Point2, area: &Area) -> Option<[Point2; 2]> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for k in 0..2 {
        let step = b[k] - a[k];
        for (bound, sign) in [(area.from[k], 1.0), (area.to[k], -1.0)] {
            let (into, gap) = (sign * step, sign * (bound - a[k]));
            if into == 0.0 && gap > 0.0 {
                return None;
            }
            if into > 0.0 {
                enter = enter.max(gap / into);
            } else if into < 0.0 {
                leave = leave.min(gap / into);
            }
        }
    }
    // the ends are returned bit by bit, so that pieces that meet at an end are joined into one line
    let point_at = |t: f64| {
        if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
        }
    };
    (enter <= leave).then(|| [point_at(enter), point_at(leave)])
}

/// The part of a polygon inside of the rectangle (Sutherland–Hodgman, side by side).
pub(crate) fn clip_polygon(points: &[Point2], area: &Area) -> Vec<Point2> {
    let sides = [(0, area.from[0], 1.0), (0, area.to[0], -1.0), (1, area.from[1], 1.0), (1, area.to[1], -1.0)];
    sides.into_iter().fold(points.to_vec(), |points, (k, bound, sign)| {
        let inside = |p: Point2| sign * (p[k] - bound) >= 0.0;
        let mut clipped = Vec::new();
        for i in 0..points.len() {
            let (a, b) = (points[i], points[(i + 1) % points.len()]);
            if inside(a) {
                clipped.push(a);
            }
            if inside(a) != inside(b) {
                let t = (bound - a[k]) / (b[k] - a[k]);
                clipped.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
        clipped
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Area = Area { from: [0.0, 0.0], to: [1.0, 1.0] };

    #[test]
    fn a_line_that_leaves_and_returns_becomes_two_pieces() {
        let pieces = clip_line(&[[0.5, 0.5], [1.5, 0.5], [1.5, 0.75], [0.5, 0.75]], &UNIT);
        assert_eq!(pieces, vec![vec![[0.5, 0.5], [1.0, 0.5]], vec![[1.0, 0.75], [0.5, 0.75]]]);
    }

    #[test]
    fn a_line_beside_the_rectangle_is_dropped() {
        assert!(clip_line(&[[-1.0, 2.0], [3.0, 2.0]], &UNIT).is_empty());
    }

    #[test]
    fn a_polygon_around_the_rectangle_becomes_the_rectangle() {
        let cut = clip_polygon(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]], &UNIT);
        let area: f64 = (0..cut.len())
            .map(|i| (cut[i], cut[(i + 1) % cut.len()]))
            .map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0]))
            .sum();
        assert!((area.abs() - 1.0).abs() < 1e-12);
    }
}
