//! Layered layout of a graph: each node right of all that it reads, with few crossings and space for edges between.
//!
//! An edge that spans several columns has a slot in each, so that it passes between nodes.
//! Columns are ordered by the middle of their neighbours, sweep after sweep; the same graph gives the same places.

/// A position: column from the left, and height from the top in units of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// From 0.
    pub column: usize,
    /// Of its middle.
    pub down: f64,
}

/// A graph in its places.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Of each node.
    pub nodes: Vec<Place>,
    /// From node to node: both ends and the places in between.
    pub lines: Vec<(usize, usize, Vec<Place>)>,
    /// How many columns there are.
    pub columns: usize,
    /// Height of the tallest column, in units of a node.
    pub height: f64,
}

/// Height of a line's slot, in units of a node.
const SLOT: f64 = 0.3;
/// Height of a recording.
const SOURCE: f64 = 0.6;
/// Sweeps over all columns.
const SWEEPS: usize = 12;

/// An item of a column: a node, or the slot of an edge.
#[derive(Debug, Clone, PartialEq)]
struct Item {
    column: usize,
    node: Option<usize>,
    near: Vec<usize>,
}

/// Lays out nodes that read nodes before them, the first `sources` of them in a column of their own.
pub fn lay_out(reads: &[Vec<usize>], sources: usize) -> Layout {
    let columns = node_columns(reads, sources);
    let (items, chains) = edge_chains(reads, &columns);
    let count = columns.iter().max().map_or(0, |c| c + 1);
    let mut order: Vec<Vec<usize>> =
        (0..count).map(|c| (0..items.len()).filter(|&i| items[i].column == c).collect()).collect();
    for sweep in 0..SWEEPS {
        // columns are updated one after the other: two updated at once could exchange their order without end
        for step in 0..count {
            let column = if sweep.is_multiple_of(2) { step } else { count - 1 - step };
            let now = item_heights(&items, &order);
            sort_column(&items, &now, &mut order[column]);
        }
    }
    let heights = item_heights(&items, &order);
    let placement = |i: usize| Place { column: items[i].column, down: heights[i] };
    let tall = |column: &Vec<usize>| column.iter().map(|&i| item_size(&items[i])).sum::<f64>();
    Layout {
        nodes: (0..reads.len()).map(placement).collect(),
        lines: chains.into_iter().map(|(a, b, slots)| (a, b, slots.into_iter().map(placement).collect())).collect(),
        columns: count,
        height: order.iter().map(tall).fold(0.0, f64::max),
    }
}

/// One column after the last of what each node reads; recordings come first.
fn node_columns(reads: &[Vec<usize>], sources: usize) -> Vec<usize> {
    let mut columns: Vec<usize> = Vec::new();
    for (i, node) in reads.iter().enumerate() {
        let last = node.iter().map(|&r| columns[r]).max();
        columns.push(if i < sources { 0 } else { last.map_or(1, |c| c + 1) });
    }
    columns
}

type Chain = (usize, usize, Vec<usize>);

/// Nodes and the slots of long edges, and the slots of each edge.
fn edge_chains(reads: &[Vec<usize>], columns: &[usize]) -> (Vec<Item>, Vec<Chain>) {
    let node = |i: usize| Item { column: columns[i], node: Some(i), near: Vec::new() };
    let mut items: Vec<Item> = (0..reads.len()).map(node).collect();
    let mut chains = Vec::new();
    for (reader, input) in
        reads.iter().enumerate().flat_map(|(reader, node)| node.iter().map(move |&input| (reader, input)))
    {
        let (mut last, mut slots) = (input, Vec::new());
        for column in columns[input] + 1..columns[reader] {
            items.push(Item { column, node: None, near: vec![last] });
            let slot = items.len() - 1;
            items[last].near.push(slot);
            slots.push(slot);
            last = slot;
        }
        items[last].near.push(reader);
        items[reader].near.push(last);
        chains.push((input, reader, slots));
    }
    (items, chains)
}

fn item_size(item: &Item) -> f64 {
    match (item.node, item.column) {
        (None, _) => SLOT,
        (Some(_), 0) => SOURCE,
        (Some(_), _) => 1.0,
    }
}

/// The middle of each item, its column standing around zero.
fn item_heights(items: &[Item], order: &[Vec<usize>]) -> Vec<f64> {
    let mut heights = vec![0.0; items.len()];
    for column in order {
        let mut top = -0.5 * column.iter().map(|&i| item_size(&items[i])).sum::<f64>();
        for &i in column {
            heights[i] = top + 0.5 * item_size(&items[i]);
            top += item_size(&items[i]);
        }
    }
    heights
}

/// Orders a column by the mean height of each item's neighbours.
fn sort_column(items: &[Item], heights: &[f64], column: &mut [usize]) {
    let mean = |i: usize| match items[i].near.len() {
        0 => heights[i],
        count => items[i].near.iter().map(|&n| heights[n]).sum::<f64>() / count as f64,
    };
    column.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_right_of_what_it_reads_and_none_overlaps() {
        let reads = vec![vec![], vec![], vec![0], vec![1, 2], vec![0, 3], vec![1]];
        let layout = lay_out(&reads, 2);
        for (i, node) in reads.iter().enumerate() {
            assert!(node.iter().all(|&r| layout.nodes[r].column < layout.nodes[i].column));
            let distance = |j: usize| (layout.nodes[i].down - layout.nodes[j].down).abs();
            let neighbours = (0..i).filter(|&j| layout.nodes[j].column == layout.nodes[i].column);
            // recordings stand closer than stages do
            assert!(neighbours.into_iter().all(|j| distance(j) > SOURCE - 1e-9), "{layout:?}");
        }
    }

    #[test]
    fn a_long_line_has_a_slot_in_every_column_on_its_way() {
        let layout = lay_out(&[vec![], vec![0], vec![1], vec![0, 2]], 1);
        let (_, _, slots) = layout.lines.iter().find(|(input, reader, _)| (*input, *reader) == (0, 3)).unwrap();
        assert_eq!(slots.iter().map(|p| p.column).collect::<Vec<_>>(), [1, 2]);
    }

    #[test]
    fn two_lines_that_need_not_cross_do_not() {
        // nodes 2 and 3 read 1 and 0: listed crosswise
        let layout = lay_out(&[vec![], vec![], vec![1], vec![0]], 2);
        let height = |i: usize| layout.nodes[i].down;
        assert!((height(0) - height(1)) * (height(3) - height(2)) > 0.0, "{layout:?}");
    }
}
