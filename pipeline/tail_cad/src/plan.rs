//! Plan: lines across the tail, divided between its features, with triangles between neighbouring lines.

use super::{Resolution, Tail};
use si::{Metre, Point2};

/// A feature that ends at a height on a line across the tail, in increasing height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Mark {
    Axis,
    Channel,
    Slot,
    Sheet,
    Back,
    Fin,
}

/// Points on one line of constant x: the marks with their index among the points.
struct Row {
    marks: Vec<(Mark, usize)>,
    points: Vec<u32>,
}

/// Triangles over the upper half of the tail's middle plane.
pub(crate) struct Plan {
    /// (z, x) of each vertex, m: a counterclockwise triangle has its normal along +y.
    pub points: Vec<Point2>,
    pub triangles: Vec<[u32; 3]>,
}

impl Plan {
    /// The plan of a tail whose numbers have been checked.
    pub fn new(tail: &Tail, resolution: &Resolution) -> Self {
        let mut plan = Self { points: Vec::new(), triangles: Vec::new() };
        let rows: Vec<Row> =
            line_positions(tail, resolution).iter().map(|&x| plan.plan_row(tail, x, resolution.edge)).collect();
        rows.windows(2).for_each(|pair| plan.zip_rows(&pair[0], &pair[1]));
        plan
    }

    fn plan_row(&mut self, tail: &Tail, x: Metre, edge: Metre) -> Row {
        let marks = row_marks(tail, x);
        let mut row = Row { marks: Vec::new(), points: Vec::new() };
        let mut reached = f64::NEG_INFINITY;
        for (mark, z) in marks {
            let gap = z - reached;
            let pieces = if reached.is_finite() { (gap / edge).round().max(1.0) as usize } else { 1 };
            for piece in (1..=pieces).filter(|_| gap > 1e-9) {
                let z = if piece == pieces { z } else { reached + gap * piece as f64 / pieces as f64 };
                row.points.push(self.points.len() as u32);
                self.points.push([z, x]);
            }
            row.marks.push((mark, row.points.len() - 1));
            reached = z;
        }
        row
    }

    /// Triangles between two rows, mark by mark where both have it.
    fn zip_rows(&mut self, left: &Row, right: &Row) {
        let partner = |m: Mark| right.marks.iter().find(|r| r.0 == m).map(|r| r.1);
        let shared: Vec<_> = left.marks.iter().filter_map(|&(m, i)| partner(m).map(|j| (i, j))).collect();
        for pair in shared.windows(2) {
            self.join_rows(&left.points[pair[0].0..=pair[1].0], &right.points[pair[0].1..=pair[1].1]);
        }
    }

