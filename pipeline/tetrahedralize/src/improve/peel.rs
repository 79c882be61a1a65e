//! Peeling: flat elements on the outer surface are taken away where the surface stays in its envelope and keeps its topology.
//!
//! Four nodes of a plane part of the surface can make an element that no swap improves: two of its faces lie on the surface, and the edge between
//! them has no other element.

use super::{Improve, POOR};
use crate::complex::OUTSIDE;
use crate::delaunay::SIDES;
use crate::geometry::distortion;

impl Improve<'_> {
    /// Takes poor elements with two or three faces on the outer surface away, the worst first.
    pub(super) fn peel_poor(&mut self) {
        for tet in self.poor_tets(2.0 * POOR) {
            if self.complex.exists(tet) && distortion(self.complex.corners_of(tet)) > 2.0 * POOR && self.may_peel(tet) {
                self.complex.remove_tet(tet);
            }
        }
    }

    fn may_peel(&self, tet: u32) -> bool {
        let nodes = self.complex.tets[tet as usize];
        let sides = SIDES.map(|side| side.map(|i| nodes[i]));
        let open = sides.map(|side| self.complex.label_behind(tet, side) == OUTSIDE);
        let outer: Vec<[u32; 3]> =
            sides.into_iter().zip(open).filter(|(_, open)| *open).map(|(side, _)| side).collect();
        let inner: Vec<[u32; 3]> =
            sides.into_iter().zip(open).filter(|(_, open)| !open).map(|(side, _)| side).collect();
        let alone = |n: &u32| self.complex.star(*n).len() == 1;
        let keeps_topology = match (outer.as_slice(), inner.as_slice()) {
            // the edge between the inner faces comes to the surface, and must not lie there yet
            ([_, _], [f, g]) => {
                let edge: Vec<u32> = f.iter().copied().filter(|n| g.contains(n)).collect();
                edge.len() == 2 && self.skin_at([edge[0], edge[1]]).is_empty()
            }
            ([_, _, _], [f]) => nodes.iter().any(|n| !f.contains(n) && alone(n)),
            _ => false,
        };
        let label = self.complex.labels[tet as usize];
        let one_label = inner.iter().all(|side| self.complex.label_behind(tet, *side) == label);
        // without volume the inner faces cover what the outer ones do
        let is_flat = distortion(self.complex.corners_of(tet)).is_infinite();
        keeps_topology
            && one_label
            && (is_flat
                || inner
                    .iter()
                    .all(|side| self.is_near_surface(self.complex.positions_of(*side), self.least_slack(side))))
    }
}
