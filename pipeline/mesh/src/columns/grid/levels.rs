//! Levels: sheets in one order, so that every line over the plan is divided in the same way and cells above each other match.
//!
//! A sheet that ends, as the ceiling of a chamber does at a rib, is continued through the solid beside it: there, layers share a height in
//! proportion to their thicknesses nearby.

use crate::columns::MeshError;
use crate::columns::sheets::Layers;
use crate::stack::Order;
use si::{Metre, Point2};
use std::collections::BTreeMap;

/// The plan with what lies over it.
pub(crate) struct Covered<'a> {
    /// (p, q), m.
    pub points: &'a [Point2],
    /// Points of each cell, and its layers; none over the surroundings.
    pub cells: Vec<(Vec<u32>, Option<&'a Layers>)>,
    /// Number of sheets.
    pub sheets: usize,
    /// Height of a sheet at a plan point, m.
    pub height: &'a dyn Fn(u32, u32) -> Metre,
    /// Sheets nearer than this have no order there, m.
    pub tolerance: Metre,
}

/// Levels and their heights.
#[derive(Debug)]
pub(crate) struct Levels {
    /// Of each sheet.
    pub of_sheet: Vec<usize>,
    /// points × levels, m; none where nothing needs it.
    pub heights: Vec<Vec<Option<Metre>>>,
}

impl Levels {
    /// Of the sheets over a plan.
    ///
    /// # Errors
    /// [`MeshError::NoCommonOrder`] by `place` of the sheets; [`MeshError::NotSwept`] where two sheets of one level have different heights.
    pub fn new(covered: &Covered, fail: &dyn Fn(u32, u32) -> MeshError) -> Result<Self, MeshError> {
        let sheets_at = sheets_at(covered);
        let mut order = Order::default();
        (0..covered.sheets as u32).for_each(|sheet| order.note_height(sheet, 0.0));
        for layers in covered.cells.iter().filter_map(|cell| cell.1) {
            layers.sheets.windows(2).for_each(|pair| order.note_below(pair[0], pair[1]));
        }
        for sheets in &sheets_at {
            for (&lower, low) in sheets {
                let above = sheets.iter().filter(|(_, high)| **high - low > covered.tolerance);
                above.for_each(|(&upper, _)| order.note_below(lower, upper));
            }
        }
        // longest paths from below: sheets of one kind have one level
        let ranks = order.sheet_ranks(covered.sheets, 1.0).map_err(|cycle| fail(cycle.lower, cycle.upper))?;
        let of_sheet: Vec<usize> = ranks.iter().map(|rank| *rank as usize).collect();
        let count = of_sheet.iter().max().map_or(0, |most| most + 1);
        let mut heights = vec![vec![None; count]; covered.points.len()];
        for (heights, sheets) in heights.iter_mut().zip(&sheets_at) {
            for (&sheet, &height) in sheets {
                let entry = &mut heights[of_sheet[sheet as usize]];
                if entry.is_some_and(|noted: Metre| (noted - height).abs() > covered.tolerance) {
                    let other = sheets.keys().find(|other| of_sheet[**other as usize] == of_sheet[sheet as usize]);
                    return Err(fail(other.copied().unwrap_or(sheet), sheet));
                }
                *entry = Some(height);
            }
        }
        let mut levels = Self { of_sheet, heights };
        levels.continue_through_solids(covered);
        Ok(levels)
    }

    /// Number of levels.
    pub fn count(&self) -> usize {
        self.heights.first().map_or(0, Vec::len)
    }

    /// Heights of levels that lie within a solid.
    fn continue_through_solids(&mut self, covered: &Covered) {
        let thickness = self.layer_thicknesses(covered);
        for (heights, thickness) in self.heights.iter_mut().zip(thickness) {
            let known_levels: Vec<usize> = (0..heights.len()).filter(|level| heights[*level].is_some()).collect();
            for pair in known_levels.windows(2) {
                let Some((from, to)) = heights[pair[0]].zip(heights[pair[1]]) else { continue };
                let total_thickness: f64 = thickness[pair[0]..pair[1]].iter().sum();
                let mut sum = 0.0;
                for level in pair[0] + 1..pair[1] {
                    sum += thickness[level - 1];
                    heights[level] = Some(from + (to - from) * sum / total_thickness);
                }
            }
        }
    }

    /// points × layers: thicknesses where both of their levels are known, elsewhere the means of those around, m.
    fn layer_thicknesses(&self, covered: &Covered) -> Vec<Vec<Metre>> {
        let layers = self.count().saturating_sub(1);
        let known_gaps: Vec<Vec<Option<Metre>>> = self.heights.iter().map(|heights| height_gaps(heights)).collect();
        let neighbours = weighted_neighbours(covered);
        let mean = |layer: usize| {
            let gaps_of_layer: Vec<Metre> = known_gaps.iter().filter_map(|gaps| gaps[layer]).collect();
            if gaps_of_layer.is_empty() { 1.0 } else { gaps_of_layer.iter().sum::<f64>() / gaps_of_layer.len() as f64 }
        };
        let means: Vec<Metre> = (0..layers).map(mean).collect();
        let start =
            |gaps: &Vec<Option<Metre>>| gaps.iter().zip(&means).map(|(gap, mean)| gap.unwrap_or(*mean)).collect();
        let mut thickness: Vec<Vec<Metre>> = known_gaps.iter().map(start).collect();
        for _ in 0..SWEEPS {
            for point in 0..thickness.len() {
                for layer in (0..layers).filter(|layer| known_gaps[point][*layer].is_none()) {
                    let (sum, weights) =
                        neighbours[point].iter().fold((0.0, 0.0), |(sum, weights), &(other, weight)| {
                            (sum + weight * thickness[other as usize][layer], weights + weight)
                        });
                    thickness[point][layer] = if weights > 0.0 { sum / weights } else { means[layer] };
                }
            }
        }
        thickness
    }
}

/// Sweeps of Gauss and Seidel: shapes of elements, not results, depend on them.
const SWEEPS: usize = 200;

/// Differences of neighbouring heights where both are known.
fn height_gaps(heights: &[Option<Metre>]) -> Vec<Option<Metre>> {
    // Levels that meet keep a share: where all between two known heights did, their shares would be 0/0.
    heights.windows(2).map(|pair| Some((pair[1]? - pair[0]?).max(1e-9))).collect()
}

/// Sheets of all cells around each point with their heights there.
fn sheets_at(covered: &Covered) -> Vec<BTreeMap<u32, Metre>> {
    let mut sheets = vec![BTreeMap::new(); covered.points.len()];
    for (points, layers) in &covered.cells {
        for (&point, &sheet) in
            points.iter().flat_map(|point| layers.iter().flat_map(move |l| l.sheets.iter().map(move |s| (point, s))))
        {
            sheets[point as usize].entry(sheet).or_insert_with(|| (covered.height)(point, sheet));
        }
    }
    sheets
}

/// Points that share a cell's side, with weights that fall with their distance.
fn weighted_neighbours(covered: &Covered) -> Vec<Vec<(u32, f64)>> {
    let mut neighbours = vec![BTreeMap::new(); covered.points.len()];
    for (points, _) in covered.cells.iter().filter(|cell| cell.1.is_some()) {
        for (&a, &b) in points.iter().flat_map(|a| points.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
            let [from, to] = [a, b].map(|n| covered.points[n as usize]);
            neighbours[a as usize].insert(b, 1.0 / (from[0] - to[0]).hypot(from[1] - to[1]).max(1e-9));
        }
    }
    neighbours.into_iter().map(|around| around.into_iter().collect()).collect()
}
