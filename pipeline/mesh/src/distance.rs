//! Nearest point on a set of triangles, with a uniform grid of cells.

use si::vec3::{add, dot, norm, scale, sub};
use si::{Metre, Point3};

/// Triangles sorted into cells.
pub(crate) struct Nearest {
    corners: Vec<[Point3; 3]>,
    low: Point3,
    cell: Metre,
    counts: [usize; 3],
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// The nearest point of the triangles to a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    pub face: usize,
    /// Barycentric coordinates.
    pub shares: [f64; 3],
    pub distance: Metre,
}

impl Nearest {
    /// Cells are as wide as the mean triangle, at most 64 a side.
    pub fn new(corners: Vec<[Point3; 3]>) -> Self {
        let (mut low, mut high, mut size) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0);
        for c in &corners {
            let (l, h) = bounding_box(c);
            (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(l[k]), high[k].max(h[k])));
            size += norm(sub(h, l));
        }
        let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        // 64 a side bound the grid to some 0.26 million cells, however small the triangles of a large surface are.
        let cell = (size / corners.len().max(1) as f64).max(side / 64.0).max(f64::MIN_POSITIVE);
        let counts = [0, 1, 2].map(|k| (((high[k] - low[k]) / cell) as usize) + 1);
        let mut grid = Self { corners, low, cell, counts, starts: Vec::new(), members: Vec::new() };
        grid.sort_into_cells();
        grid
    }

    fn sort_into_cells(&mut self) {
        let mut pairs = Vec::new();
        for (face, corners) in self.corners.iter().enumerate() {
            let (low, high) = bounding_box(corners);
            let (first, last) = (self.cell_of(low), self.cell_of(high));
            each_cell(first, last, |c| pairs.push((self.cell_index(c) as u32, face as u32)));
        }
        pairs.sort_unstable();
        let cells = self.counts.iter().product::<usize>();
        self.starts = (0..=cells).map(|c| pairs.partition_point(|p| (p.0 as usize) < c) as u32).collect();
        self.members = pairs.into_iter().map(|p| p.1).collect();
    }

    fn cell_of(&self, at: Point3) -> [usize; 3] {
        [0, 1, 2].map(|k| (((at[k] - self.low[k]) / self.cell).max(0.0) as usize).min(self.counts[k] - 1))
    }

    fn cell_index(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]
    }

    /// The corners of the triangle that was hit.
    pub fn corners(&self, hit: &Hit) -> [Point3; 3] {
        self.corners[hit.face]
    }

    /// The nearest point to `point`; of equally near faces the one with the lowest number.
    pub fn find(&self, point: Point3) -> Option<Hit> {
        let (centre, mut best) = (self.cell_of(point), None::<Hit>);
        for ring in 0..self.counts.iter().copied().max().unwrap_or(0) {
            if best.is_some_and(|b| b.distance < self.ring_distance(point, centre, ring)) {
                break;
            }
            self.visit_ring(centre, ring, |cell| self.search_cell(cell, point, &mut best));
        }
        best
    }

    /// How far from `point` the cells of this ring begin, m; infinite when none are left.
    fn ring_distance(&self, point: Point3, centre: [usize; 3], ring: usize) -> Metre {
        let wall = |k: usize, cell: usize| self.low[k] + cell as f64 * self.cell;
        let side = |k: usize| {
            let lower_distance = centre[k].checked_sub(ring).map(|_| point[k] - wall(k, centre[k] + 1 - ring));
            let upper_distance = (centre[k] + ring < self.counts[k]).then(|| wall(k, centre[k] + ring) - point[k]);
            lower_distance.unwrap_or(f64::INFINITY).min(upper_distance.unwrap_or(f64::INFINITY))
        };
        if ring == 0 { 0.0 } else { side(0).min(side(1)).min(side(2)) }
    }

    fn visit_ring(&self, centre: [usize; 3], ring: usize, mut visit: impl FnMut([usize; 3])) {
        let first = centre.map(|c| c.saturating_sub(ring));
        let last = [0, 1, 2].map(|k| (centre[k] + ring).min(self.counts[k] - 1));
        each_cell(first, last, |cell| {
            if (0..3).any(|k| cell[k].abs_diff(centre[k]) == ring) {
                visit(cell);
            }
        });
    }

    fn search_cell(&self, cell: [usize; 3], point: Point3, best: &mut Option<Hit>) {
        let cell = self.cell_index(cell);
        for &face in &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            let (shares, distance) = on_triangle(point, &self.corners[face as usize]);
            let wins = |b: &Hit| (distance, face as usize) < (b.distance, b.face);
            if best.as_ref().is_none_or(wins) {
                *best = Some(Hit { face: face as usize, shares, distance });
            }
        }
    }
}

fn bounding_box(corners: &[Point3; 3]) -> (Point3, Point3) {
    let [a, b, c] = corners;
    ([0, 1, 2].map(|k| a[k].min(b[k]).min(c[k])), [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k])))
}

fn each_cell(first: [usize; 3], last: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            (first[0]..=last[0]).for_each(|x| visit([x, y, z]));
        }
    }
}

/// Barycentric coordinates of the triangle's point nearest to `at`, and the distance [ericson2005, section 5.1.5].
fn on_triangle(at: Point3, &[a, b, c]: &[Point3; 3]) -> ([f64; 3], Metre) {
    let shares = nearest_shares(at, a, b, c);
    let point = add(add(scale(a, shares[0]), scale(b, shares[1])), scale(c, shares[2]));
    (shares, norm(sub(at, point)))
}

fn nearest_shares(at: Point3, a: Point3, b: Point3, c: Point3) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(at, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(at, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let cp = sub(at, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::block;

    #[test]
    fn the_nearest_point_of_a_box_is_found_from_inside_outside_and_far_away() {
        let solid = block([0.0; 3], [1.0, 2.0, 3.0]);
        let near = Nearest::new((0..12).map(|f| solid.corners(f)).collect());
        let distance = |at| near.find(at).unwrap().distance;
        assert!((distance([0.5, 1.0, 2.9]) - 0.1).abs() < 1e-12);
        assert!((distance([-3.0, 1.0, 7.0]) - 5.0).abs() < 1e-12);
        assert!((distance([50.0, 1.0, 1.0]) - 49.0).abs() < 1e-12);
    }
}
