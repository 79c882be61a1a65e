//! Target lengths: the edge asked for, shorter where walls are thin, graded.

use super::Remesh;
use crate::envelope::Envelope;
use crate::geometry::least_height;

/// The distance from the input is at most this share of a wall, and of a gap: surfaces of one wall may both move, and must not meet.
const SHARE: f64 = 0.12;
/// But at least this share of the largest one: beside the edge of a wedge all walls are thin, and slivers there could not go.
const FLOOR: f64 = 0.5;

/// Surfaces nearer to each other than this share of the distance allowed are one, with no wall between them.
const COINCIDENT: f64 = 0.4;

/// Target length over the height of the triangles of a strip.
const STRIP: f64 = 4.0;
/// Strips narrower than this share of an edge are not followed further.
const NARROW: f64 = 0.2;

/// On which side of a surface solids are, whose walls set lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Solid {
    /// Of a body.
    Below,
    /// Of a cavity.
    Above,
    /// Of an insert.
    Both,
}

/// What sets the lengths.
#[derive(Debug, Clone)]
pub(crate) struct Sizing<'a> {
    /// Target length away from thin walls.
    pub(crate) edge: f64,
    /// Shortest target length.
    pub(crate) least: f64,
    /// Target length over the thickness of a wall.
    pub(crate) aspect: f64,
    /// Growth of the target length per length.
    pub(crate) gradation: f64,
    /// Largest distance from the input.
    pub(crate) slack: f64,
    pub(crate) solid: Solid,
    /// All surfaces: walls lie between those of different parts, too.
    pub(crate) walls: &'a Envelope,
}

impl Remesh<'_> {
    /// Sets target lengths and slacks anew.
    pub(super) fn grade_sizes(&mut self, sizing: &Sizing, round: usize) {
        for node in 0..self.points.len() {
            if !self.around[node].is_empty() {
                let [inside, outside] = self.node_widths(node as u32, sizing);
                // strips that the envelope keeps narrow get triangles of their width; slivers across plane faces are gone by then
                let narrow = if round >= 2 {
                    (STRIP * self.mean_height(node as u32)).max(NARROW * sizing.edge)
                } else {
                    f64::INFINITY
                };
                let wall = match sizing.solid {
                    Solid::Below => inside,
                    Solid::Above => outside,
                    Solid::Both => inside.min(outside),
                };
                self.size[node] = (sizing.aspect * wall).min(narrow).clamp(sizing.least, sizing.edge);
                let narrow = (SHARE * inside.min(outside)).max(FLOOR * sizing.slack);
                self.slack[node] = sizing.slack.min(narrow);
            }
        }
        // sizes grow along edges; a few sweeps over sorted edges spread them far enough, as each sweep goes both ways
        let edges = self.all_edges();
        for _ in 0..4 {
            for [a, b] in edges.iter().copied().chain(edges.iter().rev().copied()) {
                let grown = sizing.gradation * self.edge_length([a, b]);
                let [p, q] = [a, b].map(|n| self.size[n as usize]);
                self.size[a as usize] = p.min(q + grown);
                self.size[b as usize] = q.min(p + grown);
            }
        }
    }

    /// The mean least height of the faces around a node.
    fn mean_height(&self, node: u32) -> f64 {
        let star = &self.around[node as usize];
        star.iter().map(|face| least_height(self.face_corners(*face))).sum::<f64>() / star.len() as f64
    }

    /// Thickness of the wall below a node, and of the gap above it.
    fn node_widths(&self, node: u32, sizing: &Sizing) -> [f64; 2] {
        let position = self.points[node as usize];
        let mut widths = [f64::INFINITY; 2];
        for face in &self.around[node as usize] {
            let reach = [COINCIDENT * sizing.slack, sizing.edge];
            let measured = sizing.walls.wall_and_gap(self.face_corners(*face), position, reach);
            widths = [0, 1].map(|k| f64::min(widths[k], measured[k]));
        }
        widths
    }
}
