//! Resampling: fine outlines become edges of the target length; corners and junctions are kept.

use super::arrange::{Graph, distance, nearest_on_segment};
use si::{Metre, Point2};

/// Turning angle above which a point is kept as a corner, degrees.
const CORNER: f64 = 20.0;

/// The resolution of an outline.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spacing {
    /// Length of edges, m.
    pub edge: Metre,
    /// Largest distance of an edge from the outline, m.
    pub chord: Metre,
    /// Deviations below this are noise, m.
    pub noise: Metre,
}

/// The same graph with edges of about the target length.
pub(crate) fn resample_graph(graph: &Graph, spacing: &Spacing) -> Graph {
    let mut out = Graph::default();
    let mut number = vec![u32::MAX; graph.points.len()];
    for chain in find_chains(graph) {
        let points: Vec<Point2> = chain.iter().map(|&v| graph.points[v as usize]).collect();
        let kept_points = simplify_path(&points, spacing.noise);
        let corners = path_corners(&points, &kept_points);
        for piece in corners.windows(2) {
            let mut vertex = |i: usize| keep_vertex(&mut out, &mut number, graph, chain[i]);
            let (first, last) = (vertex(piece[0]), vertex(piece[1]));
            let inner = divide_path(&points[piece[0]..=piece[1]], spacing, first == last);
            let mut previous = first;
            for point in inner {
                out.points.push(point);
                out.edges.push([previous, out.points.len() as u32 - 1]);
                previous = out.points.len() as u32 - 1;
            }
            out.edges.push([previous, last]);
        }
    }
    out
}

fn keep_vertex(out: &mut Graph, number: &mut [u32], graph: &Graph, v: u32) -> u32 {
    if number[v as usize] == u32::MAX {
        number[v as usize] = out.points.len() as u32;
        out.points.push(graph.points[v as usize]);
    }
    number[v as usize]
}

/// Paths from junction to junction (vertices where other than two edges meet), then closed paths without one.
pub(crate) fn find_chains(graph: &Graph) -> Vec<Vec<u32>> {
    let mut edges_at: Vec<Vec<(u32, usize)>> = vec![Vec::new(); graph.points.len()];
    for (e, &[a, b]) in graph.edges.iter().enumerate() {
        edges_at[a as usize].push((b, e));
        edges_at[b as usize].push((a, e));
    }
    let mut tracer = Tracer { around: &edges_at, traced: vec![false; graph.edges.len()] };
    let junctions = (0..graph.points.len()).filter(|&v| !edges_at[v].is_empty() && edges_at[v].len() != 2);
    let starts: Vec<usize> = junctions.chain((0..graph.points.len()).filter(|&v| edges_at[v].len() == 2)).collect();
    let mut chains = Vec::new();
    for start in starts {
        for &(next, edge) in &edges_at[start] {
            if !tracer.traced[edge] {
                chains.push(tracer.trace_chain(start as u32, next, edge));
            }
        }
    }
    chains
}

/// The traversal of a graph, edge by edge.
struct Tracer<'a> {
    /// Neighbour and edge, for each vertex.
    around: &'a [Vec<(u32, usize)>],
    /// Whether an edge is part of a chain.
    traced: Vec<bool>,
}

impl Tracer<'_> {
    /// The chain that leaves `start` along `edge` to `next`, up to a junction or back to its start.
    fn trace_chain(&mut self, start: u32, next: u32, edge: usize) -> Vec<u32> {
        let mut chain = vec![start, next];
        self.traced[edge] = true;
        let mut vertex = next;
        while vertex != start && self.around[vertex as usize].len() == 2 {
            let Some(&(next, edge)) = self.around[vertex as usize].iter().find(|(_, e)| !self.traced[*e]) else {
                break;
            };
            self.traced[edge] = true;
            chain.push(next);
            vertex = next;
        }
        chain
    }
}

/// Indices of the points that are kept when deviations below `noise` are removed [douglas1973].
pub(crate) fn simplify_path(points: &[Point2], noise: Metre) -> Vec<usize> {
    let last = points.len() - 1;
    // a closed path has no base line from its first to its last point: it is split at the farthest point
    let far = (0..=last)
        .fold(0, |best, i| if distance(points[i], points[0]) > distance(points[best], points[0]) { i } else { best });
    let mut indices = vec![0, last];
    let mut open = if points[0] == points[last] && far > 0 { vec![(0, far), (far, last)] } else { vec![(0, last)] };
    indices.extend(open.iter().map(|s| s.0));
    while let Some((from, to)) = open.pop() {
        let deviation = |i: &usize| nearest_on_segment(points[*i], [points[from], points[to]]).1;
        let farthest = (from + 1..to).max_by(|a, b| deviation(a).total_cmp(&deviation(b)).then(b.cmp(a)));
        if let Some(i) = farthest.filter(|i| deviation(i) > noise) {
            indices.push(i);
            open.extend([(from, i), (i, to)]);
        }
    }
    indices.sort_unstable();
    indices.dedup();
    indices
}

