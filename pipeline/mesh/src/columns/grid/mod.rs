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
//! Half of a tail with walls of 1.55 mm, from its surfaces with channel and fin, under pressure on one side without contact: angle of its end,
//! pressure of a dent of 1 mm, factorisations of an equilibrium in the mean (at worst) over 14 levels to 230 mbar; all paths go on to 300 mbar.
//! Lengths over the thickness: through the depth from the wall, along a row; the share of the μ part at finer points.
//!
//! | depth         | row  | share | dofs   | Gflop | at 100, 160, 225 mbar  | dent       | factorisations |
//! |---------------|------|-------|--------|-------|------------------------|------------|----------------|
//! | 0.5, 1.3      | 7    | 0.25  | 30 445 | 6.9   | 11.71°, 29.24°, 71.23° | 136.7 mbar | 3.9 (6)        |
//! | 0.4, 0.9, 2.2 | 7    | 0.25  | 33 745 | 7.4   | 11.71°, 29.53°, 71.52° | 135.8 mbar | 5.9 (24)       |
//! | 0.4, 0.9, 2.2 | 7    | 0.15  | 33 745 | 7.4   | 11.73°, 29.71°, 71.94° | 135.5 mbar | 6.2 (29)       |
//! | **0.5, 1.3**  | 5.9  | 0.15  | 42 343 | 15.7  | 11.80°, 30.13°, 72.66° | 135.0 mbar | 4.9 (11)       |
//! | 0.4, 0.9, 2.2 | 5.5  | 0.25  | 46 591 | 17.4  | 11.79°, 30.29°, 72.62° | 134.6 mbar | 9.4 (61)       |
//! | all cells shorter by 1.5 | | 0.1 | 60 157 | 24.4 | 11.85°, 30.72°, 73.32° | 134.0 mbar | 6.9 (32)    |

mod fill;
mod levels;
mod rows;
mod stations;
#[cfg(test)]
mod tests;

use super::plane::Plane;
use super::sequence::{Sampler, Sequence};
use super::sheets::{Layers, Sheets};
use super::{MeshError, Settings};
use crate::QuadraticMesh;
use crate::columns::arrange::Graph;
use crate::stack::Fill;
use fill::Grid;
use levels::{Covered, Levels};
use rows::{Cells, Division, cells};
use si::Metre;
use stations::{Slab, slabs};

/// How finely thin walls are divided: lengths of cells over the thickness of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grading {
    /// Along a chamber: the first cell beside a rib, and the longest between.
    pub along: [f64; 2],
    /// Through a chamber's depth from the outer wall inwards, where there are ribs; what is left is the last cell.
    pub depth: [f64; 2],
    /// Along a row.
    pub height: f64,
    /// Layers of the outer wall.
    pub wall: usize,
}

impl Grading {
    /// The grading by which angle and dent of a thin tail are within some 2 % of their limits.
    pub const COARSE: Self = Self { along: [0.55, 1.4], depth: [0.5, 1.3], height: 5.9, wall: 1 };

    /// The same with all cells shorter by a factor.
    pub fn finer(self, factor: f64) -> Self {
        let wall = (self.wall as f64 * factor).floor().max(1.0) as usize;
        Self {
            along: self.along.map(|length| length / factor),
            depth: self.depth.map(|length| length / factor),
            height: self.height / factor,
            wall,
        }
    }
}

/// Cells of a strip that holds a chamber, at least, between those beside its ends.
const LEAST_INSIDE: f64 = 2.0;
/// The first cell beside a rib is at most this part of a chamber.
const LARGEST_SHARE: f64 = 0.2;
/// Longest cells where there is no chamber, over the wall's thickness.
const SOLID: f64 = 3.0;

/// Hexahedra over the plan of `outlines`.
///
/// # Errors
/// [`MeshError`] where rows and levels do not divide the body.
pub(crate) fn hexahedra(
    outlines: &Graph,
    sampler: &Sampler,
    set: &Settings,
    grading: &Grading,
) -> Result<QuadraticMesh, MeshError> {
    let not_swept = |at: [f64; 2], why| MeshError::NotSwept { at: sampler.frame.join(at, 0.0), why };
    let slabs = slabs(outlines, sampler.tolerance).map_err(|at| not_swept(at, "outlines end between two rows"))?;
    let coarse = Division {
        inside: vec![Vec::new(); slabs.len()],
        longest: f64::INFINITY,
        shortest: f64::INFINITY,
        tolerance: sampler.tolerance,
    };
    let plane = plane(&cells(&slabs, &coarse));
    let regions = sampler.regions(&plane)?;
    let sheets = Sheets::new(sampler.patches, &regions);
    let layers: Vec<Option<Layers>> =
        regions.iter().map(|region| region.as_ref().map(|region| sheets.layers(region))).collect();
    let wall = wall(&plane, &regions, &sheets).unwrap_or(set.edge);
    let division = Division {
        inside: inside(&slabs, &regions, wall, grading),
        longest: grading.height * wall,
        shortest: 0.1 * wall,
        tolerance: sampler.tolerance,
    };
    let cells = cells(&slabs, &division);
    let levels = levels(&cells, &layers, &sheets, sampler.tolerance)?;
    let cut = sampler.frame.plan_axis(2).filter(|_| set.use_symmetry);
    let grid = Grid { cells: &cells, layers: &layers, levels: &levels, frame: sampler.frame, cut };
    grid.fill(wall, grading).map_err(|at| not_swept(at, "layers meet"))
}

