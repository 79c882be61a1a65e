//! Collapses of edges that are too short.

use si::Point3;
use si::vec3::dot;

use super::{FLAT, Kind, LONG, Remesh, SHORT};
use crate::geometry::{centroid, flatness, least_height, normal, unit};

/// New triangles are not flatter than this, unless the flattest old one was.
const LEAST_FLATNESS: f64 = 0.12;
/// Normals turn by less than 45° in one collapse.
const TURN: f64 = 0.7;

impl Remesh<'_> {
    /// Collapses short edges, the shortest first, and those of flat triangles.
    pub(super) fn collapse_edges(&mut self) -> usize {
        let mut count = 0;
        let mut short: Vec<(f64, [u32; 2])> = self.all_edges().into_iter().map(|e| (self.length_ratio(e), e)).collect();
        short.retain(|(ratio, _)| *ratio < SHORT);
        short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, [a, b]) in short {
            if self.edge_faces([a, b]).is_empty() || self.length_ratio([a, b]) >= SHORT {
                continue;
            }
            count += usize::from(self.collapse_edge(a, b) || self.collapse_edge(b, a));
        }
        count
    }

    /// Moves a node onto another where the surface allows it.
    fn collapse_edge(&mut self, gone: u32, kept: u32) -> bool {
        let reach = self.least_slack(&[gone, kept]);
        // steps and strips of less than the envelope are not to be kept, whatever edges they have
        let allowed = self.edge_length([gone, kept]) < reach
            || match self.node_kind(gone) {
                Kind::Smooth => true,
                Kind::Crease(ends) => ends.contains(&kept),
                Kind::Corner => false,
            };
        if !allowed || !self.link_holds(gone, kept) {
            return false;
        }
        let star = self.around[gone as usize].clone();
        let collapsed = |f: &u32| self.faces[*f as usize].map(|n| if n == gone { kept } else { n });
        let survivors: Vec<u32> = star.iter().copied().filter(|f| !self.faces[*f as usize].contains(&kept)).collect();
        let new: Vec<[u32; 3]> = survivors.iter().map(collapsed).collect();
        let shaped = survivors.iter().zip(&new).all(|(f, nodes)| self.keeps_shape((*f, *nodes), reach));
        let long = new
            .iter()
            .flatten()
            .any(|n| *n != kept && self.length_ratio([*n, kept]) > LONG.max(1.1 * self.length_ratio([*n, gone])));
        if new.is_empty() || !shaped || long || self.worsens_flatness(&star, &new) {
            return false;
        }
        let in_envelope = new.iter().all(|nodes| self.envelope.holds_triangle(self.positions_of(*nodes), reach));
        in_envelope && self.replace_faces(&star, &new, reach)
    }

    /// Nodes joined to both ends of an edge are those of its faces: otherwise the collapse would pinch the surface.
    fn link_holds(&self, gone: u32, kept: u32) -> bool {
        let wings = self.edge_faces([gone, kept]).len();
        let neighbours = self.neighbours_of(kept);
        let shared = self.neighbours_of(gone).into_iter().filter(|n| neighbours.binary_search(n).is_ok()).count();
        // the last four faces of a shell stay
        shared == wings && self.around[gone as usize].len() > 3.min(wings + 1)
    }

    fn keeps_shape(&self, (face, nodes): (u32, [u32; 3]), reach: f64) -> bool {
        let (old, new) = (self.face_corners(face), self.positions_of(nodes));
        if flatness(new) <= FLAT {
            return false;
        }
        if flatness(old) >= 10.0 * FLAT && least_height(old) >= reach {
            return is_aligned(old, new);
        }
        // the normal of a sliver is rounding, or that of a step within the envelope; the input's is not
        let foot = self.envelope.nearest(centroid(new), f64::INFINITY);
        foot.is_some_and(|foot| dot(unit(normal(new)), self.envelope.normal(foot.triangle)) > TURN)
    }

    fn worsens_flatness(&self, old: &[u32], new: &[[u32; 3]]) -> bool {
        let former_flatness = old.iter().map(|f| flatness(self.face_corners(*f))).fold(f64::INFINITY, f64::min);
        let new_flatness = new.iter().map(|n| flatness(self.positions_of(*n))).fold(f64::INFINITY, f64::min);
        new_flatness < former_flatness.min(LEAST_FLATNESS)
    }
}

pub(super) fn is_aligned(old: [Point3; 3], new: [Point3; 3]) -> bool {
    dot(unit(normal(old)), unit(normal(new))) > TURN
}
