//! Bodies of layers over a plan: the rows and levels that divide them.

use super::Grading;
use super::division::Rows;
use super::fill::Grid;
use super::levels::{Covered, Levels};
use super::rows::{Cells, Division, plan_cells};
use super::stations::Slab;
use crate::columns::MeshError;
use crate::columns::sheets::Layers;
use crate::frame::Frame;
use crate::{QuadraticMesh, stack};
use si::{Metre, Point2, Point3};

/// A body as it was drawn: outlines along a plan and the layers between them, from which hexahedra are made without a surface.
pub struct LayeredBody<'a> {
    /// Orientation of the plan in space.
    pub frame: Frame,
    /// The plan between stations, along its second axis.
    pub slabs: &'a [Slab],
    /// Sheets from below over a plan point, and the fills between them, one fewer; none beside the body.
    pub layers: &'a dyn Fn(Point2) -> Option<(Vec<u32>, Vec<stack::Fill>)>,
    /// Number of sheets.
    pub sheets: usize,
    /// Height of a sheet above a plan point, m.
    pub height: &'a dyn Fn(Point2, u32) -> Metre,
    /// Points nearer than this are one, m.
    pub tolerance: Metre,
    /// Whether the plan has only z ≥ 0.
    pub half: bool,
}

/// Hexahedra of 20 nodes, graded towards thin walls, of a body whose layers are known.
///
/// # Errors
/// [`MeshError::NoCommonOrder`] of layers that cross; [`MeshError::NotSwept`] where they have no thickness.
pub fn layers_in_hexahedra(body: &LayeredBody, grading: &Grading) -> Result<QuadraticMesh, MeshError> {
    let strips = body.slabs.iter().flat_map(Slab::strip_centres);
    let layers: Vec<Option<Layers>> =
        strips.map(|centre| (body.layers)(centre).map(|(sheets, fills)| Layers { sheets, fills })).collect();
    // for messages alone: no sheet has a place of its own
    let first_centre = body.slabs.iter().flat_map(Slab::strip_centres).next().unwrap_or_default();
    let layered = Layered {
        frame: body.frame,
        slabs: body.slabs,
        layers: &layers,
        sheets: body.sheets,
        height: body.height,
        place: &|sheet| body.frame.join(first_centre, (body.height)(first_centre, sheet)),
        tolerance: body.tolerance,
        cut: body.frame.plan_axis(2).filter(|_| body.half),
    };
    let longest_slab = body.slabs.iter().map(Slab::length).fold(0.0, f64::max);
    layered.fill_layers(longest_slab, grading)
}

/// A body whose layers over each strip of its plan are known.
pub(crate) struct Layered<'a> {
    pub frame: Frame,
    pub slabs: &'a [Slab],
    /// By strip, numbered over all slabs.
    pub layers: &'a [Option<Layers>],
    /// Number of sheets.
    pub sheets: usize,
    /// Height of a sheet above a plan point, m.
    pub height: &'a dyn Fn(Point2, u32) -> Metre,
    /// A point on a sheet, for messages, m.
    pub place: &'a dyn Fn(u32) -> Point3,
    pub tolerance: Metre,
    /// The plan axis along which a half model is cut at 0.
    pub cut: Option<usize>,
}

impl Layered<'_> {
    /// Elements between all levels; cells of a body without a chamber are sized as if its wall were `edge` (m) thick.
    ///
    /// # Errors
    /// [`MeshError`] where rows and levels do not divide the body.
    pub(crate) fn fill_layers(&self, edge: Metre, grading: &Grading) -> Result<QuadraticMesh, MeshError> {
        let wall = self.outer_wall().unwrap_or(edge);
        let division = Division {
            inside: Rows { wall, grading }.rows_inside(self.slabs, self.layers),
            longest: grading.height.map(|part| part * wall),
            half: self.cut == Some(0),
            // A shorter cell would be a sliver beside cells of half a wall; a wedge changes the number of points there.
            shortest: 0.1 * wall,
            tolerance: self.tolerance,
        };
        let cells = plan_cells(self.slabs, &division);
        let levels = self.levels_over(&cells)?;
        let grid = Grid { cells: &cells, layers: self.layers, levels: &levels, frame: self.frame, cut: self.cut };
        let no_thickness = |at| MeshError::NotSwept { at: self.frame.join(at, 0.0), why: "layers meet" };
        grid.fill_blocks(wall, grading).map_err(no_thickness)
    }

    /// Thickness of the thinnest outer wall over a chamber, m.
    fn outer_wall(&self) -> Option<Metre> {
        let strips = self.slabs.iter().flat_map(Slab::strips).zip(self.layers);
        let hollow =
            strips.filter_map(|(strip, layers)| Some((strip, layers.as_ref().filter(|layers| layers.is_hollow())?)));
        let thicknesses = hollow.flat_map(|((slab, lower), layers)| {
            PLACES.map(|part| slab.from + part * slab.length()).into_iter().flat_map(move |q| {
                let centre = [0.5 * (slab.curve_position(lower, q) + slab.curve_position(lower + 1, q)), q];
                let height = |level: usize| (self.height)(centre, layers.sheets[level]);
                let top = layers.sheets.len() - 1;
                [height(1) - height(0), height(top) - height(top - 1)]
            })
        });
        // The thinnest wall sizes all cells: boundary layers are as wide as their wall is thick, and it is the one that
        // bulges and buckles.
        thicknesses.reduce(f64::min)
    }

    /// The levels over the cells of the plan.
    fn levels_over(&self, cells: &Cells) -> Result<Levels, MeshError> {
        let layers_of = |strip: u32| self.layers[strip as usize].as_ref();
        let covered = Covered {
            points: &cells.points,
            cells: cells.cells.iter().map(|cell| (distinct_nodes(&cell.nodes), layers_of(cell.strip))).collect(),
            sheets: self.sheets,
            height: &|point, sheet| (self.height)(cells.points[point as usize], sheet),
            tolerance: self.tolerance,
        };
        let no_order =
            |lower, upper| MeshError::NoCommonOrder { lower: (self.place)(lower), upper: (self.place)(upper) };
        Levels::new(&covered, &no_order)
    }
}

/// Places along a strip at which walls are measured.
const PLACES: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// The nodes of a cell, each once.
fn distinct_nodes(nodes: &[u32; 8]) -> Vec<u32> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
