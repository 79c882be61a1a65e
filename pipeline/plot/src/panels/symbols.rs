//! Symbols of mechanics as lines: springs, dampers, arrow heads, hatched walls.

use si::Point2;

/// A frame along a segment: a point at part `t` of its length, `off` to its left.
fn segment_frame(from: Point2, to: Point2) -> impl Fn(f64, f64) -> Point2 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]).max(f64::MIN_POSITIVE);
    let left = [-way[1] / length, way[0] / length];
    move |t, off| [from[0] + t * way[0] + off * left[0], from[1] + t * way[1] + off * left[1]]
}

/// A zigzag of `turns` between two points, `half` high on either side.
pub(crate) fn spring_line(from: Point2, to: Point2, turns: usize, half: f64) -> Vec<Point2> {
    let point_at = segment_frame(from, to);
    let corners = 2 * turns;
    let zigzag = (0..corners).map(|i| {
        let t = 0.2 + 0.6 * (i as f64 + 0.5) / corners as f64;
        point_at(t, if i % 2 == 0 { half } else { -half })
    });
    [vec![from, point_at(0.2, 0.0)], zigzag.collect(), vec![point_at(0.8, 0.0), to]].concat()
}

/// The lines of a damper between two points: rod, cup and piston, `half` high on either side.
pub(crate) fn damper_lines(from: Point2, to: Point2, half: f64) -> [Vec<Point2>; 4] {
    let point_at = segment_frame(from, to);
    let (open, shut, piston) = (0.36, 0.64, 0.5);
    [
        vec![from, point_at(piston, 0.0)],
        vec![point_at(piston, 0.75 * half), point_at(piston, -0.75 * half)],
        vec![point_at(open, half), point_at(shut, half), point_at(shut, -half), point_at(open, -half)],
        vec![point_at(shut, 0.0), to],
    ]
}

/// The head of an arrow that ends at `to`: a filled triangle.
pub(crate) fn arrow_head(from: Point2, to: Point2, length: f64) -> Vec<Point2> {
    let reach = (to[0] - from[0]).hypot(to[1] - from[1]).max(f64::MIN_POSITIVE);
    let point_at = segment_frame(from, to);
    let back = 1.0 - length / reach;
    vec![to, point_at(back, 0.38 * length), point_at(back, -0.38 * length)]
}

/// The short strokes behind a wall from one point to another, on its left side.
pub(crate) fn hatching_lines(from: Point2, to: Point2, apart: f64, depth: f64) -> Vec<[Point2; 2]> {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let point_at = segment_frame(from, to);
    let count = (length / apart).floor().max(1.0) as usize;
    let stroke = |i: usize| {
        let t = (i as f64 + 0.75) / (count as f64 + 0.5);
        [point_at(t, 0.0), point_at(t - depth / length.max(f64::MIN_POSITIVE), depth)]
    };
    (0..count).map(stroke).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_begins_and_ends_where_it_is_hung() {
        let line = spring_line([1.0, 2.0], [1.0, 12.0], 4, 1.5);
        assert_eq!((line[0], line[line.len() - 1]), ([1.0, 2.0], [1.0, 12.0]));
        assert!(line.iter().all(|p| (p[0] - 1.0).abs() <= 1.5 + 1e-12));
    }

    #[test]
    fn an_arrow_head_points_where_the_arrow_goes() {
        let head = arrow_head([0.0, 0.0], [0.0, 10.0], 3.0);
        assert_eq!(head[0], [0.0, 10.0]);
        assert!((head[1][1] - 7.0).abs() < 1e-12 && (head[2][1] - 7.0).abs() < 1e-12);
    }
}
