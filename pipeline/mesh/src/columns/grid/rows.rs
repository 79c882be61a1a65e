//! Rows: points of the plan on lines across it, from outline to outline, and the quadrilaterals between neighbouring rows.
//!
//! Outlines that end on a line leave a point there. Such points are continued through the strips beside them until both ends of a strip have
//! as many, so that nearly all cells are quadrilaterals; where that would make cells too short, triangles change the number.

use super::stations::Slab;
use si::{Metre, Point2};
use std::collections::BTreeMap;

/// Where cells are divided beyond the outlines' own points.
#[derive(Debug, Clone)]
pub(crate) struct Division {
    /// Rows between the stations of each slab, as fractions of it.
    pub inside: Vec<Vec<f64>>,
    /// Longest cell along a row, m: up to halfway from the middle of the body to its edge, and beyond.
    pub longest: [Metre; 2],
    /// Whether rows begin in the middle of the body.
    pub half: bool,
    /// Points are not continued where cells would be shorter than this, m.
    pub shortest: Metre,
    /// Points of a row within this are one, m.
    pub tolerance: Metre,
}

impl Division {
    /// Cells between the outlines' own points.
    pub(crate) fn undivided(slabs: usize, tolerance: Metre) -> Self {
        Self {
            inside: vec![Vec::new(); slabs],
            longest: [f64::INFINITY; 2],
            half: true,
            shortest: f64::INFINITY,
            tolerance,
        }
    }

    /// Longest cell about a place of a row, m.
    fn longest_on(&self, row: &Row) -> impl Fn(Metre) -> Metre + use<> {
        let [first, last] = [row.points.first(), row.points.last()].map(|end| end.copied().unwrap_or_default());
        let middle = if self.half { first } else { 0.5 * (first + last) };
        let [inner, outer] = self.longest;
        move |p| if (p - middle).abs() > 0.5 * (last - middle) { outer } else { inner }
    }
}

/// A cell of the plan: four corners, counterclockwise, and the middles of its sides as on an 8-node face; a triangle repeats its third corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell {
    pub nodes: [u32; 8],
    /// The strip in which it lies: numbered over all slabs.
    pub strip: u32,
}

/// The cells of a plan.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    /// (p, q) of corners and middles, m.
    pub points: Vec<Point2>,
    pub cells: Vec<Cell>,
    /// Number of strips.
    pub strips: u32,
    numbers: BTreeMap<[u32; 2], u32>,
}

/// Points on a line, in rising p, m.
#[derive(Debug, Clone)]
struct Row {
    q: Metre,
    points: Vec<Metre>,
}

impl Row {
    fn insert_point(&mut self, p: Metre, tolerance: Metre) {
        let index = self.points.partition_point(|other| *other < p);
        let is_near = |n: Option<&Metre>| n.is_some_and(|other| (other - p).abs() <= tolerance);
        if !is_near(self.points.get(index)) && !is_near(index.checked_sub(1).and_then(|n| self.points.get(n))) {
            self.points.insert(index, p);
        }
    }

