//! Layers: the sheets over each plan triangle, and their heights.

use super::plan::Plan;
use super::{Tail, TailError};
use mesh::frame::Frame;
use mesh::stack::{self, Column, Cycle, Fill, Stack};
use mesh::{BODY, SPINE, TetMesh};
use si::Metre;

// Sheets, as numbers: the −y side has the even ones, the +y side the odd ones.
const OUTER: u32 = 0;
const FACE: u32 = 2;
const INNER: u32 = 4;
const CHANNEL: u32 = 6;
const CEILING: u32 = 8;

/// Fills the plan with tetrahedra; solids taller than `edge` (m) are divided.
pub(crate) fn fill(tail: &Tail, plan: &Plan, edge: Metre, half: bool) -> Result<TetMesh, TailError> {
    let columns: Vec<Column> = plan.triangles.iter().filter_map(|&t| column(tail, plan, t)).collect();
    let heights: Vec<SheetHeights> = plan.points.iter().map(|p| SheetHeights::new(tail, p[1], p[0])).collect();
    let height = |vertex: u32, sheet: u32| heights[vertex as usize].height(sheet);
    let stack = Stack {
        frame: Frame { normal: 1 },
        plan: &plan.points,
        columns: &columns,
        sheets: 8 + 2 * tail.chambers,
        height: &height,
        edge,
        merge: 1e-6,
        half,
    };
    stack::fill(&stack).map_err(|Cycle { lower, upper }| TailError::CrossingLayers { lower, upper })
}

/// Heights of the sheets of the +y side above one plan vertex, m.
struct SheetHeights {
    outer: Metre,
    face: [Metre; 2],
    inner: Metre,
    channel: Metre,
    ceiling: [Metre; 2],
}

impl SheetHeights {
    fn new(tail: &Tail, x: Metre, z: Metre) -> Self {
        let (outer, inner) = (tail.half_width(x, z), tail.inner_face());
        let ceiling = tail.wall.map(|wall| outer - wall);
        let face = [-1.0, 1.0].map(|side| tail.sheet / 2.0 + side * tail.sheet_offset);
        Self { outer, face, inner, channel: inner + tail.channel_depth, ceiling }
    }

    fn height(&self, sheet: u32) -> Metre {
        let side = sheet % 2;
        let height = match sheet - side {
            OUTER => self.outer,
            FACE => self.face[side as usize],
            INNER => self.inner,
            CHANNEL => self.channel,
            _ => self.ceiling[side as usize],
        };
        if side == 0 { -height } else { height }
    }
}

/// The column over a plan triangle; none where there is no solid.
fn column(tail: &Tail, plan: &Plan, corners: [u32; 3]) -> Option<Column> {
    let mean = |k: usize| corners.iter().map(|&v| plan.points[v as usize][k]).sum::<f64>() / 3.0;
    let (z, x) = (mean(0).abs(), mean(1));
    let half = half_stack(tail, x, z)?;
    // the half from the middle outwards is mirrored to the other side
    let lower = half.iter().rev().map(|&(sheet, fill)| (sheet, fill(0)));
    let mut sheets: Vec<u32> = lower.clone().map(|s| s.0).collect();
    let mut fills: Vec<Fill> = lower.map(|s| s.1).collect();
    fills.extend(half.iter().skip(1).map(|&(_, fill)| fill(1)));
    sheets.extend(half.iter().map(|&(sheet, _)| sheet + 1));
    Some(Column { corners, sheets, fills })
}

/// A sheet with what fills the space from the sheet before it (or the middle) to it, by side.
type Layer = (u32, fn(u16) -> Fill);

const SILICONE: fn(u16) -> Fill = |_| Fill::Region(BODY);
const ACETAL: fn(u16) -> Fill = |_| Fill::Region(SPINE);
const HOLLOW: fn(u16) -> Fill = Fill::Chamber;

/// Layers from the middle plane outwards at a place in the plan; none where there is no solid.
fn half_stack(tail: &Tail, x: Metre, z: Metre) -> Option<Vec<Layer>> {
    let inside = |[from, to]: [Metre; 2]| x > from && x < to;
    let chamber = (0..tail.chambers).find(|&i| inside(tail.chamber(i)) && z < tail.chamber_half_height(x));
    let rib = (1..tail.chambers).map(|i| i - 1).find(|&i| inside(tail.rib_at(i)));
    let slotted = rib.is_some_and(|i| z < tail.slot_half_height(i));
    let sheet = z < tail.sheet_half_height(x) && !slotted;
    let body = x < tail.body_end() && z < tail.half_height(x);
    let channel = rib.is_some() && z < tail.channel_half_height;
    let mut layers: Vec<Layer> = Vec::new();
    if sheet {
        layers.push((FACE, ACETAL));
    }
    if body {
        match chamber {
            Some(i) => layers.extend([(INNER, SILICONE), (CEILING + 2 * i as u32, HOLLOW)]),
            None if channel => layers.extend([(INNER, SILICONE), (CHANNEL, HOLLOW)]),
            None => {}
        }
        layers.push((OUTER, SILICONE));
    }
    (!layers.is_empty()).then_some(layers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Resolution;
    use mesh::quality::dihedral_range;

    #[test]
    fn the_tail_meshes_into_two_chambers_with_a_closed_skin() {
        for tail in [Tail::nine_chambers(), Tail::twelve_chambers()] {
            let mesh = tail.mesh(&Resolution::even(&tail, 4e-3)).unwrap();
            assert_eq!(mesh.nonconformity(), None);
            assert_eq!(mesh.chambers(), 2);
            let volume = mesh.chamber_volume(0);
            assert!((mesh.chamber_volume(1) - volume).abs() < 1e-12 && volume > 2e-6, "{volume}");
            assert!(dihedral_range(&mesh).0 > 1.5);
        }
    }

    #[test]
    fn the_slots_are_filled_with_silicone() {
        let tail = Tail::nine_chambers();
        let [from, to] = tail.rib_at(3);
        assert_eq!(half_stack(&tail, (from + to) / 2.0, 4e-3).unwrap().len(), 1);
        assert_eq!(half_stack(&tail, (from + to) / 2.0, 15e-3).unwrap().len(), 2);
        assert!(half_stack(&tail, 0.1, 0.0299).is_none());
    }
}
