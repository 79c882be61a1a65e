//! Triangles of any shape to triangles near a target length, within an envelope of the input [botsch2004].
//!
//! CAD programs write slivers across plane faces and thousands of facets around fillets; tetrahedra on them would have the slivers' angles and the
//! facets' number. Edges are split, collapsed and flipped, nodes relaxed, each only where the new triangles keep to the envelope *and* the input's
//! own points keep to the new triangles: distances one way alone let a pit be bridged. Edges with other than two faces, and sharp ones, keep their line.

mod collapse;
mod flip;
mod marks;
mod relax;
mod size;

use std::collections::BTreeMap;

use si::Point3;
use si::vec3::{add, dot, scale, sub};

use crate::delaunay::sorted_edge;
use crate::envelope::Envelope;
use crate::geometry::{centroid, distance, flatness, normal, unit};
pub(crate) use size::{Sizing, Solid};

/// Faces whose normals differ by more than 40° meet in a feature.
pub(crate) const SHARP: f64 = 0.766;
/// A feature that bends by more than 55° at a node has a corner there.
pub(crate) const STRAIGHT: f64 = 0.57;
/// The normal of a triangle flatter than this says nothing.
const FLAT: f64 = 2e-4;
/// Edges longer than this many target lengths are split, shorter ones collapsed [botsch2004].
pub(crate) const LONG: f64 = 4.0 / 3.0;
pub(crate) const SHORT: f64 = 4.0 / 5.0;
const ROUNDS: usize = 6;
const GONE: u32 = u32::MAX;

/// How a node may move.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Kind {
    Smooth,
    /// Along a feature, to one of these nodes.
    Crease(Vec<u32>),
    Corner,
}

/// A surface that changes.
pub(crate) struct Remesh<'a> {
    pub(crate) points: Vec<Point3>,
    faces: Vec<[u32; 3]>,
    around: Vec<Vec<u32>>,
    /// Target length of edges, and distance from the input, by node.
    pub(crate) size: Vec<f64>,
    pub(crate) slack: Vec<f64>,
    /// The input's points that each face stands for.
    marks: Vec<Vec<u32>>,
    input: Vec<Point3>,
    envelope: &'a Envelope,
}

impl<'a> Remesh<'a> {
    pub(crate) fn new((points, faces): (Vec<Point3>, Vec<[u32; 3]>), envelope: &'a Envelope, spacing: f64) -> Self {
        let mut faces_at_node = vec![Vec::new(); points.len()];
        faces
            .iter()
            .enumerate()
            .for_each(|(f, face)| face.iter().for_each(|n| faces_at_node[*n as usize].push(f as u32)));
        let mut marks = vec![Vec::new(); faces.len()];
        for (node, star) in faces_at_node.iter().enumerate() {
            star.iter().take(1).for_each(|f| marks[*f as usize].push(node as u32));
        }
        let count = points.len();
        let input = points.clone();
        let mut surface = Self {
            points,
            faces,
            around: faces_at_node,
            size: vec![f64::INFINITY; count],
            slack: vec![0.0; count],
            marks,
            input,
            envelope,
        };
        surface.mark_edges(spacing);
        surface
    }

    /// Brings edges to their lengths.
    pub(crate) fn remesh_surface(&mut self, sizing: &Sizing) {
        self.grade_sizes(sizing, 0);
        for round in 0..ROUNDS {
            self.flip_edges();
            // strips around fillets merge pair by pair
            for _ in 0..4 {
                let count = self.collapse_edges();
                self.flip_edges();
                if 50 * count < self.points.len() {
                    break;
                }
            }
            self.split_edges();
            self.relax_nodes();
            // sizes of new nodes are interpolated, those of nodes on faces that were large at first are seen only now
            if round < 4 {
                self.grade_sizes(sizing, round + 1);
            }
        }
        self.flip_edges();
    }

