//! Collapses: of short edges for the target length, of any edge of a poor element for quality.

use std::collections::BTreeSet;

use super::{Improve, POOR};
use crate::complex::LabelledFace;
use crate::delaunay::sorted_edge;
use crate::geometry::{distortion, orientation};
use crate::insertion::EDGES;
use crate::remesh::{Kind, LONG, SHORT};

impl Improve<'_> {
    /// Collapses short edges, the shortest first.
    pub(super) fn collapse_short(&mut self) {
        let mut short: Vec<(f64, [u32; 2])> = self.all_edges().into_iter().map(|e| (self.length_ratio(e), e)).collect();
        short.retain(|(ratio, _)| *ratio < SHORT);
        short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, [a, b]) in short {
            if self.length_ratio([a, b]) < SHORT
                && !self.complex.edge_ring([a, b]).is_empty()
                && !self.collapse_edge([a, b], POOR)
            {
                self.collapse_edge([b, a], POOR);
            }
        }
    }

    /// Collapses edges of poor elements where that makes the worst around them better.
    pub(super) fn collapse_poor(&mut self) {
        for tet in self.poor_tets(POOR) {
            if !self.complex.exists(tet) || distortion(self.complex.corners_of(tet)) < POOR {
                continue;
            }
            let nodes = self.complex.tets[tet as usize];
            let mut edges: Vec<[u32; 2]> = EDGES.map(|[i, j]| [nodes[i], nodes[j]]).to_vec();
            edges.sort_by(|a, b| self.edge_length(*a).total_cmp(&self.edge_length(*b)));
            edges.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]).any(|edge| self.collapse_edge(edge, 0.0));
        }
    }

    /// Elements of a distortion above a limit, the worst first.
    pub(super) fn poor_tets(&self, limit: f64) -> Vec<u32> {
        let measured = self.complex.living_tets().map(|t| (distortion(self.complex.corners_of(t)), t));
        let mut poor: Vec<_> = measured.filter(|(measure, _)| *measure > limit).collect();
        poor.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        poor.into_iter().map(|(_, t)| t).collect()
    }

    /// Moves the first node of an edge onto the second; elements may get as poor as `limit`, or as the worst before.
    pub(super) fn collapse_edge(&mut self, [gone, kept]: [u32; 2], limit: f64) -> bool {
        let ring = self.complex.edge_ring([gone, kept]);
        if ring.is_empty() {
            return false;
        }
        let star = self.complex.star(gone).to_vec();
        let survivors = star.iter().filter(|t| !ring.contains(t));
        let with_kept_node = |t: &u32| self.complex.tets[*t as usize].map(|n| if n == gone { kept } else { n });
        let new: Vec<([u32; 4], u16)> =
            survivors.map(|t| (with_kept_node(t), self.complex.labels[*t as usize])).collect();
        if !self.is_better(&star, &new, limit) {
            return false;
        }
        let neighbours = self.neighbours_of(gone);
        let long = neighbours
            .iter()
            .any(|n| *n != kept && self.length_ratio([*n, kept]) > LONG.max(self.length_ratio([*n, gone])));
        if new.is_empty() || (limit > 0.0 && long) {
            return false;
        }
        if !self.link_holds([gone, kept], &ring) || !self.skin_follows(gone, kept) {
            return false;
        }
        self.complex.replace_tets(&star, &new);
        self.size[kept as usize] = self.size[kept as usize].min(self.size[gone as usize]);
        true
    }

    /// Whether new elements are no poorer than `limit` or the worst of the old ones.
    ///
    /// Of flat elements, whose distortion is infinite, there are to be fewer, and each of exactly positive volume.
    fn is_better(&self, star: &[u32], new: &[([u32; 4], u16)], limit: f64) -> bool {
        let old: Vec<f64> = star.iter().map(|t| distortion(self.complex.corners_of(*t))).collect();
        let worst_finite = old.iter().copied().filter(|m| m.is_finite()).fold(0.0, f64::max);
        let flat_count = old.iter().filter(|m| m.is_infinite()).count();
        let limit = limit.max(if flat_count > 0 { f64::MAX } else { 0.999 * worst_finite });
        let flat = new.iter().filter(|(nodes, _)| self.distortion_of(*nodes).is_infinite()).collect::<Vec<_>>();
        new.iter().all(|(nodes, _)| self.distortion_of(*nodes).is_infinite() || self.distortion_of(*nodes) <= limit)
            && (flat.is_empty() || flat.len() < flat_count)
            && flat.iter().all(|(nodes, _)| orientation(self.complex.positions_of(*nodes)) > 0.0)
    }

    /// Nodes and edges joined to both ends are those of the ring [dey1999]; on the skin, those of the faces at the edge.
    fn link_holds(&self, [gone, kept]: [u32; 2], ring: &[u32]) -> bool {
        let neighbours = self.neighbours_of(kept);
        let shared = self.neighbours_of(gone).into_iter().filter(|n| neighbours.binary_search(n).is_ok()).count();
        let mut link: Vec<u32> = ring.iter().flat_map(|t| self.complex.tets[*t as usize]).collect();
        link.sort_unstable();
        link.dedup();
        shared + 2 == link.len() && {
            let ring_edges = self.opposite_edges(ring, [gone, kept]);
            let link_edges = |node: u32| {
                let tets: Vec<u32> = self.complex.star(node).iter().copied().filter(|t| !ring.contains(t)).collect();
                self.opposite_edges(&tets, [node; 2])
            };
            let (gone_edges, kept_edges) = (link_edges(gone), link_edges(kept));
            let mut common = gone_edges.iter().filter(|edge| kept_edges.binary_search(edge).is_ok());
            common.all(|edge| ring_edges.binary_search(edge).is_ok())
        }
    }

    /// The edges of tetrahedra with neither of two nodes at an end, sorted.
    fn opposite_edges(&self, tets: &[u32], ends: [u32; 2]) -> Vec<[u32; 2]> {
        let edges = tets
            .iter()
            .map(|t| self.complex.tets[*t as usize])
            .flat_map(|nodes| EDGES.map(|[i, j]| sorted_edge([nodes[i], nodes[j]])));
        let mut opposite: Vec<[u32; 2]> = edges.filter(|edge| !edge.iter().any(|n| ends.contains(n))).collect();
        opposite.sort_unstable();
        opposite.dedup();
        opposite
    }

    /// Whether the faces between unlike labels allow the collapse.
    fn skin_follows(&self, gone: u32, kept: u32) -> bool {
        if !self.on_skin[gone as usize] {
            return true;
        }
        let skin = self.complex.skin_faces(gone);
        if skin.is_empty() {
            return true;
        }
        let wings = skin.iter().filter(|f| f.contains(&kept)).count();
        let reach = self.least_slack(&[gone, kept]);
        // as on the surfaces before: what is shorter than the envelope is not to be kept
        let allowed = self.edge_length([gone, kept]) < reach
            || match self.node_kind(gone, &skin) {
                Kind::Smooth => true,
                Kind::Crease(ends) => ends.contains(&kept),
                Kind::Corner => false,
            };
        if wings == 0 || !allowed {
            return false;
        }
        if !self.boundaries_follow(gone, kept) {
            return false;
        }
        skin.iter().filter(|f| !f.contains(&kept)).all(|face| {
            let new = face.map(|n| if n == gone { kept } else { n });
            self.may_become(self.complex.positions_of(*face), self.complex.positions_of(new), reach)
        })
    }

    /// Whether the boundary of each label around two nodes keeps its topology when one moves onto the other.
    // Each boundary of its own: where three labels meet, a face between two of them hides an edge that the third one has on both sides of it.
    fn boundaries_follow(&self, gone: u32, kept: u32) -> bool {
        let (gone_faces, kept_faces) = (self.complex.labelled_faces(gone), self.complex.labelled_faces(kept));
        let mut labels: Vec<u16> = gone_faces.iter().flat_map(|(_, labels)| *labels).collect();
        labels.sort_unstable();
        labels.dedup();
        let link_of = |faces: &[LabelledFace], label: u16, node: u32| -> BTreeSet<u32> {
            let boundary = faces.iter().filter(|(_, labels)| labels.contains(&label));
            boundary.flat_map(|(face, _)| *face).filter(|n| *n != node).collect()
        };
        labels.into_iter().all(|label| {
            let (gone_link, kept_link) = (link_of(&gone_faces, label, gone), link_of(&kept_faces, label, kept));
            let wings =
                gone_faces.iter().filter(|(face, labels)| labels.contains(&label) && face.contains(&kept)).count();
            kept_link.is_empty() || (wings > 0 && gone_link.intersection(&kept_link).count() == wings)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::tests::cubes;
    use crate::envelope::Envelope;
    use crate::tree::Tree;

    #[test]
    fn an_edge_across_a_strip_of_another_label_is_kept_since_the_label_around_it_would_pinch() {
        let follows = |strip: u16, edge: [u32; 2]| {
            // three rows of cubes, the middle one of another label, all of it on the skin
            let complex = cubes([5, 3], &[0.0, 1.0], |[_, j, _]| if j == 1 { strip } else { 0 });
            let count = complex.points.len();
            let (on_skin, envelope) = (complex.whole_skin().0, Envelope::new(&[], 1.0));
            let (lines, corners) = (Tree::new(&[]), Tree::new(&[]));
            let (size, slack) = (vec![1.0; count], vec![1.0; count]);
            Improve { complex, size, slack, on_skin, envelope: &envelope, lines, corners }
                .boundaries_follow(edge[0], edge[1])
        };
        // on the upper side, whose first node is 24, with rows of six
        let (across, along) = ([24 + 6 + 2, 24 + 12 + 2], [24 + 6 + 2, 24 + 6 + 3]);
        assert!(follows(0, across) && follows(1, along));
        assert!(!follows(1, across));
    }
}