    /// Triangles between two chains of points, each step over the shorter diagonal.
    fn join_rows(&mut self, left: &[u32], right: &[u32]) {
        let (mut i, mut j) = (0, 0);
        while i + 1 < left.len() || j + 1 < right.len() {
            let step_left = match (left.get(i + 1), right.get(j + 1)) {
                (Some(&l), Some(&r)) => self.distance(l, right[j]) <= self.distance(left[i], r),
                (next, _) => next.is_some(),
            };
            let third = if step_left { left[i + 1] } else { right[j + 1] };
            self.triangles.push([left[i], third, right[j]]);
            if step_left { i += 1 } else { j += 1 }
        }
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (self.points[a as usize], self.points[b as usize]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    }
}

/// The heights at which features end on the line at `x`.
fn row_marks(tail: &Tail, x: Metre) -> Vec<(Mark, Metre)> {
    let mut marks = vec![(Mark::Axis, 0.0)];
    if let Some(rib) = rib_touching(tail, x) {
        marks.push((Mark::Channel, tail.channel_half_height));
        marks.push((Mark::Slot, tail.slot_half_height(rib)));
    }
    let (root, sheet) = (tail.fin_root(), tail.sheet_half_height(x));
    let body = x <= tail.body_end();
    if x <= root {
        marks.push((Mark::Sheet, sheet));
    }
    if body {
        marks.push((Mark::Back, if x == root { sheet } else { tail.half_height(x) }));
    }
    if x >= root {
        marks.push((Mark::Fin, sheet));
    }
    marks
}

/// Heights of all outlines on a line between two stations, m, rising.
pub(crate) fn outlines_across(tail: &Tail, x: Metre) -> Vec<Metre> {
    row_marks(tail, x).into_iter().map(|(_, z)| z).collect()
}

/// The rib that has `x` inside it or at its edge.
fn rib_touching(tail: &Tail, x: Metre) -> Option<usize> {
    (1..tail.chambers).map(|i| i - 1).find(|&i| (tail.rib_at(i)[0]..=tail.rib_at(i)[1]).contains(&x))
}

/// Places of the lines along the tail, m, rising.
fn line_positions(tail: &Tail, resolution: &Resolution) -> Vec<Metre> {
    let mut positions = vec![0.0];
    let edge = resolution.edge;
    let head = (tail.chambers_start / edge).round().max(1.0) as usize;
    divide_evenly(&mut positions, tail.chambers_start, head);
    for chamber in 0..tail.chambers {
        let [from, to] = tail.chamber(chamber);
        let ratio = ((to - from) / tail.chamber_length()).round().max(1.0) as usize;
        divide_evenly(&mut positions, to, ratio * resolution.per_chamber);
        if chamber + 1 < tail.chambers {
            divide_evenly(&mut positions, tail.rib_at(chamber)[1], resolution.per_rib);
        }
    }
    for end in [tail.fin_root(), tail.body_end(), tail.length()] {
        divide_by_arc_length(&mut positions, tail, end, edge);
    }
    positions
}

/// Even steps to `end`.
fn divide_evenly(positions: &mut Vec<Metre>, end: Metre, pieces: usize) {
    let start = positions.last().copied().unwrap_or(0.0);
    positions.extend((1..pieces).map(|i| start + (end - start) * i as f64 / pieces as f64));
    positions.push(end);
}

/// Steps to `end` that keep the pieces of the fin's edge about as long as `edge`.
fn divide_by_arc_length(positions: &mut Vec<Metre>, tail: &Tail, end: Metre, edge: Metre) {
    let start = positions.last().copied().unwrap_or(0.0);
    let fine = 200;
    let position = |i: usize| start + (end - start) * i as f64 / f64::from(fine as u32);
    let slope = |i: usize| {
        let rise = tail.sheet_half_height(position(i + 1)) - tail.sheet_half_height(position(i));
        rise.hypot(position(i + 1) - position(i))
    };
    let lengths: Vec<f64> = (0..fine).map(slope).collect();
    let total: f64 = lengths.iter().sum();
    let pieces = (total / edge).round().max(1.0) as usize;
    let mut sum = 0.0;
    let mut next = 1;
    for (i, length) in lengths.iter().enumerate() {
        sum += length;
        if next < pieces && sum >= total * next as f64 / pieces as f64 {
            positions.push(position(i + 1));
            next += 1;
        }
    }
    positions.push(end);
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::frame::doubled_area;

    #[test]
    fn the_plan_covers_the_outline_with_triangles_that_turn_left() {
        let tail = Tail::nine_chambers();
        let plan = Plan::new(&tail, &Resolution::even(&tail, 3e-3));
        let areas = plan.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| plan.points[v as usize]);
            doubled_area(a, b, c) / 2.0
        });
        let areas: Vec<f64> = areas.collect();
        assert!(areas.iter().all(|&a| a > 0.0));
        let outline = |x: f64| {
            let fin = if x > tail.fin_root() { tail.sheet_half_height(x) } else { 0.0 };
            fin.max(if x < tail.body_end() { tail.half_height(x) } else { 0.0 })
        };
        let steps = 20_000;
        let exact: f64 = (0..steps).map(|i| outline((f64::from(i) + 0.5) * tail.length() / f64::from(steps))).sum();
        let exact = exact * tail.length() / f64::from(steps);
        let sum: f64 = areas.iter().sum();
        assert!((sum / exact - 1.0).abs() < 0.01, "{sum} against {exact}");
    }
}
