//! Arrangement of segments: plan segments, some of them nearly coincident, become edges that meet in shared vertices only.
//!
//! The two surfaces share faces but no triangulation: some vertices of one have no partner in the other. So vertices are
//! welded within a tolerance, and edges are split where they touch or cross.

use si::{Metre, Point2};
use std::collections::{BTreeSet, HashMap};

/// Vertices and edges of a plan; edges meet in vertices only, none twice.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Graph {
    pub points: Vec<Point2>,
    pub edges: Vec<[u32; 2]>,
}

/// Vertices with a least distance from each other, in a grid of cells.
struct VertexGrid {
    near: Metre,
    points: Vec<Point2>,
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl VertexGrid {
    fn cell_of(&self, point: Point2) -> [i64; 2] {
        point.map(|c| (c / self.near).floor() as i64)
    }

    /// The first vertex within the tolerance, or a new one.
    fn vertex_at(&mut self, point: Point2) -> u32 {
        let [cx, cy] = self.cell_of(point);
        let neighbour_cells = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [cx + dx, cy + dy]));
        let nearby = neighbour_cells.filter_map(|c| self.cells.get(&c)).flatten();
        let nearby = nearby.filter(|&&v| distance(self.points[v as usize], point) <= self.near);
        if let Some(&v) = nearby.min() {
            return v;
        }
        let v = self.points.len() as u32;
        self.points.push(point);
        self.cells.entry([cx, cy]).or_default().push(v);
        v
    }
}

