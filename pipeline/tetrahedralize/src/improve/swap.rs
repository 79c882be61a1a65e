//! Swaps: an edge goes for the best triangulation of the ring around it, a face goes for an edge [freitag1997].

use super::Improve;
use crate::delaunay::SIDES;
use crate::geometry::distortion;
use crate::insertion::EDGES;

/// Rings of more nodes are rarely improved [freitag1997].
const MAX_RING: usize = 8;
/// What a swap must gain.
const GAIN: f64 = 0.98;

/// Tetrahedra of one label around an edge, by the nodes around it in order; closed when they go all round.
struct Chain {
    nodes: Vec<u32>,
    closed: bool,
    label: u16,
}

impl Improve<'_> {
    /// Swaps edges and faces of elements above a distortion.
    pub(super) fn swap_poor(&mut self, limit: f64) {
        for tet in self.poor_tets(limit) {
            if !self.complex.exists(tet) || distortion(self.complex.corners_of(tet)) < limit {
                continue;
            }
            let nodes = self.complex.tets[tet as usize];
            let gone = EDGES.iter().any(|[i, j]| self.remove_edge([nodes[*i], nodes[*j]]));
            if !gone {
                SIDES.iter().any(|side| self.remove_face(tet, side.map(|i| nodes[i])));
            }
        }
    }

    /// Replaces the tetrahedra around an edge by others without it, when the worst gets better.
    pub(super) fn remove_edge(&mut self, [a, b]: [u32; 2]) -> bool {
        let ring = self.complex.edge_ring([a, b]);
        let Some(chains) = self.ring_chains([a, b], &ring) else { return false };
        let worst_distortion = self.worst_of(&ring);
        let mut new = Vec::new();
        for chain in &chains {
            let Some(tets) = self.best_triangulation([a, b], chain, GAIN * worst_distortion) else { return false };
            new.extend(tets);
        }
        if chains.iter().any(|c| !c.closed) && !self.skin_swaps([a, b], &chains) {
            return false;
        }
        self.complex.replace_tets(&ring, &new);
        true
    }

    /// The ring around an edge: one closed chain, or one or two open ones between two faces of unlike labels.
    fn ring_chains(&self, [a, b]: [u32; 2], ring: &[u32]) -> Option<Vec<Chain>> {
        if ring.len() > MAX_RING {
            return None;
        }
        let mut steps: Vec<(u32, u32, u16)> = ring.iter().map(|t| self.ring_step([a, b], *t)).collect();
        steps.sort_unstable();
        let step_from = |node: u32| steps.iter().find(|s| s.0 == node).copied();
        let step_to = |node: u32| steps.iter().find(|s| s.1 == node).copied();
        let starts = steps.iter().filter(|s| step_to(s.0).is_none_or(|p| p.2 != s.2));
        let mut chains: Vec<Chain> = Vec::new();
        for &(first, _, label) in starts {
            let mut nodes = vec![first];
            while let Some((_, next, _)) =
                step_from(*nodes.last()?).filter(|s| s.2 == label && nodes.len() <= ring.len())
            {
                nodes.push(next);
            }
            chains.push(Chain { nodes, closed: false, label });
        }
        if chains.is_empty() {
            let mut nodes = vec![steps[0].0];
            let ends = |s: &(u32, u32, u16), count: usize| s.1 == steps[0].0 || count > ring.len();
            while let Some((_, next, _)) = step_from(*nodes.last()?).filter(|s| !ends(s, nodes.len())) {
                nodes.push(next);
            }
            let label = steps[0].2;
            return (nodes.len() == ring.len()).then(|| vec![Chain { nodes, closed: true, label }]);
        }
        let covered = chains.iter().map(|c| c.nodes.len() - 1).sum::<usize>() == ring.len();
        let ends = |c: &Chain| [c.nodes[0], c.nodes[c.nodes.len() - 1]];
        let simple = match chains.as_slice() {
            [_] => true,
            [c, d] => ends(c)[0] == ends(d)[1] && ends(c)[1] == ends(d)[0],
            _ => false,
        };
        (covered && simple && ends(&chains[0])[0] != ends(&chains[0])[1]).then_some(chains)
    }

    /// The other two nodes of a tetrahedron at an edge, in the order in which it goes round the edge.
    fn ring_step(&self, [a, b]: [u32; 2], tet: u32) -> (u32, u32, u16) {
        let nodes = self.complex.tets[tet as usize];
        let corner = |n: u32| nodes.iter().position(|m| *m == n).unwrap_or(0);
        let (i, j) = (corner(a), corner(b));
        let opposite_corners: Vec<usize> = (0..4).filter(|k| *k != i && *k != j).collect();
        let order = [i, j, opposite_corners[0], opposite_corners[1]];
        let inversions =
            (0..4).flat_map(|p| (0..p).map(move |q| (q, p))).filter(|(q, p)| order[*q] > order[*p]).count();
        let label = self.complex.labels[tet as usize];
        let [p, q] = [nodes[opposite_corners[0]], nodes[opposite_corners[1]]];
        if inversions % 2 == 0 { (p, q, label) } else { (q, p, label) }
    }

    /// The triangulation of a chain's polygon whose worst pair of tetrahedra is best, if all are better than `limit` [klincsek1980].
    fn best_triangulation(&self, [a, b]: [u32; 2], chain: &Chain, limit: f64) -> Option<Vec<([u32; 4], u16)>> {
        let nodes = &chain.nodes;
        let count = nodes.len();
        let pair =
            |i: usize, k: usize, j: usize| [[nodes[i], nodes[k], nodes[j], b], [nodes[i], nodes[j], nodes[k], a]];
        let mut best = vec![vec![(0.0f64, 0usize); count]; count];
        for span in 2..count {
            for i in 0..count - span {
                let j = i + span;
                let cost = |k: usize| pair(i, k, j).map(|t| self.distortion_of(t)).into_iter().fold(0.0, f64::max);
                let options = (i + 1..j).map(|k| (cost(k).max(best[i][k].0).max(best[k][j].0), k));
                best[i][j] = options.min_by(|x, y| x.0.total_cmp(&y.0))?;
            }
        }
        if count > 2 && best[0][count - 1].0 >= limit {
            return None;
        }
        let mut tets = Vec::new();
        let mut stack = vec![(0, count - 1)];
        while let Some((i, j)) = stack.pop().filter(|_| count > 2) {
            if j - i >= 2 {
                let k = best[i][j].1;
                tets.extend(pair(i, k, j).map(|t| (t, chain.label)));
                stack.extend([(i, k), (k, j)]);
            }
        }
        Some(tets)
    }

    /// Whether the faces between unlike labels may flip with the edge.
    fn skin_swaps(&self, [a, b]: [u32; 2], chains: &[Chain]) -> bool {
        let nodes = &chains[0].nodes;
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        let faces = self.skin_at([a, b]);
        if faces.len() != 2 || self.is_feature(&faces, [a, b]) || !self.skin_at([first, last]).is_empty() {
            return false;
        }
        if chains.iter().all(|c| c.nodes.len() == 2) {
            return false;
        }
        let old = [[b, a, first], [a, b, last]].map(|f| self.complex.positions_of(f));
        let new = [[a, first, last], [b, last, first]].map(|f| self.complex.positions_of(f));
        let reach = self.least_slack(&[a, b, first, last]);
        new.iter().all(|n| old.iter().all(|o| self.may_become(*o, *n, reach)))
    }

    /// Replaces two tetrahedra by three around the edge between their tips, when the worst gets better.
    fn remove_face(&mut self, tet: u32, face: [u32; 3]) -> bool {
        let [x, y, z] = face;
        let Some(other) = self.complex.star(x).iter().copied().find(|t| {
            let nodes = &self.complex.tets[*t as usize];
            *t != tet && nodes.contains(&y) && nodes.contains(&z)
        }) else {
            return false;
        };
        let label = self.complex.labels[tet as usize];
        let tip = |t: u32| self.complex.tets[t as usize].into_iter().find(|n| !face.contains(n));
        let (Some(p), Some(q)) = (tip(tet), tip(other)) else { return false };
        if label != self.complex.labels[other as usize] || !self.complex.edge_ring([p, q]).is_empty() {
            return false;
        }
        // the face's normal points away from p, towards q
        let new = [[x, y], [y, z], [z, x]].map(|[s, e]| ([p, q, s, e], label));
        let worst_distortion = self.worst_of(&[tet, other]);
        let better = new.iter().all(|(nodes, _)| self.distortion_of(*nodes) < GAIN * worst_distortion);
        if better {
            self.complex.replace_tets(&[tet, other], &new);
        }
        better
    }
}
