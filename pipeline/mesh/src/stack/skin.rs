//! Skin: the faces between a solid and a chamber, the surroundings or the plane of symmetry.

use super::Fill;
use crate::tetrahedra::FACES;
use crate::{Skin, SkinFace};
use si::Point3;

/// A tetrahedron of a column, solid or not.
pub(crate) struct Cell {
    pub nodes: [u32; 4],
    pub fill: Fill,
}

/// Sorted corners of a face, then its cell and its place there.
type Side = ([u32; 3], u32, u8);

fn all_sides(cells: &[Cell]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(4 * cells.len());
    for (c, cell) in cells.iter().enumerate() {
        for (f, face) in FACES.iter().enumerate() {
            let mut key = face.map(|i| cell.nodes[i]);
            key.sort_unstable();
            sides.push((key, c as u32, f as u8));
        }
    }
    sides.sort_unstable();
    sides
}

/// Faces with a solid on one side only, in the order of their cells.
pub(crate) fn find_skin(cells: &[Cell], places: &[Point3], half: bool) -> Vec<SkinFace> {
    let sides = all_sides(cells);
    let mut sides_of_skin = Vec::new();
    for pair in sides.chunk_by(|a, b| a.0 == b.0) {
        let solids: Vec<&Side> = pair.iter().filter(|s| is_solid(cells, s)).collect();
        let [side] = solids[..] else { continue };
        let opposite_fill = pair.iter().find(|s| !is_solid(cells, s)).map(|s| cells[s.1 as usize].fill);
        let cut = half && side.0.iter().all(|&n| places[n as usize][2] == 0.0);
        let skin_kind = match opposite_fill {
            Some(Fill::Chamber(k)) => Skin::Chamber(k),
            None if cut => Skin::Symmetry,
            _ => Skin::Outer,
        };
        sides_of_skin.push((side.1, side.2, skin_kind));
    }
    sides_of_skin.sort_unstable();
    let face = |&(cell, side, skin_kind): &(u32, u8, Skin)| {
        let nodes = FACES[side as usize].map(|i| cells[cell as usize].nodes[i]);
        SkinFace { nodes, on: skin_kind }
    };
    sides_of_skin.iter().map(face).collect()
}

fn is_solid(cells: &[Cell], side: &Side) -> bool {
    matches!(cells[side.1 as usize].fill, Fill::Region(_))
}