pub(crate) fn distance(a: Point2, b: Point2) -> Metre {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Parameter (0 to 1) of the point of a segment nearest to `at`, and its distance.
pub(crate) fn nearest_on_segment(at: Point2, [a, b]: [Point2; 2]) -> (f64, Metre) {
    let (d, e) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let t = if length > 0.0 { ((d[0] * e[0] + d[1] * e[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    (t, distance(at, [a[0] + t * d[0], a[1] + t * d[1]]))
}

/// Arranges segments: vertices within `near` (m) become one, segments are cut where they touch or cross.
///
/// The first of several near vertices wins, so a line that must stay straight comes first.
pub(crate) fn arrange_segments(segments: &[[Point2; 2]], near: Metre) -> Graph {
    let mut grid = VertexGrid { near, points: Vec::new(), cells: HashMap::new() };
    let mut edges = BTreeSet::new();
    for s in segments {
        insert_edge(&mut edges, grid.vertex_at(s[0]), grid.vertex_at(s[1]));
    }
    // a split can create a new contact, so that splitting is repeated until nothing changes
    for _ in 0..20 {
        let cut = cut_round(&mut grid, &edges);
        if cut == edges {
            break;
        }
        edges = cut;
    }
    Graph { points: grid.points, edges: edges.into_iter().collect() }
}

fn insert_edge(edges: &mut BTreeSet<[u32; 2]>, a: u32, b: u32) {
    if a != b {
        edges.insert([a.min(b), a.max(b)]);
    }
}

/// Cuts every edge at the vertices that lie on it and where another edge crosses it.
fn cut_round(grid: &mut VertexGrid, edges: &BTreeSet<[u32; 2]>) -> BTreeSet<[u32; 2]> {
    let edges: Vec<[u32; 2]> = edges.iter().copied().collect();
    let mut cuts: Vec<Vec<u32>> = vec![Vec::new(); edges.len()];
    cut_crossings(grid, &edges, &mut cuts);
    cut_touches(grid, &edges, &mut cuts);
    let mut cut = BTreeSet::new();
    for (edge, cuts_on_edge) in edges.iter().zip(&mut cuts) {
        let ends = edge.map(|v| grid.points[v as usize]);
        let share = |v: &u32| nearest_on_segment(grid.points[*v as usize], ends).0;
        cuts_on_edge.sort_by(|a, b| share(a).total_cmp(&share(b)).then(a.cmp(b)));
        let mut start = edge[0];
        for &v in cuts_on_edge.iter().chain([&edge[1]]) {
            insert_edge(&mut cut, start, v);
            start = v;
        }
    }
    cut
}

/// Finds pairs of edges that cross away from their ends, and makes a vertex there.
fn cut_crossings(grid: &mut VertexGrid, edges: &[[u32; 2]], cuts: &mut [Vec<u32>]) {
    for (i, j) in close_pairs(&edge_boxes(grid, edges)) {
        if edges[i].iter().any(|v| edges[j].contains(v)) {
            continue;
        }
        let [p, q] = [i, j].map(|e| edges[e].map(|v| grid.points[v as usize]));
        if let Some(at) = segment_crossing(p, q) {
            let v = grid.vertex_at(at);
            [i, j].into_iter().filter(|&e| !edges[e].contains(&v)).for_each(|e| cuts[e].push(v));
        }
    }
}

/// Finds vertices that lie on edges they do not end.
fn cut_touches(grid: &VertexGrid, edges: &[[u32; 2]], cuts: &mut [Vec<u32>]) {
    let mut bounds = edge_boxes(grid, edges);
    bounds.extend(grid.points.iter().map(|p| [*p, *p]));
    for (i, j) in close_pairs(&bounds) {
        let (edge, vertex) = (i.min(j), i.max(j));
        if edge >= edges.len() || vertex < edges.len() {
            continue;
        }
        let v = (vertex - edges.len()) as u32;
        let ends = edges[edge].map(|v| grid.points[v as usize]);
        if !edges[edge].contains(&v) && nearest_on_segment(grid.points[v as usize], ends).1 <= grid.near {
            cuts[edge].push(v);
        }
    }
    cuts.iter_mut().for_each(|c| {
        c.sort_unstable();
        c.dedup();
    });
}

fn edge_boxes(grid: &VertexGrid, edges: &[[u32; 2]]) -> Vec<[Point2; 2]> {
    let grown = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|v| grid.points[v as usize]);
        let n = grid.near;
        [[a[0].min(b[0]) - n, a[1].min(b[1]) - n], [a[0].max(b[0]) + n, a[1].max(b[1]) + n]]
    };
    edges.iter().map(grown).collect()
}

/// Pairs of boxes that overlap, by a sweep along the second axis (the longer one of a tail).
fn close_pairs(boxes: &[[Point2; 2]]) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0][1].total_cmp(&boxes[b][0][1]).then(a.cmp(&b)));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let reached = order[k + 1..].iter().take_while(|&&j| boxes[j][0][1] <= boxes[i][1][1]);
        let overlapping = reached.filter(|&&j| boxes[j][0][0] <= boxes[i][1][0] && boxes[i][0][0] <= boxes[j][1][0]);
        pairs.extend(overlapping.map(|&j| (i, j)));
    }
    pairs
}

/// Where two segments cross strictly inside both.
pub(crate) fn segment_crossing([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> Option<Point2> {
    use crate::frame::doubled_area;
    let (left, right) = (doubled_area(a, b, c), doubled_area(a, b, d));
    let (up, down) = (doubled_area(c, d, a), doubled_area(c, d, b));
    // Proper crossings alone: an end that touches the other segment, to rounding, would be cut twice, and is found as a
    // touch.
    if left * right >= 0.0 || up * down >= 0.0 {
        return None;
    }
    let t = up / (up - down);
    Some([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_touching_and_doubled_segments_become_one_graph() {
        let segments = [
            [[0.0, 0.0], [10.0, 0.0]],
            [[10.0, 0.0004], [4.0, -0.0003]], // nearly on the first
            [[5.0, -5.0], [5.0, 5.0]],        // crosses
            [[2.0, 3.0], [2.0, 0.0005]],      // ends on it
        ];
        let graph = arrange_segments(&segments, 0.001);
        assert_eq!(graph.points.len(), 8);
        assert_eq!(graph.edges.len(), 7);
    }
}