    /// Points and faces that are left.
    pub(crate) fn finish_surface(&self) -> (Vec<Point3>, Vec<[u32; 3]>, Vec<f64>, Vec<f64>) {
        let mut number = vec![GONE; self.points.len()];
        let (mut points, mut size, mut slack) = (Vec::new(), Vec::new(), Vec::new());
        let faces: Vec<[u32; 3]> = self.living_faces().map(|f| self.faces[f as usize]).collect();
        for node in faces.iter().flatten() {
            let number = &mut number[*node as usize];
            if *number == GONE {
                *number = points.len() as u32;
                points.push(self.points[*node as usize]);
                slack.push(self.slack[*node as usize]);
                // where the envelope kept edges short, the solid beside them is to follow
                size.push(self.size[*node as usize].min(1.3 * self.mean_edge(*node)));
            }
        }
        (points, faces.iter().map(|f| f.map(|n| number[n as usize])).collect(), size, slack)
    }

    /// Lines and points that are kept.
    pub(crate) fn features(&self) -> (Vec<[Point3; 2]>, Vec<Point3>) {
        let position = |n: u32| self.points[n as usize];
        let lines = self
            .all_edges()
            .into_iter()
            .filter(|e| self.is_feature(*e))
            .map(|[a, b]| [position(a), position(b)])
            .collect();
        let nodes = (0..self.points.len() as u32).filter(|n| !self.around[*n as usize].is_empty());
        (lines, nodes.filter(|n| self.node_kind(*n) == Kind::Corner).map(position).collect())
    }

    fn mean_edge(&self, node: u32) -> f64 {
        let neighbours = self.neighbours_of(node);
        let sum: f64 = neighbours.iter().map(|n| self.edge_length([*n, node])).sum();
        sum / neighbours.len().max(1) as f64
    }

