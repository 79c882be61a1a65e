//! Filling: every column becomes a sequence of tetrahedra.

use super::lines::{Node, stack_lines};
use super::ranks::Cycle;
use super::skin::{Cell, find_skin};
use super::{Column, Fill, Stack};
use crate::TetMesh;

/// A node before numbering: plan vertex and place on its line.
type LineNode = (u32, u32);

/// Fills a stack.
///
/// # Errors
/// [`Cycle`] when a sheet lies below another in one place and above it in another.
pub fn fill_stack(stack: &Stack) -> Result<TetMesh, Cycle> {
    let (lines, ranks) = stack_lines(stack)?;
    let starts: Vec<u32> = lines
        .iter()
        .scan(0, |sum, line| {
            *sum += line.len() as u32;
            Some(*sum - line.len() as u32)
        })
        .collect();
    let mut cells = Vec::new();
    for column in stack.columns {
        fill_column(column, &lines, &ranks, |nodes_of_cell, what| {
            cells.push(Cell { nodes: nodes_of_cell.map(|(v, i)| starts[v as usize] + i), fill: what });
        });
    }
    Ok(compact_mesh(stack, &lines, &cells))
}

/// Visits the tetrahedra of one column from below; the first three nodes are counterclockwise, the fourth is above one of them.
fn fill_column(column: &Column, lines: &[Vec<Node>], ranks: &[f64], mut visit: impl FnMut([LineNode; 4], Fill)) {
    let Some((&bottom, &top)) = column.sheets.first().zip(column.sheets.last()) else { return };
    let (bottom, top) = (ranks[bottom as usize], ranks[top as usize]);
    let line = |k: usize| &lines[column.corners[k] as usize];
    let mut positions = [0, 1, 2].map(|k| line(k).partition_point(|n| n.key <= bottom) as u32 - 1);
    loop {
        let next = |k: usize| line(k).get(positions[k] as usize + 1).map(|n| (n.key, column.corners[k], k));
        let steps = (0..3).filter_map(next).filter(|n| n.0 <= top);
        // Equal keys go by the vertex: the two columns beside a face must break a tie alike, or their elements do not
        // match.
        let Some((key, vertex, k)) = steps.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) else { break };
        let [a, b, c] = [0, 1, 2].map(|i| (column.corners[i], positions[i]));
        let layer = column.sheets.partition_point(|&s| ranks[s as usize] < key) - 1;
        visit([a, b, c, (vertex, positions[k] + 1)], column.fills[layer]);
        positions[k] += 1;
    }
}

/// Keeps the solid cells and the nodes that they use.
fn compact_mesh(stack: &Stack, lines: &[Vec<Node>], cells: &[Cell]) -> TetMesh {
    let places = lines.iter().zip(stack.plan);
    let places: Vec<_> = places.flat_map(|(l, &p)| l.iter().map(move |n| stack.frame.join(p, n.height))).collect();
    let mut used = vec![false; places.len()];
    let solid = |cell: &&Cell| matches!(cell.fill, Fill::Region(_));
    cells.iter().filter(solid).for_each(|cell| cell.nodes.iter().for_each(|&n| used[n as usize] = true));
    let mut number = vec![u32::MAX; places.len()];
    let mut nodes = Vec::new();
    for (n, at) in places.iter().enumerate().filter(|(n, _)| used[*n]) {
        number[n] = nodes.len() as u32;
        nodes.push(*at);
    }
    let mut skin = find_skin(cells, &places, stack.half);
    skin.iter_mut().for_each(|face| face.nodes = face.nodes.map(|n| number[n as usize]));
    let mut mesh = TetMesh { nodes, tets: Vec::new(), regions: Vec::new(), skin, half: stack.half };
    for cell in cells {
        if let Fill::Region(region) = cell.fill {
            mesh.tets.push(cell.nodes.map(|n| number[n as usize]));
            mesh.regions.push(region);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::stack::tests::{slanted_block, square_plan};

    #[test]
    fn a_filled_block_has_the_volume_of_its_columns() {
        let (plan, columns) = square_plan(vec![0, 1], vec![Fill::Region(0)]);
        let height = |v: u32, s: u32| if s == 0 { 0.0 } else { 1.0 + 0.5 * f64::from(v % 3) };
        let stack = slanted_block(&plan, &columns, 2, &height);
        let mesh = fill_stack(&stack).unwrap();
        let prism = |c: &Column| {
            let [a, b, d] = c.corners.map(|v| plan[v as usize]);
            let mean = c.corners.iter().map(|&v| height(v, 1)).sum::<f64>() / 3.0;
            crate::frame::doubled_area(a, b, d) / 2.0 * mean
        };
        let expected: f64 = columns.iter().map(prism).sum();
        assert!((mesh.region_volume(0) - expected).abs() < 1e-12);
        assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.0));
    }

    #[test]
    fn a_layer_that_vanishes_on_some_lines_collapses_there() {
        let (plan, columns) = square_plan(vec![0, 1, 2], vec![Fill::Region(0), Fill::Region(1)]);
        let height = |v: u32, s: u32| if s == 2 && v != 0 { 1.0 } else { f64::from(s) };
        let mesh = fill_stack(&slanted_block(&plan, &columns, 3, &height)).unwrap();
        assert!((mesh.region_volume(0) - 9.0).abs() < 1e-12);
        assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.0));
        assert!(mesh.region_volume(1) > 0.0);
    }

    #[test]
    fn every_axis_can_be_the_upright_one() {
        let (plan, columns) = square_plan(vec![0, 1], vec![Fill::Region(0)]);
        for normal in 0..3 {
            let stack = Stack { frame: Frame { normal }, ..slanted_block(&plan, &columns, 2, &|_, s| f64::from(s)) };
            assert!((fill_stack(&stack).unwrap().region_volume(0) - 9.0).abs() < 1e-12);
        }
    }
}