/// The levels over the cells of a plan, of which every strip has its layers.
fn levels(cells: &Cells, layers: &[Option<Layers>], sheets: &Sheets, tolerance: Metre) -> Result<Levels, MeshError> {
    let covered = Covered {
        points: &cells.points,
        cells: cells.cells.iter().map(|cell| (distinct(&cell.nodes), layers[cell.strip as usize].as_ref())).collect(),
        sheets: sheets.count(),
        height: &|point, sheet| sheets.height(cells.points[point as usize], sheet),
        tolerance,
    };
    let no_order = |lower, upper| MeshError::NoCommonOrder { lower: sheets.place(lower), upper: sheets.place(upper) };
    Levels::new(&covered, &no_order)
}

/// The nodes of a cell, each once.
fn distinct(nodes: &[u32; 8]) -> Vec<u32> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The cells as triangles, one region for each strip.
fn plane(cells: &Cells) -> Plane {
    let halves = cells.cells.iter().flat_map(|cell| {
        let [a, b, c, d, ..] = cell.nodes;
        [([a, b, c], cell.strip), ([a, c, d], cell.strip)]
    });
    let (triangles, regions) = halves.filter(|([_, b, c], _)| b != c).unzip();
    Plane { points: cells.points.clone(), triangles, regions, region_count: cells.strips, chords: Vec::new() }
}

/// Thickness of the thinnest outer wall over a chamber, m.
fn wall(plane: &Plane, regions: &[Option<Sequence>], sheets: &Sheets) -> Option<Metre> {
    let mut walls = Vec::new();
    for (triangle, region) in plane.regions.iter().enumerate() {
        let Some(sequence) = regions[*region as usize].as_ref().filter(|sequence| is_hollow(sequence)) else {
            continue;
        };
        let layers = sheets.layers(sequence);
        let at = super::sequence::centroid(plane, triangle);
        let thickness =
            |lower: usize| sheets.height(at, layers.sheets[lower + 1]) - sheets.height(at, layers.sheets[lower]);
        walls.extend([thickness(0), thickness(layers.fills.len() - 1)]);
    }
    walls.into_iter().reduce(f64::min)
}

fn is_hollow(sequence: &Sequence) -> bool {
    sequence.fills.iter().any(|fill| matches!(fill, Fill::Chamber(_)))
}

/// Rows between the stations of each slab.
fn inside(slabs: &[Slab], regions: &[Option<Sequence>], wall: Metre, grading: &Grading) -> Vec<Vec<f64>> {
    let mut first = 0;
    let mut rows = Vec::new();
    for slab in slabs {
        let strips = first..first + slab.curves().saturating_sub(1);
        first = strips.end;
        let length = slab.to - slab.from;
        let [beside, between] = grading.along.map(|part| part * wall);
        // a channel through a rib is no chamber that its wall bulges over
        let middle = 0.5 * (slab.from + slab.to);
        let height = |lower: usize| slab.place(lower + 1, middle) - slab.place(lower, middle);
        let (mut hollow, mut solid) = (0.0, 0.0);
        for (lower, region) in regions[strips].iter().enumerate() {
            match region {
                Some(sequence) if is_hollow(sequence) => hollow += height(lower),
                Some(_) => solid += height(lower),
                None => {}
            }
        }
        let chamber = hollow > solid;
        rows.push(if chamber {
            graded(length, beside.min(LARGEST_SHARE * length), between)
        } else {
            even(length / (SOLID / grading.along[1] * between))
        });
    }
    rows
}

/// Fractions of a chamber with a short cell at either end.
fn graded(length: Metre, beside: Metre, longest: Metre) -> Vec<f64> {
    let pieces = ((length - 2.0 * beside) / longest).ceil().max(LEAST_INSIDE);
    let place = |n: usize| (beside + (length - 2.0 * beside) * n as f64 / pieces) / length;
    (0..=pieces as usize).map(place).collect()
}

/// Fractions that divide a length of so many cells evenly.
fn even(cells: f64) -> Vec<f64> {
    let pieces = cells.ceil().max(1.0) as usize;
    (1..pieces).map(|n| n as f64 / pieces as f64).collect()
}