    /// Index of the point nearest to p.
    fn nearest_index(&self, p: Metre) -> usize {
        let distance = |n: &usize| (self.points[*n] - p).abs();
        (0..self.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// Indices of the ends of a strip of `slab`, whose curve `lower` lies below it.
    fn strip_ends(&self, slab: &Slab, lower: usize) -> [usize; 2] {
        [lower, lower + 1].map(|curve| self.nearest_index(slab.curve_position(curve, self.q)))
    }

    /// Places of the points strictly within a strip, as fractions of it; none of one that has shrunk.
    fn strip_fractions(&self, [from, to]: [usize; 2]) -> Vec<f64> {
        let height = self.points[to] - self.points[from];
        (from + 1..to.max(from + 1)).map(|n| (self.points[n] - self.points[from]) / height).collect()
    }
}

/// The cells of a plan in `slabs`.
pub(crate) fn plan_cells(slabs: &[Slab], division: &Division) -> Cells {
    let mut stations = station_rows(slabs, division.tolerance);
    divide_strips(slabs, &mut stations, division);
    // It ends, since each round adds points that keep the shortest length from all others.
    while continue_points(slabs, &mut stations, division) {}
    let mut cells = Cells::default();
    let numbers: Vec<Vec<u32>> = stations.iter().map(|row| cells.number_row(row)).collect();
    for (n, slab) in slabs.iter().enumerate() {
        let [first, last] = [n, n + 1].map(|n| (&stations[n], numbers[n].clone()));
        let inner = division.inside[n].iter().map(|part| row_between(slab, first.0, last.0, *part));
        let inner: Vec<Row> = inner.collect();
        let mut left_row = first;
        for row in &inner {
            let right_row = (row, cells.number_row(row));
            cells.join_rows(slab, &left_row, &right_row);
            left_row = right_row;
        }
        cells.join_rows(slab, &left_row, &last);
        cells.strips += slab.curves().saturating_sub(1) as u32;
    }
    cells
}

/// The points that outlines leave on each station.
fn station_rows(slabs: &[Slab], tolerance: Metre) -> Vec<Row> {
    let places = slabs.first().map(|slab| slab.from).into_iter().chain(slabs.iter().map(|slab| slab.to));
    let mut rows: Vec<Row> = places.map(|q| Row { q, points: Vec::new() }).collect();
    for (n, slab) in slabs.iter().enumerate() {
        for row in &mut rows[n..=n + 1] {
            (0..slab.curves()).for_each(|curve| row.insert_point(slab.curve_position(curve, row.q), tolerance));
        }
    }
    rows
}

/// Divides strips that are longer than the longest cell, evenly.
fn divide_strips(slabs: &[Slab], stations: &mut [Row], division: &Division) {
    for (n, lower) in all_strips(slabs) {
        for row in &mut stations[n..=n + 1] {
            let [from, to] = row.strip_ends(&slabs[n], lower);
            let points: Vec<Metre> = row.points[from..=to.max(from)].to_vec();
            let longest = division.longest_on(row);
            for pair in points.windows(2) {
                let pieces = ((pair[1] - pair[0]) / longest(0.5 * (pair[0] + pair[1]))).ceil().max(1.0) as usize;
                let division_point = |k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / pieces as f64;
                (1..pieces).for_each(|k| row.insert_point(division_point(k), division.tolerance));
            }
        }
    }
}

fn all_strips(slabs: &[Slab]) -> impl Iterator<Item = (usize, usize)> {
    slabs.iter().enumerate().flat_map(|(n, slab)| (0..slab.curves().saturating_sub(1)).map(move |lower| (n, lower)))
}

/// Continues points from the end of a strip that has more of them to the other, once for every strip; whether there was any.
fn continue_points(slabs: &[Slab], stations: &mut [Row], division: &Division) -> bool {
    let mut any = false;
    for (n, lower) in all_strips(slabs) {
        let ends = [n, n + 1].map(|station| stations[station].strip_ends(&slabs[n], lower));
        let fractions = [0, 1].map(|end| stations[n + end].strip_fractions(ends[end]));
        let (few, many) = if fractions[0].len() < fractions[1].len() { (0, 1) } else { (1, 0) };
        let row = &mut stations[n + few];
        let [from, to] = ends[few].map(|index| row.points[index]);
        // the point that is farthest from all points at the other end
        let mut known_fractions = fractions[few].clone();
        known_fractions.extend([0.0, 1.0]);
        let distance_from_known =
            |part: &f64| known_fractions.iter().map(|other| (other - part).abs()).fold(f64::INFINITY, f64::min);
        let missing = fractions[many].iter().max_by(|a, b| distance_from_known(a).total_cmp(&distance_from_known(b)));
        let Some(missing) = missing.filter(|_| fractions[few].len() < fractions[many].len()) else { continue };
        if distance_from_known(missing) * (to - from) >= division.shortest {
            row.insert_point(from + missing * (to - from), division.tolerance);
            any = true;
        }
    }
    any
}

/// A row within a slab: the points of each strip, at the mean fractions of those of its ends where they are as many, at those of the end that
/// has more elsewhere.
fn row_between(slab: &Slab, first: &Row, last: &Row, part: f64) -> Row {
    let q = slab.from + part * (slab.to - slab.from);
    let mut points = vec![slab.curve_position(0, q)];
    for lower in 0..slab.curves().saturating_sub(1) {
        let [a, b] = [first, last].map(|row| row.strip_fractions(row.strip_ends(slab, lower)));
        let [from, to] = [lower, lower + 1].map(|curve| slab.curve_position(curve, q));
        let fractions: Vec<f64> = match a.len() == b.len() {
            true => a.iter().zip(&b).map(|(a, b)| a + part * (b - a)).collect(),
            false if a.len() > b.len() => a,
            false => b,
        };
        points.extend(fractions.iter().map(|part| from + part * (to - from)).chain([to]));
    }
    Row { q, points }
}

impl Cells {
    fn add_point(&mut self, point: Point2) -> u32 {
        self.points.push(point);
        self.points.len() as u32 - 1
    }

    fn number_row(&mut self, row: &Row) -> Vec<u32> {
        row.points.iter().map(|&p| self.add_point([p, row.q])).collect()
    }

    /// The cells between two rows of a slab.
    fn join_rows(&mut self, slab: &Slab, left: &(&Row, Vec<u32>), right: &(&Row, Vec<u32>)) {
        for lower in 0..slab.curves().saturating_sub(1) {
            let chain = |(row, numbers): &(&Row, Vec<u32>)| {
                let [from, to] = row.strip_ends(slab, lower);
                numbers[from..=to.max(from)].to_vec()
            };
            let strip = Strip { slab, lower, number: self.strips + lower as u32 };
            self.fill_strip(&strip, &chain(left), &chain(right));
        }
    }

    /// Quadrilaterals between two chains of points; triangles where one has more.
    fn fill_strip(&mut self, strip: &Strip, left: &[u32], right: &[u32]) {
        let part = |cells: &Self, chain: &[u32], n: usize| strip.strip_fraction(cells.points[chain[n] as usize]);
        let (mut i, mut j) = (0, 0);
        while i + 1 < left.len() || j + 1 < right.len() {
            let remaining = [left.len() - 1 - i, right.len() - 1 - j];
            let corners = if remaining[0] == remaining[1] {
                (i, j) = (i + 1, j + 1);
                [left[i - 1], left[i], right[j], right[j - 1]]
            } else {
                let more = if remaining[0] > remaining[1] { (left, i, right, j) } else { (right, j, left, i) };
                let (many, m, few, f) = more;
                let ahead = part(self, many, m + 1);
                let current_distance = (part(self, few, f) - ahead).abs();
                if f + 1 == few.len() || current_distance < (part(self, few, f + 1) - ahead).abs() {
                    if remaining[0] > remaining[1] {
                        i += 1;
                        [left[i - 1], left[i], right[j], right[j]]
                    } else {
                        j += 1;
                        [left[i], right[j], right[j - 1], right[j - 1]]
                    }
                } else {
                    (i, j) = (i + 1, j + 1);
                    [left[i - 1], left[i], right[j], right[j - 1]]
                }
            };
            let middles = [0, 1, 2, 3].map(|n| self.middle_point(strip, corners[n], corners[(n + 1) % 4]));
            let nodes = std::array::from_fn(|n| if n < 4 { corners[n] } else { middles[n - 4] });
            self.cells.push(Cell { nodes, strip: strip.number });
        }
    }

    /// The middle between two points: on the same curve as they, or at their mean fraction of the strip.
    fn middle_point(&mut self, strip: &Strip, a: u32, b: u32) -> u32 {
        if a == b {
            return a;
        }
        if let Some(&middle) = self.numbers.get(&[a.min(b), a.max(b)]) {
            return middle;
        }
        let [from, to] = [a, b].map(|n| self.points[n as usize]);
        let q = 0.5 * (from[1] + to[1]);
        let p = if from[1] == to[1] {
            0.5 * (from[0] + to[0])
        } else {
            // where the strip has shrunk to a point, that point has the fraction of the other end
            let [one, other] = [from, to].map(|at| strip.strip_height(at[1]) > 0.0);
            let [a, b] =
                [if one { from } else { to }, if other { to } else { from }].map(|at| strip.strip_fraction(at));
            strip.place_at(0.5 * (a + b), q)
        };
        let middle = self.add_point([p, q]);
        self.numbers.insert([a.min(b), a.max(b)], middle);
        middle
    }
}

/// The plan between two neighbouring curves of a slab.
struct Strip<'a> {
    slab: &'a Slab,
    lower: usize,
    number: u32,
}

impl Strip<'_> {
    fn place_at(&self, part: f64, q: Metre) -> Metre {
        let lower_place = self.slab.curve_position(self.lower, q);
        lower_place + part * (self.slab.curve_position(self.lower + 1, q) - lower_place)
    }