    fn living_faces(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.faces.len() as u32).filter(|f| self.faces[*f as usize][0] != GONE)
    }

    fn face_corners(&self, face: u32) -> [Point3; 3] {
        self.positions_of(self.faces[face as usize])
    }

    fn positions_of(&self, nodes: [u32; 3]) -> [Point3; 3] {
        nodes.map(|n| self.points[n as usize])
    }

    fn edge_length(&self, [a, b]: [u32; 2]) -> f64 {
        distance(self.points[a as usize], self.points[b as usize])
    }

    /// Length over the target of the edge's ends.
    fn length_ratio(&self, [a, b]: [u32; 2]) -> f64 {
        self.edge_length([a, b]) / self.size[a as usize].min(self.size[b as usize])
    }

    fn least_slack(&self, nodes: &[u32]) -> f64 {
        nodes.iter().map(|n| self.slack[*n as usize]).fold(f64::INFINITY, f64::min)
    }

    /// The nodes joined to one by edges, sorted.
    fn neighbours_of(&self, node: u32) -> Vec<u32> {
        let star = &self.around[node as usize];
        let mut neighbours: Vec<u32> =
            star.iter().flat_map(|f| self.faces[*f as usize]).filter(|n| *n != node).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// The faces at an edge.
    fn edge_faces(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        self.around[a as usize].iter().copied().filter(|f| self.faces[*f as usize].contains(&b)).collect()
    }

    /// Every edge once, sorted.
    fn all_edges(&self) -> Vec<[u32; 2]> {
        let pairs = |f: u32| {
            let [a, b, c] = self.faces[f as usize];
            [[a, b], [b, c], [c, a]].map(sorted_edge)
        };
        let mut edges: Vec<_> = self.living_faces().flat_map(pairs).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Whether an edge is to keep its line.
    fn is_feature(&self, edge: [u32; 2]) -> bool {
        let wings = self.edge_faces(edge);
        let &[f, g] = wings.as_slice() else { return true };
        if self.runs_forwards(f, edge) == self.runs_forwards(g, edge) {
            return true;
        }
        let corners = [self.face_corners(f), self.face_corners(g)];
        if corners.iter().any(|c| flatness(*c) < FLAT) {
            return false;
        }
        let [m, n] = corners.map(|c| unit(normal(c)));
        dot(m, n) < SHARP
    }

    fn runs_forwards(&self, face: u32, [a, b]: [u32; 2]) -> bool {
        let nodes = self.faces[face as usize];
        (0..3).any(|k| nodes[k] == a && nodes[(k + 1) % 3] == b)
    }

    fn node_kind(&self, node: u32) -> Kind {
        let features: Vec<u32> = self.neighbours_of(node).into_iter().filter(|n| self.is_feature([node, *n])).collect();
        match features.as_slice() {
            [] => Kind::Smooth,
            &[p, q] => {
                let [p_, q_, at] = self.positions_of([p, q, node]);
                let straight = dot(unit(sub(at, p_)), unit(sub(q_, at))) > STRAIGHT;
                if straight { Kind::Crease(features) } else { Kind::Corner }
            }
            _ => Kind::Corner,
        }
    }

    fn remove_face(&mut self, face: u32) -> Vec<u32> {
        for node in self.faces[face as usize] {
            self.around[node as usize].retain(|f| *f != face);
        }
        self.faces[face as usize] = [GONE; 3];
        std::mem::take(&mut self.marks[face as usize])
    }

    fn add_face(&mut self, nodes: [u32; 3], marks: Vec<u32>) {
        let face = self.faces.len() as u32;
        self.faces.push(nodes);
        self.marks.push(marks);
        nodes.iter().for_each(|n| self.around[*n as usize].push(face));
    }

    /// Replaces faces where all points stay near.
    fn replace_faces(&mut self, old: &[u32], new: &[[u32; 3]], reach: f64) -> bool {
        let places: Vec<[Point3; 3]> = new.iter().map(|n| self.positions_of(*n)).collect();
        let Some(marks) = self.assign_marks(old, &places, reach) else { return false };
        old.iter().for_each(|f| drop(self.remove_face(*f)));
        new.iter().zip(marks).for_each(|(nodes, marks)| self.add_face(*nodes, marks));
        true
    }

    /// Splits edges that are too long, the longest first.
    fn split_edges(&mut self) {
        let mut long: Vec<(f64, [u32; 2])> = self.all_edges().into_iter().map(|e| (self.length_ratio(e), e)).collect();
        long.retain(|(ratio, _)| *ratio > LONG);
        long.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut next: BTreeMap<usize, Vec<[u32; 2]>> = BTreeMap::from([(0, long.into_iter().map(|l| l.1).collect())]);
        // halves of a very long edge are still too long
        while let Some((depth, edges)) = next.pop_first() {
            for edge in edges {
                if self.length_ratio(edge) <= LONG {
                    continue;
                }
                let Some(node) = self.split_edge(edge) else { continue };
                let incident_edges = self.neighbours_of(node).into_iter().map(|n| sorted_edge([n, node]));
                next.entry(depth + 1).or_default().extend(incident_edges);
            }
        }
    }

    fn split_edge(&mut self, [a, b]: [u32; 2]) -> Option<u32> {
        let wings = self.edge_faces([a, b]);
        if wings.is_empty() {
            return None;
        }
        let [p, q] = [a, b].map(|n| self.points[n as usize]);
        let middle = scale(add(p, q), 0.5);
        let node = self.points.len() as u32;
        self.points.push(middle);
        self.around.push(Vec::new());
        self.size.push((self.size[a as usize] + self.size[b as usize]) / 2.0);
        self.slack.push(self.slack[a as usize].min(self.slack[b as usize]));
        let instead = |f: u32, old: u32| self.faces[f as usize].map(|n| if n == old { node } else { n });
        let halves: Vec<[u32; 3]> = wings.iter().flat_map(|f| [instead(*f, a), instead(*f, b)]).collect();
        self.replace_faces(&wings, &halves, f64::INFINITY).then_some(node)
    }

    fn face_centroid(&self, face: u32) -> Point3 {
        centroid(self.face_corners(face))
    }
}
