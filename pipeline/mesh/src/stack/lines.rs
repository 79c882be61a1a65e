//! Lines: the nodes over each plan vertex, with the key that defines one order of all nodes of the stack.

use super::ranks::{Cycle, Order};
use super::{Column, Fill, Stack};
use si::Metre;

/// Pieces of a line are at most 1.25 target lengths high: higher ones give flat elements beside finely divided lines.
const TALL: f64 = 0.25;

/// A node on a line: its height (m) and its key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub height: Metre,
    pub key: f64,
}

/// Sheets that share one height on a line.
struct Level {
    height: Metre,
    sheets: Vec<u32>,
}

/// The nodes of every line from below, and the rank of every sheet.
///
/// # Errors
/// [`Cycle`] when the sheets have no common order.
pub(crate) fn stack_lines(stack: &Stack) -> Result<(Vec<Vec<Node>>, Vec<f64>), Cycle> {
    let columns = columns_around(stack);
    let levels: Vec<_> = (0..stack.plan.len()).map(|v| vertex_levels(stack, v as u32, &columns[v])).collect();
    // At least a micrometre apart: sheets that meet everywhere would have one rank, and keys on their lines no order.
    let ranks = sheet_order(stack, &levels).sheet_ranks(stack.sheets, stack.merge.max(1e-6))?;
    let lines = levels.iter().zip(&columns).map(|(levels, columns)| {
        let knots: Vec<_> = levels.iter().map(|level| level_knot(level, &ranks)).collect();
        subdivide_line(stack, &knots, columns, &ranks)
    });
    Ok((lines.collect(), ranks))
}

fn columns_around(stack: &Stack) -> Vec<Vec<u32>> {
    let mut columns = vec![Vec::new(); stack.plan.len()];
    for (c, column) in stack.columns.iter().enumerate() {
        column.corners.iter().for_each(|&v| columns[v as usize].push(c as u32));
    }
    columns
}

/// The sheets of all columns around one vertex, those nearer than `merge` joined.
fn vertex_levels(stack: &Stack, vertex: u32, columns: &[u32]) -> Vec<Level> {
    let mut sheets: Vec<u32> = columns.iter().flat_map(|&c| stack.columns[c as usize].sheets.iter().copied()).collect();
    sheets.sort_unstable();
    sheets.dedup();
    let mut heights: Vec<(Metre, u32)> = sheets.into_iter().map(|s| ((stack.height)(vertex, s), s)).collect();
    heights.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut levels: Vec<Level> = Vec::new();
    for (height, sheet) in heights {
        match levels.last_mut() {
            Some(level) if height - level.height <= stack.merge => level.sheets.push(sheet),
            _ => levels.push(Level { height, sheets: vec![sheet] }),
        }
    }
    levels
}

fn sheet_order(stack: &Stack, levels: &[Vec<Level>]) -> Order {
    let mut order = Order::default();
    for column in stack.columns {
        column.sheets.windows(2).for_each(|w| order.note_below(w[0], w[1]));
    }
    for line in levels {
        for (i, level) in line.iter().enumerate() {
            level.sheets.iter().for_each(|&s| order.note_height(s, level.height));
            let above = line.get(i + 1).map_or(&[][..], |l| &l.sheets);
            level.sheets.iter().for_each(|&s| above.iter().for_each(|&t| order.note_below(s, t)));
        }
    }
    order
}

/// Height, lowest and highest rank of a level.
type Knot = (Metre, f64, f64);

fn level_knot(level: &Level, ranks: &[f64]) -> Knot {
    let ranks_of_level = level.sheets.iter().map(|&s| ranks[s as usize]);
    (
        level.height,
        ranks_of_level.clone().fold(f64::INFINITY, f64::min),
        ranks_of_level.fold(f64::NEG_INFINITY, f64::max),
    )
}

/// Nodes at the knots and, where some column is solid, between them.
fn subdivide_line(stack: &Stack, knots: &[Knot], columns: &[u32], ranks: &[f64]) -> Vec<Node> {
    let mut nodes = Vec::new();
    for (i, &(height, key, top)) in knots.iter().enumerate() {
        nodes.push(Node { height, key });
        let Some(&(next, next_key, _)) = knots.get(i + 1) else { break };
        let middle = (top + next_key) / 2.0;
        let solid = columns.iter().any(|&c| is_solid_at(&stack.columns[c as usize], middle, ranks));
        let pieces = if solid { ((next - height) / stack.edge + TALL).round().max(1.0) as usize } else { 1 };
        nodes.extend((1..pieces).map(|p| {
            let part = p as f64 / pieces as f64;
            Node { height: height + part * (next - height), key: top + part * (next_key - top) }
        }));
    }
    nodes
}

/// Whether a column is solid at a key between two levels.
fn is_solid_at(column: &Column, key: f64, ranks: &[f64]) -> bool {
    let above = column.sheets.partition_point(|&s| ranks[s as usize] < key);
    above > 0 && above < column.sheets.len() && matches!(column.fills[above - 1], Fill::Region(_))
}
