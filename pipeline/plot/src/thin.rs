//! Simplification of lines: points below the resolution of print are left out.

use si::Point2;

/// Lines with more points are first reduced to the extremes of each column: Ramer–Douglas–Peucker is quadratic in the
/// worst case.
const MANY: usize = 4000;
/// Width of a column, in points of print: half of the finest line.
const COLUMN: f64 = 0.25;

/// The same line with fewer points, at most `tolerance` away from it (Ramer–Douglas–Peucker).
///
/// Above [`MANY`] points, a line that runs to the right is first reduced to the first, lowest, highest and last point
/// of each [`COLUMN`], which covers the same area of print.
pub(crate) fn thin_line(points: &[Point2], tolerance: f64) -> Vec<Point2> {
    let rightwards = points.windows(2).all(|p| p[1][0] >= p[0][0]);
    let points = if points.len() > MANY && rightwards { column_extremes(points) } else { points.to_vec() };
    if points.len() < 3 {
        return points;
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let distance_to_chord = |i: usize| distance(points[i], points[first], points[last]);
        let farthest = (first + 1..last).max_by(|&i, &j| distance_to_chord(i).total_cmp(&distance_to_chord(j)));
        if let Some(middle) = farthest.filter(|&i| distance_to_chord(i) > tolerance) {
            keep[middle] = true;
            open.extend([(first, middle), (middle, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(p, _)| *p).collect()
}

/// Distance of a point from a segment.
fn distance(p: Point2, a: Point2, b: Point2) -> f64 {
    let way = [b[0] - a[0], b[1] - a[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    let projection = if square == 0.0 { 0.0 } else { ((p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1]) / square };
    let t = projection.clamp(0.0, 1.0);
    (p[0] - a[0] - t * way[0]).hypot(p[1] - a[1] - t * way[1])
}

fn column_extremes(points: &[Point2]) -> Vec<Point2> {
    let column = |p: &Point2| (p[0] / COLUMN).floor();
    let mut kept_points = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let lowest = (0..group.len()).min_by(|&i, &j| group[i][1].total_cmp(&group[j][1])).unwrap_or(0);
        let highest = (0..group.len()).max_by(|&i, &j| group[i][1].total_cmp(&group[j][1])).unwrap_or(0);
        let mut places = vec![0, lowest, highest, group.len() - 1];
        places.sort_unstable();
        places.dedup();
        kept_points.extend(places.into_iter().map(|i| group[i]));
    }
    kept_points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_two_ends() {
        let points: Vec<Point2> = (0..100).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        assert_eq!(thin_line(&points, 0.01), vec![[0.0, 0.0], [99.0, 198.0]]);
    }

    #[test]
    fn every_dropped_point_is_within_the_tolerance() {
        let points: Vec<Point2> = (0..500).map(|i| f64::from(i) * 0.1).map(|x| [x, 10.0 * x.sin()]).collect();
        let thin = thin_line(&points, 0.05);
        assert!(thin.len() < points.len() / 2);
        for p in &points {
            let nearest = thin.windows(2).map(|s| distance(*p, s[0], s[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.05);
        }
    }

    #[test]
    fn a_long_noisy_line_keeps_its_highest_point() {
        let mut points: Vec<Point2> = (0..100_000).map(|i| [f64::from(i) * 0.002, f64::from(i % 7)]).collect();
        points[54_321][1] = 99.0;
        let thin = thin_line(&points, 0.05);
        assert!(thin.iter().any(|p| p[1] == 99.0) && thin.len() < 4000, "{}", thin.len());
    }
}
