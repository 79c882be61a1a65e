//! Splits of edges: of long ones for the target length, of the longest edge of a poor element for room to improve it.

use si::Point3;
use si::vec3::{add, scale};

use super::{Improve, POOR};
use crate::geometry::distortion;
use crate::insertion::EDGES;
use crate::remesh::LONG;

impl Improve<'_> {
    /// Splits long edges, the longest first.
    pub(super) fn split_long(&mut self) {
        let mut long: Vec<(f64, [u32; 2])> = self.all_edges().into_iter().map(|e| (self.length_ratio(e), e)).collect();
        long.retain(|(ratio, _)| *ratio > LONG);
        long.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (_, edge) in long {
            self.split_edge(edge, 2.0 * POOR);
        }
    }

    /// Splits the longest edge of each poor element.
    pub(super) fn split_poor(&mut self) {
        for tet in self.poor_tets(2.0 * POOR) {
            if !self.complex.exists(tet) || distortion(self.complex.corners_of(tet)) < POOR {
                continue;
            }
            let nodes = self.complex.tets[tet as usize];
            let edges = EDGES.map(|[i, j]| [nodes[i], nodes[j]]);
            if let Some(edge) = edges.into_iter().max_by(|a, b| self.edge_length(*a).total_cmp(&self.edge_length(*b))) {
                self.split_edge(edge, f64::INFINITY);
            }
        }
    }

    /// Splits an edge in its middle, on the surface if it lies there; elements may get as poor as `limit`, or as the worst before.
    pub(super) fn split_edge(&mut self, edge: [u32; 2], limit: f64) -> bool {
        let ring = self.complex.edge_ring(edge);
        if ring.is_empty() {
            return false;
        }
        let [p, q] = self.complex.positions_of(edge);
        let middle = scale(add(p, q), 0.5);
        let skin = self.skin_at(edge);
        let limit = limit.max(self.worst_of(&ring));
        let [a, b] = edge.map(|n| n as usize);
        let reach = self.slack[a].min(self.slack[b]);
        let foot =
            (!skin.is_empty() && !self.is_feature(&skin, edge)).then(|| self.envelope.nearest(middle, 2.0 * reach));
        let places = foot.flatten().map(|f| f.point).into_iter().chain([middle]);
        let node = self.complex.add_point(middle);
        let size = (self.size[a] + self.size[b]) / 2.0;
        self.size.push(size);
        self.slack.push(reach);
        self.on_skin.push(!skin.is_empty());
        places.into_iter().any(|at| self.split_at((edge, node), at, limit))
    }

    fn split_at(&mut self, (edge, node): ([u32; 2], u32), at: Point3, limit: f64) -> bool {
        self.complex.points[node as usize] = at;
        let (old, new) = self.complex.bisect_edge(edge, node);
        let sound = new.iter().all(|(nodes, _)| {
            let measure = self.distortion_of(*nodes);
            measure.is_finite() && measure <= limit
        });
        if sound {
            self.complex.replace_tets(&old, &new);
        }
        sound
    }
}
