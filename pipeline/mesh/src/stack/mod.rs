//! Stacks: a triangulated plan and the heights of sheets over it become tetrahedra of positive volume.
//!
//! A *sheet* is a height field h = f(p, q) over a part of the plan. A *column* is the space over one plan triangle: the
//! sheets that cut it, from below, and the fills between them. A *line* is over one plan vertex and has a node for each
//! sheet of the columns around it. Each column is divided into a sequence of tetrahedra: the top triangle advances along
//! one of its three lines at a time, always to the node that is lowest in one total order, and each advance sweeps a
//! tetrahedron. Its volume is a third of the plan triangle's area times the advance, so volumes are positive by
//! construction. The order along a face between two columns depends on its two lines alone, so neighbours conform.
//!
//! A constrained Delaunay tetrahedralisation of both surfaces was the alternative. It needs matching triangulations of the
//! shared faces, which CAD exports do not have, and it gives no bound on the volumes of the elements.

mod fill;
mod lines;
mod ranks;
mod skin;

pub use fill::fill_stack;
pub use ranks::Cycle;
pub(crate) use ranks::Order;

use crate::frame::Frame;
use si::{Metre, Point2};

/// The fill between two sheets of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fill {
    /// A solid region.
    Region(u16),
    /// A closed cavity.
    Chamber(u16),
    /// The surroundings.
    Air,
}

/// The sheets and fills over one plan triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Plan vertices, counterclockwise.
    pub corners: [u32; 3],
    /// Sheets from below.
    pub sheets: Vec<u32>,
    /// The fills between them, one fewer.
    pub fills: Vec<Fill>,
}

/// The plan, the columns over it, and the heights of the sheets.
pub struct Stack<'a> {
    /// Orientation of the plan in space.
    pub frame: Frame,
    /// Vertices of the plan, m.
    pub plan: &'a [Point2],
    /// The columns over the triangles of the plan.
    pub columns: &'a [Column],
    /// Number of sheets.
    pub sheets: usize,
    /// Height of a sheet above a plan vertex, m.
    pub height: &'a dyn Fn(u32, u32) -> Metre,
    /// Solids taller than this get nodes between their sheets, m.
    pub edge: Metre,
    /// Distance below which sheets share one node on a line, m.
    pub merge: Metre,
    /// Whether the plan has only z ≥ 0.
    pub half: bool,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Skin;

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

    #[test]
    fn every_inner_face_is_shared_by_two_and_the_skin_is_closed() {
        let fills = vec![Fill::Region(0), Fill::Chamber(0), Fill::Region(1)];
        let (plan, mut columns) = square_plan(vec![0, 1, 2, 3], fills);
        // a cavity in the middle square only, under a wavy sheet
        for (i, column) in columns.iter_mut().enumerate() {
            if i / 2 != 4 {
                (column.sheets, column.fills) = (vec![0, 3], vec![Fill::Region(0)]);
            }
        }
        let height = |v: u32, s: u32| f64::from(s) + if s == 3 { 0.3 * f64::from(v % 4) } else { 0.0 };
        let mesh = fill_stack(&slanted_block(&plan, &columns, 4, &height)).unwrap();
        assert_eq!(mesh.nonconformity(), None);
        assert!((mesh.chamber_volume(0) - 1.0).abs() < 1e-12);
        assert!(mesh.skin.iter().any(|f| f.on == Skin::Chamber(0)) && mesh.chambers() == 1);
    }
}
