//! Hexahedra in columns: rows of quadrilaterals over the sheet's plane, levels through all layers, cells short where thin walls bend.
//!
//! Rows stand at the stations of the outlines: faces of ribs, ends of chambers, corners. Levels are the sheets of the body, continued through
//! the solids in which they end. So the body must be one that rows and levels divide: outlines that run along the plan or across it, layers in
//! one order. Where it is not, [`crate::mesh`] fills it with tetrahedra.
//!
//! The error of a thin wall under pressure lies at the junction of wall and rib and in the boundary layers beside it, not in the sheet and
//! not along the height (`just bench resolution`): cells are sized in units of the wall's thickness, along a chamber, and through its depth
//! towards the wall.
//!
//! Half of a tail with walls of 1.55 mm, channel and fin included, under pressure on one side without contact: angle of its end, pressure of a
//! dent of 1 mm, factorisations of an equilibrium in the mean (at worst) over 14 levels to 230 mbar; all paths go on to 300 mbar. Lengths over
//! the thickness: through the depth from the wall, along a chamber, along a row near the middle and beyond; the share of the μ part at finer
//! points. Gflop are of an elimination order that looked at seven planes an axis; today's takes six tenths. The last row is the finest that was solved; its error is not known from a second family of elements.
//!
//! | depth          | chamber   | row        | share | dofs   | Gflop | at 100, 160, 225 mbar  | dent       | factorisations |
//! |----------------|-----------|------------|-------|--------|-------|------------------------|------------|----------------|
//! | 0.5, 1.3       | 0.55, 1.4 | 7          | 0.25  | 30 445 | 6.9   | 11.71°, 29.24°, 71.23° | 136.7 mbar | 3.9 (6)        |
//! | 0.45, 1.1, 2.0 | 0.45, 1.1 | 7          | 0.2   | 38 990 | 8.9   | 11.75°, 29.87°, 72.18° | 135.3 mbar | 7.6 (42)       |
//! | the same, in contact |     |            | 0.2   | 38 990 | 8.9   | 11.75°, 29.87°, 72.08° | 135.3 mbar | 6.0 (25)       |
//! | **0.5, 1.3**   | 0.55, 1.4 | 5.9 and 9  | 0.2   | 36 530 | 10.1  | 11.77°, 29.67°, 72.04° | 135.9 mbar | 3.9 (6)        |
//! | 0.45, 1.1, 2.0 | 0.45, 1.1 | 5.9 and 9  | 0.2   | 46 217 | 14.2  | 11.79°, 30.15°, 72.64° | 134.8 mbar | 6.4 (30)       |
//! | 0.5, 1.3       | 0.55, 1.4 | 5.9        | 0.25  | 42 500 | 14.7  | 11.80°, 29.98°, 72.38° | 135.4 mbar | 4.8 (13)       |
//! | 0.33, 0.87     | 0.37, 0.93 | 3.9       | 0.1   | 60 157 | 24.4  | 11.85°, 30.72°, 73.32° | 134.0 mbar | 6.9 (32)       |
//!
//! A third cut of the depth makes walls jump at 205 mbar, which costs steps; rows beyond half of the height cost half of the work again for
//! 1 % of the angle.

mod division;
mod fill;
mod layered;
mod levels;
mod rows;
mod stations;
#[cfg(test)]
mod tests;

pub use layered::{LayeredBody, layers_in_hexahedra};
pub use stations::Slab;

use super::plane::Plane;
use super::sequence::Sampler;
use super::sheets::{Layers, Sheets};
use super::{MeshError, Settings};
use crate::QuadraticMesh;
use crate::columns::arrange::Graph;
use layered::Layered;
use rows::{Cells, Division, plan_cells};
use stations::find_slabs;

/// How finely thin walls are divided: lengths of cells over the thickness of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grading {
    /// Along a chamber: the first cell beside a rib, and the longest between.
    pub along: [f64; 2],
    /// Through a chamber's depth from the outer wall inwards, where there are ribs; what is left is the last cell.
    pub depth: [f64; 2],
    /// Along a row: up to halfway from the middle of the body to its edge, and beyond.
    pub height: [f64; 2],
    /// Layers of the outer wall.
    pub wall: usize,
}

impl Grading {
    /// The cheapest grading on which no wall of a thin tail jumps: its angle is within 0.7, 3.5 and 1.8 % of that of cells shorter
    /// by 1.5, at 100, 160 and 225 mbar.
    pub const COARSE: Self = Self { along: [0.55, 1.4], depth: [0.5, 1.3], height: [5.9, 9.0], wall: 1 };

    /// The same with all cells shorter by a factor.
    pub fn finer(self, factor: f64) -> Self {
        let wall = (self.wall as f64 * factor).floor().max(1.0) as usize;
        Self {
            along: self.along.map(|length| length / factor),
            depth: self.depth.map(|length| length / factor),
            height: self.height.map(|length| length / factor),
            wall,
        }
    }
}

/// Hexahedra over the plan of `outlines`.
///
/// # Errors
/// [`MeshError`] where rows and levels do not divide the body.
pub(crate) fn mesh_hexahedra(
    outlines: &Graph,
    sampler: &Sampler,
    set: &Settings,
    grading: &Grading,
) -> Result<QuadraticMesh, MeshError> {
    let not_swept = |at| MeshError::NotSwept { at: sampler.frame.join(at, 0.0), why: "outlines end between two rows" };
    let slabs = find_slabs(outlines, sampler.tolerance).map_err(not_swept)?;
    let regions = sampler
        .region_sequences(&plane_of_cells(&plan_cells(&slabs, &Division::undivided(slabs.len(), sampler.tolerance))))?;
    let sheets = Sheets::new(sampler.patches, &regions);
    let layers: Vec<Option<Layers>> =
        regions.iter().map(|region| region.as_ref().map(|region| sheets.layers_of(region))).collect();
    let body = Layered {
        frame: sampler.frame,
        slabs: &slabs,
        layers: &layers,
        sheets: sheets.count(),
        height: &|place, sheet| sheets.sheet_height(place, sheet),
        place: &|sheet| sheets.place_of(sheet),
        tolerance: sampler.tolerance,
        cut: sampler.frame.plan_axis(2).filter(|_| set.use_symmetry),
    };
    body.fill_layers(set.edge, grading)
}

/// The cells as triangles, one region for each strip.
fn plane_of_cells(cells: &Cells) -> Plane {
    let halves = cells.cells.iter().flat_map(|cell| {
        let [a, b, c, d, ..] = cell.nodes;
        [([a, b, c], cell.strip), ([a, c, d], cell.strip)]
    });
    let (triangles, regions) = halves.filter(|([_, b, c], _)| b != c).unzip();
    Plane { points: cells.points.clone(), triangles, regions, region_count: cells.strips, chords: Vec::new() }
}
