//! Contours: lines of equal value over a grid, by marching squares.

use si::Point2;

/// Values on a uniform grid; a point of the grid is [column, row].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Field {
    /// Columns.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// rows × columns; NaN for a missing value.
    pub values: Vec<f64>,
}

impl Field {
    fn value_at(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// Bilinear interpolation; NaN beside a missing value.
    pub fn interpolate(&self, p: Point2) -> f64 {
        let cell = |v: f64, most: usize| (v.floor().max(0.0) as usize).min(most.saturating_sub(2));
        let (i, j) = (cell(p[0], self.columns), cell(p[1], self.rows));
        let (s, t) = (p[0] - i as f64, p[1] - j as f64);
        // at a grid line the other neighbour has no weight: 0 × NaN must not erase a value that exists
        let mix = |a: f64, b: f64, part: f64| {
            if part == 0.0 {
                a
            } else if part == 1.0 {
                b
            } else {
                a * (1.0 - part) + b * part
            }
        };
        mix(
            mix(self.value_at(i, j), self.value_at(i + 1, j), s),
            mix(self.value_at(i, j + 1), self.value_at(i + 1, j + 1), s),
            t,
        )
    }

    /// The same field on a grid `times` as fine.
    pub(crate) fn refined_field(&self, times: usize) -> Self {
        let (columns, rows) = ((self.columns - 1) * times + 1, (self.rows - 1) * times + 1);
        let node = |k: usize| [(k % columns) as f64 / times as f64, (k / columns) as f64 / times as f64];
        Self { columns, rows, values: (0..columns * rows).map(|k| self.interpolate(node(k))).collect() }
    }

    /// The contour lines of one level, in grid coordinates.
    pub(crate) fn contour_lines(&self, level: f64) -> Vec<Vec<Point2>> {
        let mut segments = Vec::new();
        for row in 0..self.rows - 1 {
            for column in 0..self.columns - 1 {
                self.cross_cell(column, row, level, &mut segments);
            }
        }
        join_segments(segments)
    }

    /// The segments of a contour line inside of one cell.
    fn cross_cell(&self, column: usize, row: usize, level: f64, segments: &mut Vec<[Point2; 2]>) {
        let corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)];
        let values = corners.map(|(i, j)| self.value_at(i, j));
        if values.iter().any(|v| v.is_nan()) {
            return;
        }
        let crossing = |k: usize| {
            let (a, b) = (k, (k + 1) % 4);
            if (values[a] > level) == (values[b] > level) {
                return None;
            }
            // always from the lower index: both cells at an edge compute the same crossing, bit by bit, and segments join
            let (a, b) = if corners[a] <= corners[b] { (a, b) } else { (b, a) };
            let t = (level - values[a]) / (values[b] - values[a]);
            let (p, q) = (corners[a], corners[b]);
            Some([p.0 as f64 + t * (q.0 as f64 - p.0 as f64), p.1 as f64 + t * (q.1 as f64 - p.1 as f64)])
        };
        let crossings: Vec<Point2> = (0..4).filter_map(crossing).collect();
        match crossings[..] {
            [a, b] => segments.push([a, b]),
            // a saddle is ambiguous: the mean of the corners decides which of them are connected
            [a, b, c, d] if (0.25 * values.iter().sum::<f64>() > level) == (values[0] > level) => {
                segments.extend([[a, b], [c, d]]);
            }
            [a, b, c, d] => segments.extend([[a, d], [b, c]]),
            _ => {}
        }
    }
}

/// Segments joined end to end into lines, in a fixed order.
fn join_segments(mut segments: Vec<[Point2; 2]>) -> Vec<Vec<Point2>> {
    let mut lines = Vec::new();
    while let Some([a, b]) = segments.pop() {
        let mut line = vec![a, b];
        for _ in 0..2 {
            while let Some(next) = take_neighbour(&mut segments, line[line.len() - 1]) {
                line.push(next);
            }
            line.reverse();
        }
        lines.push(line);
    }
    lines
}

/// Takes out a segment that begins or ends at a point; returns its other end.
fn take_neighbour(segments: &mut Vec<[Point2; 2]>, end: Point2) -> Option<Point2> {
    let is_end = |p: Point2| (p[0] - end[0]).abs() + (p[1] - end[1]).abs() < 1e-9;
    let index = segments.iter().rposition(|s| is_end(s[0]) || is_end(s[1]))?;
    let [a, b] = segments.remove(index);
    Some(if is_end(a) { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bowl() -> Field {
        let value = |k: usize| ((k % 41) as f64 - 20.0).hypot((k / 41) as f64 - 20.0);
        Field { columns: 41, rows: 41, values: (0..41 * 41).map(value).collect() }
    }

    #[test]
    fn the_contour_of_a_bowl_is_one_closed_circle() {
        let lines = bowl().contour_lines(12.3);
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        let gap = (line[0][0] - line[line.len() - 1][0]).hypot(line[0][1] - line[line.len() - 1][1]);
        assert!(gap < 1e-9);
        // a cone between grid points differs from its linear pieces by 1 / (8 r)
        assert!(line.iter().all(|p| ((p[0] - 20.0).hypot(p[1] - 20.0) - 12.3).abs() < 0.02));
    }

    #[test]
    fn a_missing_value_opens_the_circle() {
        let mut field = bowl();
        field.values[20 * 41 + 32] = f64::NAN;
        let lines = field.contour_lines(12.3);
        assert!(lines.iter().all(|line| line.iter().all(|p| p.iter().all(|v| v.is_finite()))));
        let line = &lines[0];
        assert!((line[0][1] - line[line.len() - 1][1]).abs() > 1.0);
    }

    #[test]
    fn a_refined_field_keeps_its_grid_points() {
        let (coarse, fine) = (bowl(), bowl().refined_field(3));
        assert_eq!(fine.columns, 121);
        assert_eq!(fine.value_at(3 * 7, 3 * 5), coarse.value_at(7, 5));
    }

    #[test]
    fn a_saddle_is_parted_as_its_mean_says() {
        // high corners at (0, 0) and (1, 1); a mean above the level joins them, one below parts them
        let lines = |low: f64| Field { columns: 2, rows: 2, values: vec![1.0, low, low, 1.0] }.contour_lines(0.0);
        let cuts_off = |line: &Vec<Point2>, corner: Point2| {
            line.iter().all(|p| (p[0] - corner[0]).abs() + (p[1] - corner[1]).abs() < 1.0)
        };
        let (joined, parted) = (lines(-0.5), lines(-2.0));
        assert_eq!((joined.len(), parted.len()), (2, 2));
        assert!(
            [[1.0, 0.0], [0.0, 1.0]].iter().all(|corner| joined.iter().any(|line| cuts_off(line, *corner))),
            "{joined:?}"
        );
        assert!(
            [[0.0, 0.0], [1.0, 1.0]].iter().all(|corner| parted.iter().any(|line| cuts_off(line, *corner))),
            "{parted:?}"
        );
        // from 1 to −0.5 the level is crossed at two thirds of the way
        assert!(joined.iter().flatten().any(|p| (p[0] - 2.0 / 3.0).abs() < 1e-12 && p[1] == 0.0), "{joined:?}");
    }
}
