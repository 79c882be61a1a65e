//! Local operations on labelled tetrahedra: split, collapse, swap, smooth.
//!
//! Each is refused when it inverts an element, lets a face between unlike labels leave the envelope, or changes how the faces of a label are joined
//! [hu2018]. The measure is the inverse mean ratio, whose derivative is closed, not the dihedral angle, which has none where it matters.

mod balance;
mod collapse;
mod peel;
mod smooth;
mod split;
mod swap;

use si::Point3;
use si::vec3::dot;

use crate::complex::{Complex, OUTSIDE};
use crate::delaunay::sorted_edge;
use crate::envelope::Envelope;
use crate::geometry::{centroid, distance, distortion, flatness, normal, unit};
use crate::insertion::EDGES;
use crate::remesh::{Kind, SHARP};
use crate::topology::unfold_flat;
use crate::tree::Tree;

/// Elements of a larger distortion are worked on: 10 is a dihedral angle of some 5°.
pub(crate) const POOR: f64 = 8.0;
/// The normal of a triangle flatter than this says nothing.
const FLAT: f64 = 1e-3;

/// Tetrahedra on their way to good ones.
pub(crate) struct Improve<'a> {
    pub(crate) complex: Complex,
    /// Target length by node, and distance from the input.
    pub(crate) size: Vec<f64>,
    pub(crate) slack: Vec<f64>,
    /// Whether a node lies between unlike labels.
    pub(crate) on_skin: Vec<bool>,
    pub(crate) envelope: &'a Envelope,
    /// Sharp edges of the surfaces, and their corners, as degenerate triangles.
    pub(crate) lines: Tree,
    pub(crate) corners: Tree,
}

impl Improve<'_> {
    /// Rounds of operations until the worst elements no longer get better.
    pub(crate) fn run_rounds(&mut self, rounds: usize, watch: &dyn Fn(&str)) {
        for round in 0..rounds {
            if round > 0 {
                self.split_long();
            }
            self.collapse_short();
            self.swap_poor(3.0);
            self.smooth_all(1.8);
            self.swap_poor(2.0);
            self.smooth_all(1.8);
            watch(&format!("round {} of {rounds}: {} tetrahedra", round + 1, self.complex.living_tets().count()));
        }
        for _ in 0..2 * rounds {
            if self.worst_distortion() < POOR {
                break;
            }
            // splits of a flat element beside an interface leave parts of it on one side
            unfold_flat(&mut self.complex, |label| label != OUTSIDE);
            self.on_skin = self.complex.whole_skin().0;
            self.collapse_poor();
            self.split_poor();
            self.swap_poor(4.0);
            self.smooth_all(4.0);
            self.collapse_short();
            self.swap_poor(4.0);
            self.smooth_all(4.0);
            self.peel_poor();
        }
        self.balance_surface();
        self.balance_surface();
    }

    fn worst_distortion(&self) -> f64 {
        self.complex.living_tets().map(|t| distortion(self.complex.corners_of(t))).fold(0.0, f64::max)
    }

    pub(crate) fn distortion_of(&self, nodes: [u32; 4]) -> f64 {
        distortion(self.complex.positions_of(nodes))
    }

    /// The largest distortion of some tetrahedra.
    fn worst_of(&self, tets: &[u32]) -> f64 {
        tets.iter().map(|t| distortion(self.complex.corners_of(*t))).fold(0.0, f64::max)
    }

    fn edge_length(&self, [a, b]: [u32; 2]) -> f64 {
        distance(self.complex.points[a as usize], self.complex.points[b as usize])
    }

    fn length_ratio(&self, [a, b]: [u32; 2]) -> f64 {
        self.edge_length([a, b]) / self.size[a as usize].min(self.size[b as usize])
    }

    fn least_slack(&self, nodes: &[u32]) -> f64 {
        nodes.iter().map(|n| self.slack[*n as usize]).fold(f64::INFINITY, f64::min)
    }

    fn all_edges(&self) -> Vec<[u32; 2]> {
        let tets = self.complex.living_tets().map(|t| self.complex.tets[t as usize]);
        let mut edges: Vec<_> = tets.flat_map(|t| EDGES.map(|[i, j]| sorted_edge([t[i], t[j]]))).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    fn neighbours_of(&self, node: u32) -> Vec<u32> {
        let star = self.complex.star(node);
        let mut neighbours: Vec<u32> =
            star.iter().flat_map(|t| self.complex.tets[*t as usize]).filter(|n| *n != node).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Faces between unlike labels at an edge.
    fn skin_at(&self, [a, b]: [u32; 2]) -> Vec<[u32; 3]> {
        if !(self.on_skin[a as usize] && self.on_skin[b as usize]) {
            return Vec::new();
        }
        self.complex.skin_faces(a).into_iter().filter(|f| f.contains(&b)).collect()
    }

    /// How a node of the skin may move, by the faces around it.
    fn node_kind(&self, node: u32, skin: &[[u32; 3]]) -> Kind {
        let mut neighbours: Vec<u32> = skin.iter().flatten().copied().filter(|n| *n != node).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        let at_edge = |n: u32| skin.iter().copied().filter(move |f| f.contains(&n)).collect::<Vec<_>>();
        let features: Vec<u32> = neighbours.into_iter().filter(|n| self.is_feature(&at_edge(*n), [node, *n])).collect();
        let corner =
            || self.corners.within(self.complex.points[node as usize], self.slack[node as usize], None).is_some();
        match features.as_slice() {
            [] => Kind::Smooth,
            _ if corner() => Kind::Corner,
            _ => Kind::Crease(features),
        }
    }

    /// Whether the faces at an edge make it one that keeps its line.
    ///
    /// A sharp edge away from the surfaces' own is a dent that a refused split has left, and is to vanish.
    fn is_feature(&self, faces: &[[u32; 3]], edge: [u32; 2]) -> bool {
        let &[f, g] = faces else { return true };
        let corners = [f, g].map(|n| self.complex.positions_of(n));
        if corners.iter().any(|c| flatness(*c) < FLAT) {
            return false;
        }
        let [m, n] = corners.map(|c| unit(normal(c)));
        dot(m, n) < SHARP && {
            let middle = centroid(self.complex.positions_of(edge));
            self.lines.within(middle, self.least_slack(&edge), None).is_some()
        }
    }

    /// Whether a face between unlike labels may take the place of another.
    fn may_become(&self, old: [Point3; 3], new: [Point3; 3], reach: f64) -> bool {
        if flatness(new) < 0.1 * FLAT || !self.is_near_surface(new, reach) {
            return false;
        }
        let upwards = unit(normal(new));
        let turn = dot(unit(normal(old)), upwards);
        if turn > SHARP || flatness(old) < FLAT {
            return true;
        }
        // a dent becomes flat when its faces turn to the surface's normal, of either sign between regions
        let foot = self.envelope.nearest(centroid(new), 2.0 * reach);
        turn > -0.2 && foot.is_some_and(|foot| dot(self.envelope.normal(foot.triangle), upwards).abs() > SHARP)
    }

    fn is_near_surface(&self, face: [Point3; 3], reach: f64) -> bool {
        self.envelope.holds_triangle(face, reach)
    }
}
