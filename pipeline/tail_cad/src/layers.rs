//! Layers: the sheets over each plan triangle, and their heights.

use super::plan::Plan;
use super::{FILM, Tail, TailError};
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

/// The outer face of the film along an unbonded stretch.
fn film_face(tail: &Tail) -> u32 {
    CEILING + 2 * tail.chambers as u32
}

/// Fills the plan with tetrahedra; solids taller than `edge` (m) are divided.
pub(crate) fn fill_plan(tail: &Tail, plan: &Plan, edge: Metre, half: bool) -> Result<TetMesh, TailError> {
    let layers = TailLayers::new(tail);
    let columns: Vec<Column> = plan.triangles.iter().filter_map(|&t| layers.column_over(plan, t)).collect();
    let heights: Vec<SheetHeights> = plan.points.iter().map(|p| SheetHeights::new(tail, p[1], p[0])).collect();
    let height = |vertex: u32, sheet: u32| heights[vertex as usize].height(sheet);
    let stack = Stack {
        frame: Frame { normal: 1 },
        plan: &plan.points,
        columns: &columns,
        sheets: layers.sheets(),
        height: &height,
        edge,
        merge: 1e-6,
        half,
    };
    stack::fill_stack(&stack).map_err(|Cycle { lower, upper }| TailError::CrossingLayers { lower, upper })
}

/// Heights of the sheets of the +y side above one plan vertex, m.
pub(crate) struct SheetHeights {
    outer: Metre,
    face: [Metre; 2],
    inner: Metre,
    channel: Metre,
    ceiling: [Metre; 2],
    film: [Metre; 2],
    film_face: u32,
}

impl SheetHeights {
    pub fn new(tail: &Tail, x: Metre, z: Metre) -> Self {
        let (outer, inner) = (tail.half_width(x, z), tail.inner_face());
        let ceiling = tail.wall.map(|wall| outer - wall);
        let face = [-1.0, 1.0].map(|side| tail.sheet / 2.0 + side * tail.sheet_offset);
        let film = face.map(|face| face + tail.unbonded.map_or(0.0, |unbonded| unbonded.film));
        Self { outer, face, inner, channel: inner + tail.channel_depth, ceiling, film, film_face: film_face(tail) }
    }

    pub fn height(&self, sheet: u32) -> Metre {
        let side = sheet % 2;
        let height = match sheet - side {
            OUTER => self.outer,
            FACE => self.face[side as usize],
            INNER => self.inner,
            CHANNEL => self.channel,
            face if face == self.film_face => self.film[side as usize],
            _ => self.ceiling[side as usize],
        };
        if side == 0 { -height } else { height }
    }
}

/// The layers over places of a plan.
pub(crate) struct TailLayers<'a> {
    tail: &'a Tail,
}

impl<'a> TailLayers<'a> {
    pub fn new(tail: &'a Tail) -> Self {
        Self { tail }
    }

    /// Number of sheets.
    pub fn sheets(&self) -> usize {
        film_face(self.tail) as usize + 2
    }

    /// Sheets from below at a place, and the fills between them; none where there is no solid.
    pub(crate) fn layers_over(&self, x: Metre, z: Metre) -> Option<(Vec<u32>, Vec<Fill>)> {
        let half = half_stack(self.tail, x, z)?;
        // the half from the middle outwards is mirrored to the other side
        let lower = half.iter().rev().map(|&(sheet, fill)| (sheet, fill(0)));
        let mut sheets: Vec<u32> = lower.clone().map(|s| s.0).collect();
        let mut fills: Vec<Fill> = lower.map(|s| s.1).collect();
        fills.extend(half.iter().skip(1).map(|&(_, fill)| fill(1)));
        sheets.extend(half.iter().map(|&(sheet, _)| sheet + 1));
        Some((sheets, fills))
    }

    /// The column over a plan triangle; none where there is no solid.
    fn column_over(&self, plan: &Plan, corners: [u32; 3]) -> Option<Column> {
        let mean = |k: usize| corners.iter().map(|&v| plan.points[v as usize][k]).sum::<f64>() / 3.0;
        let (sheets, fills) = self.layers_over(mean(1), mean(0).abs())?;
        Some(Column { corners, sheets, fills })
    }
}

/// A sheet with what fills the space from the sheet before it (or the middle) to it, by side.
type Layer = (u32, fn(u16) -> Fill);

const SILICONE: fn(u16) -> Fill = |_| Fill::Region(BODY);
const ACETAL: fn(u16) -> Fill = |_| Fill::Region(SPINE);
const HOLLOW: fn(u16) -> Fill = Fill::Chamber;
/// A film on one side, silicone on the other.
const ON_SIDE: [fn(u16) -> Fill; 2] = [
    |side| Fill::Region(if side == 0 { FILM } else { BODY }),
    |side| Fill::Region(if side == 1 { FILM } else { BODY }),
];

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
        if let Some(unbonded) = tail.unbonded.filter(|_| tail.unbonded_stretch().is_some_and(inside)) {
            layers.push((film_face(tail), ON_SIDE[usize::from(unbonded.side)]));
        }
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
    fn a_film_lies_on_the_sheet_along_the_unbonded_stretch_alone() {
        let unbonded = crate::Unbonded { side: 1, chambers: [3, 4], film: 0.15e-3 };
        let tail = Tail { unbonded: Some(unbonded), sheet_offset: 0.1e-3, ..Tail::nine_chambers() };
        let (mesh, bonded) = (tail.mesh(&Resolution::even(&tail, 4e-3)).unwrap(), {
            let tail = Tail { unbonded: None, ..tail.clone() };
            tail.mesh(&Resolution::even(&tail, 4e-3)).unwrap()
        });
        assert_eq!(mesh.nonconformity(), None);
        let film: Vec<usize> = (0..mesh.tets.len()).filter(|tet| mesh.regions[*tet] == FILM).collect();
        let [from, to] = tail.unbonded_stretch().unwrap();
        let face = 0.5 * tail.sheet + 0.1e-3;
        for node in film.iter().flat_map(|tet| mesh.tets[*tet]).map(|node| mesh.nodes[node as usize]) {
            assert!(node[0] > from - 1e-9 && node[0] < to + 1e-9, "{node:?}");
            assert!(node[1] > face - 1e-9 && node[1] < face + unbonded.film + 1e-9, "{node:?}");
        }
        // it takes the place of silicone: the sheet from the slot of the rib within upwards, and over two chambers
        let whole: f64 = [BODY, FILM].iter().map(|region| mesh.region_volume(*region)).sum();
        assert!((whole / bonded.region_volume(BODY) - 1.0).abs() < 1e-9);
        assert!((mesh.region_volume(SPINE) / bonded.region_volume(SPINE) - 1.0).abs() < 1e-9);
        let slot = tail.rib_at(3);
        let above = |x: f64| {
            tail.sheet_half_height(x) - if x > slot[0] && x < slot[1] { tail.slot_half_height(3) } else { 0.0 }
        };
        let steps = 4000;
        let area: f64 = (0..steps).map(|i| above(from + (to - from) * (f64::from(i) + 0.5) / f64::from(steps))).sum();
        let volume = area * (to - from) / f64::from(steps) * unbonded.film;
        assert!((mesh.region_volume(FILM) / volume - 1.0).abs() < 5e-3, "{} of {volume}", mesh.region_volume(FILM));
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