/// The simplified points at which the path ends or has a corner.
pub(crate) fn path_corners(points: &[Point2], indices: &[usize]) -> Vec<usize> {
    let turn = |a: usize, b: usize, c: usize| {
        let (u, v) = (unit_direction(points[a], points[b]), unit_direction(points[b], points[c]));
        (u[0] * v[0] + u[1] * v[1]).clamp(-1.0, 1.0).acos().to_degrees()
    };
    let sharp = |w: &[usize]| (turn(w[0], w[1], w[2]) > CORNER).then_some(w[1]);
    let inner = indices.windows(3).filter_map(sharp);
    let ends = [indices[0], indices[indices.len() - 1]];
    let mut corners: Vec<usize> = ends.into_iter().chain(inner).collect();
    corners.sort_unstable();
    corners
}

fn unit_direction(a: Point2, b: Point2) -> Point2 {
    let length = distance(a, b).max(f64::MIN_POSITIVE);
    [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
}

/// Inner points of a path, evenly spaced along it, as few as length and chord allow.
fn divide_path(path: &[Point2], spacing: &Spacing, closed: bool) -> Vec<Point2> {
    let arc_lengths: Vec<Metre> = std::iter::once(0.0)
        .chain(path.windows(2).scan(0.0, |sum, w| {
            *sum += distance(w[0], w[1]);
            Some(*sum)
        }))
        .collect();
    let length = arc_lengths[arc_lengths.len() - 1];
    let min_pieces = if closed { 3 } else { 1 };
    // chords cut convex outlines and lose volume: the number of pieces increases until the chord limit is met
    let mut pieces = ((length / spacing.edge).round() as usize).max(min_pieces);
    loop {
        let places: Vec<Metre> = (0..=pieces).map(|i| length * i as f64 / pieces as f64).collect();
        let points: Vec<Point2> = places.iter().map(|&s| point_at_length(path, &arc_lengths, s)).collect();
        // Bounded: at a kink between two even places the deviation falls only with the length of the pieces.
        if pieces >= 4 * path.len() || chord_deviation(path, &arc_lengths, &places, &points) <= spacing.chord {
            return points[1..pieces].to_vec();
        }
        pieces += 1;
    }
}

fn point_at_length(path: &[Point2], arc_lengths: &[Metre], s: Metre) -> Point2 {
    let i = arc_lengths.partition_point(|&a| a <= s).clamp(1, path.len() - 1);
    let t = (s - arc_lengths[i - 1]) / (arc_lengths[i] - arc_lengths[i - 1]).max(f64::MIN_POSITIVE);
    [0, 1].map(|k| path[i - 1][k] + t * (path[i][k] - path[i - 1][k]))
}

/// Farthest that a point of the path lies from the edge that replaces it.
fn chord_deviation(path: &[Point2], arc_lengths: &[Metre], places: &[Metre], points: &[Point2]) -> Metre {
    let deviation_at = |(i, &s): (usize, &Metre)| {
        let k = places.partition_point(|&p| p <= s).clamp(1, places.len() - 1);
        nearest_on_segment(path[i], [points[k - 1], points[k]]).1
    };
    arc_lengths.iter().enumerate().map(deviation_at).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::arrange::arrange_segments;

    const SPACING: Spacing = Spacing { edge: 1.0, chord: 0.05, noise: 1e-3 };

    #[test]
    fn a_finely_divided_rectangle_keeps_its_corners() {
        let at = |i: usize| match i % 100 {
            i if i < 30 => [i as f64 * 0.1, 0.0],
            i if i < 50 => [3.0, (i - 30) as f64 * 0.1],
            i if i < 80 => [3.0 - (i - 50) as f64 * 0.1, 2.0],
            i => [0.0, 2.0 - (i - 80) as f64 * 0.1],
        };
        let segments: Vec<_> = (0..100).map(|i| [at(i + 7), at(i + 8)]).collect();
        let graph = resample_graph(&arrange_segments(&segments, 1e-6), &SPACING);
        // the arbitrary start stays too
        assert!(graph.points.len() <= 12 && graph.points.len() == graph.edges.len(), "{}", graph.points.len());
        for corner in [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]] {
            assert!(graph.points.iter().any(|p| distance(*p, corner) < 1e-9));
        }
    }

    #[test]
    fn a_circle_is_divided_until_its_chords_meet_the_limit() {
        let at = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 400.0;
            [angle.cos(), angle.sin()]
        };
        let segments: Vec<_> = (0..400).map(|i| [at(i), at((i + 1) % 400)]).collect();
        let graph = resample_graph(&arrange_segments(&segments, 1e-6), &SPACING);
        assert!((8..=16).contains(&graph.points.len()), "{}", graph.points.len());
        assert!(graph.points.iter().all(|p| (p[0].hypot(p[1]) - 1.0).abs() < 1e-3));
    }
}
