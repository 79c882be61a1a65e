//! Stack: a triangulated plan and the heights of sheets above it become tetrahedra that cannot be inverted.
//!
//! A *sheet* is a surface h = f(p, q) over a part of the plan. A *column* stands on one plan triangle: the sheets that
//! cut it, from below, and what fills the space between them. A *line* stands on one plan vertex and carries a node
//! for each sheet of the columns around it. Each column is filled as a staircase: of its three lines the one whose next
//! node is lowest in one total order takes a step, and each step is a tetrahedron. Its volume is a third of the
//! plan triangle's area times the step's height, so it is positive always; the order on an edge depends on its two
//! lines alone, so neighbours agree.
//!
//! Stands on: `tetrahedra`, `frame`. Never knows: where the plan or the sheets come from.

mod fill;
mod lines;
mod ranks;
mod skin;

pub(crate) use fill::fill;
pub(crate) use ranks::Cycle;

use crate::frame::Frame;
use si::{Metre, Point2};

/// What lies between two sheets of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fill {
    /// A solid region.
    Region(u16),
    /// A closed cavity.
    Chamber(u16),
    /// The surroundings.
    Air,
}

/// One plan triangle with what stands on it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// Plan vertices; they turn left.
    pub corners: [u32; 3],
    /// Sheets from below.
    pub sheets: Vec<u32>,
    /// What lies between them, one fewer.
    pub fills: Vec<Fill>,
}

/// Everything that is needed to fill a plan with tetrahedra.
pub(crate) struct Stack<'a> {
    pub frame: Frame,
    /// Vertices of the plan, m.
    pub plan: &'a [Point2],
    pub columns: &'a [Column],
    /// Number of sheets.
    pub sheets: usize,
    /// Height of a sheet above a plan vertex, m.
    pub height: &'a dyn Fn(u32, u32) -> Metre,
    /// Solids taller than this get nodes between their sheets, m.
    pub edge: Metre,
    /// Sheets nearer than this on a line share one node, m.
    pub merge: Metre,
    /// Only z ≥ 0 is in the plan.
    pub half: bool,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::tetrahedra::FACES;
    use crate::{Skin, TetMesh};
    use std::collections::BTreeMap;

    /// A plan of 3 × 3 unit squares, each two triangles, every column alike.
    pub(crate) fn square_plan(sheets: Vec<u32>, fills: Vec<Fill>) -> (Vec<Point2>, Vec<Column>) {
        let plan = (0..16).map(|i| [f64::from(i % 4), f64::from(i / 4)]).collect();
        let squares = (0..9).map(|i| i / 3 * 4 + i % 3);
        let triangles = squares.flat_map(|a| [[a, a + 1, a + 5], [a, a + 5, a + 4]]);
        let column = |corners| Column { corners, sheets: sheets.clone(), fills: fills.clone() };
        (plan, triangles.map(column).collect())
    }

    pub(crate) fn slanted_block<'a>(
        plan: &'a [Point2],
        columns: &'a [Column],
        sheets: usize,
        height: &'a dyn Fn(u32, u32) -> Metre,
    ) -> Stack<'a> {
        Stack { frame: Frame { normal: 1 }, plan, columns, sheets, height, edge: 0.4, merge: 1e-9, half: false }
    }

    /// Faces of a mesh by the number of tetrahedra that have them.
    pub(crate) fn faces_by_count(mesh: &TetMesh) -> BTreeMap<[u32; 3], usize> {
        let mut count = BTreeMap::new();
        for tet in &mesh.tets {
            for face in FACES {
                let mut key = face.map(|i| tet[i]);
                key.sort_unstable();
                *count.entry(key).or_default() += 1;
            }
        }
        count
    }

    /// Asserts that faces meet two by two and that the skin is exactly the rest, outwards and closed.
    pub(crate) fn assert_conforming(mesh: &TetMesh) {
        let faces = faces_by_count(mesh);
        assert!(faces.values().all(|&n| n <= 2));
        assert_eq!(faces.values().filter(|&&n| n == 1).count(), mesh.skin.len());
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        let mut enclosed = 0.0;
        for face in &mesh.skin {
            let [a, b, c] = face.nodes;
            for (s, e) in [(a, b), (b, c), (c, a)] {
                *edges.entry([s.min(e), s.max(e)]).or_default() += if s < e { 1 } else { -1 };
            }
            let [a, b, c] = face.nodes.map(|n| mesh.nodes[n as usize]);
            enclosed += si::vec3::dot(a, si::vec3::cross(b, c)) / 6.0;
        }
        assert!(edges.values().all(|&sum| sum == 0), "the skin is open");
        let solid: f64 = (0..mesh.tets.len()).map(|t| mesh.volume(t)).sum();
        assert!((enclosed - solid).abs() < 1e-9 * solid, "the skin encloses {enclosed}, the solid has {solid}");
    }

    #[test]
    fn every_inner_face_is_shared_by_two_and_the_skin_is_closed() {
        let fills = vec![Fill::Region(0), Fill::Chamber(0), Fill::Region(1)];
        let (plan, mut columns) = square_plan(vec![0, 1, 2, 3], fills);
        // a cavity in the middle square only, under a wavy roof
        for (i, column) in columns.iter_mut().enumerate() {
            if i / 2 != 4 {
                (column.sheets, column.fills) = (vec![0, 3], vec![Fill::Region(0)]);
            }
        }
        let height = |v: u32, s: u32| f64::from(s) + if s == 3 { 0.3 * f64::from(v % 4) } else { 0.0 };
        let mesh = fill(&slanted_block(&plan, &columns, 4, &height)).unwrap();
        assert_conforming(&mesh);
        assert!((mesh.chamber_volume(0) - 1.0).abs() < 1e-12);
        assert!(mesh.skin.iter().any(|f| f.on == Skin::Chamber(0)) && mesh.chambers() == 1);
    }
}