    /// m; zero where it has shrunk to a point, to a hundred-thousandth of the slab.
    fn strip_height(&self, q: Metre) -> Metre {
        let height = self.slab.curve_position(self.lower + 1, q) - self.slab.curve_position(self.lower, q);
        // Outlines are sampled a millionth of the slab beside its ends, where a strip that ends in a point is about
        // that high.
        if height > 1e-5 * (self.slab.to - self.slab.from) { height } else { 0.0 }
    }

    /// The place of a point across the strip, 0 to 1.
    fn strip_fraction(&self, point: Point2) -> f64 {
        match self.strip_height(point[1]) {
            0.0 => 0.0,
            height => ((point[0] - self.slab.curve_position(self.lower, point[1])) / height).clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::arrange::arrange_segments;
    use crate::columns::grid::stations::find_slabs;
    use crate::frame::doubled_area;

    fn ring(points: &[Point2]) -> Vec<[Point2; 2]> {
        (0..points.len()).map(|n| [points[n], points[(n + 1) % points.len()]]).collect()
    }

    fn area(cells: &Cells, cell: &Cell) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|n| cells.points[cell.nodes[n] as usize]);
        0.5 * (doubled_area(a, b, c) + doubled_area(a, c, d))
    }

    #[test]
    fn points_of_a_box_within_a_box_are_continued_so_that_all_cells_are_quadrilaterals() {
        let square = |low: Point2, high: Point2| ring(&[low, [high[0], low[1]], high, [low[0], high[1]]]);
        let lines = [square([0.0, 0.0], [3.0, 9.0]), square([1.0, 4.0], [2.0, 5.0])].concat();
        let slabs = find_slabs(&arrange_segments(&lines, 1e-6), 1e-3).unwrap();
        let division = Division {
            inside: vec![vec![0.5], vec![], vec![]],
            longest: [9.0; 2],
            half: false,
            shortest: 0.1,
            tolerance: 1e-3,
        };
        let cells = plan_cells(&slabs, &division);
        assert_eq!((cells.cells.len(), cells.strips), (3 * 4, 5));
        assert!(cells.cells.iter().all(|cell| cell.nodes[2] != cell.nodes[3] && area(&cells, cell) > 0.0));
        assert!((cells.cells.iter().map(|cell| area(&cells, cell)).sum::<f64>() - 27.0).abs() < 1e-9);
    }

    #[test]
    fn a_strip_that_shrinks_to_a_point_ends_in_triangles_and_curved_sides_have_their_middles_on_the_outline() {
        let outline: Vec<Point2> =
            (0..=100).map(|n| f64::from(n) / 100.0).map(|q| [1.0 - q * q, q]).chain([[0.0, 0.0]]).collect();
        let slabs = find_slabs(&arrange_segments(&ring(&outline), 1e-6), 1e-4).unwrap();
        let inside = slabs.iter().map(|_| vec![0.5]).collect();
        let cells =
            plan_cells(&slabs, &Division { inside, longest: [0.4; 2], half: false, shortest: 0.05, tolerance: 1e-4 });
        let sum: f64 = cells.cells.iter().map(|cell| area(&cells, cell)).sum();
        assert!(cells.cells.iter().all(|cell| area(&cells, cell) > 0.0) && sum < 2.0 / 3.0 && sum > 0.6, "{sum}");
        assert!(cells.cells.iter().any(|cell| cell.nodes[2] == cell.nodes[3]));
        let on_curve = |at: &Point2| (at[0] - (1.0 - at[1] * at[1])).abs() < 1e-3;
        assert!(cells.points.iter().filter(|at| on_curve(at)).count() >= 5);
    }
}
