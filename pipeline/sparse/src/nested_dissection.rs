//! Elimination order: nested dissection [george1973], then a postorder of the elimination tree.
//!
//! A set of nodes is split by a plane across one axis. The nodes of one side that touch the other are the separator, which moves of single nodes make
//! smaller ([`crate::separator`]); it is eliminated last, and both sides are ordered in the same way, down to small sets. Every position of
//! the plane along all three axes is looked at: between two layers of 20-node hexahedra, or in a thin place, a separator has fewer nodes
//! than a little beside.
//!
//! Work in the factor, 10⁹ multiplications and additions, beside METIS 5.1, whose generator of random numbers is the process's own, so that
//! threads would disturb each other's order:
//!
//! | mesh                                              | seven planes | every plane | refined | METIS |
//! |---------------------------------------------------|--------------|-------------|---------|-------|
//! | half of a thin tail, 20-node hexahedra, 36 530 dofs | 10.3       | 6.4         | 6.2     | 6.8   |
//! | the same, 10-node tetrahedra, 45 528 dofs         | 21.1         | 11.9        | 10.7    | 10.3  |
//! | half-round bar, 10-node tetrahedra, 24 321 dofs   | 5.4          | 4.1         | 2.5     | 2.3   |
//! | pneu-net, 20-node hexahedra, 32 442 dofs          | 8.8          | 7.5         | 6.7     | 5.6   |

use crate::node_graph::NodeGraph;
use crate::separator::{Part, Partition, Subgraph, separator_cost};
use si::{Metre, Point3};

/// Sets of this many nodes are not split further: their fronts are small enough to be dense.
const SMALLEST: usize = 24;
/// The smaller side of a plane has at least this part of the nodes.
const LEAST_SIDE: f64 = 0.3;

/// The `active` nodes in elimination order.
///
/// `positions`: nodes, m. `active`: node numbers; other nodes of the graph are skipped.
pub(crate) fn elimination_order(positions: &[Point3], graph: &NodeGraph, active: Vec<u32>) -> Vec<u32> {
    let mut dissection = Dissection { positions, graph, number: vec![OUTSIDE; graph.len()], order: Vec::new() };
    dissection.dissect_set(active);
    tree_postorder(graph, dissection.order)
}

const OUTSIDE: u32 = u32::MAX;

struct Dissection<'a> {
    positions: &'a [Point3],
    graph: &'a NodeGraph,
    /// Of each node in the set that is being split.
    number: Vec<u32>,
    order: Vec<u32>,
}

impl Dissection<'_> {
    fn dissect_set(&mut self, set: Vec<u32>) {
        if set.len() <= SMALLEST {
            self.order.extend(set);
            return;
        }
        let graph = self.subgraph_of(&set);
        // Slender bodies are mostly split across their length, but not near ribs and sheets: all axes are compared.
        let refined = (0..3).map(|axis| {
            let mut partition = self.plane_partition(&set, &graph, axis);
            partition.refine_separator(&graph);
            partition
        });
        let Some(best) = refined.min_by(|a, b| a.factor_cost().total_cmp(&b.factor_cost())) else { return };
        let nodes_in = |part: Part| -> Vec<u32> {
            set.iter().zip(&best.parts).filter(|(_, own)| **own == part).map(|(node, _)| *node).collect()
        };
        let [first, second, separator] = [Part::First, Part::Second, Part::Separator].map(nodes_in);
        if first.len().max(second.len()) == set.len() {
            // no plane divides it
            self.order.extend(set);
            return;
        }
        self.dissect_set(first);
        self.dissect_set(second);
        self.order.extend(separator);
    }

    fn subgraph_of(&mut self, set: &[u32]) -> Subgraph {
        set.iter().enumerate().for_each(|(number, &node)| self.number[node as usize] = number as u32);
        let mut subgraph = Subgraph { starts: vec![0], neighbours: Vec::new() };
        for &node in set {
            let numbers = self.graph.neighbours_of(node).iter().map(|&next| self.number[next as usize]);
            subgraph.neighbours.extend(numbers.filter(|number| *number != OUTSIDE));
            subgraph.starts.push(subgraph.neighbours.len());
        }
        set.iter().for_each(|&node| self.number[node as usize] = OUTSIDE);
        subgraph
    }

    /// The cheapest plane across an axis, with the nodes of one of its sides that touch the other as separator.
    fn plane_partition(&self, set: &[u32], graph: &Subgraph, axis: usize) -> Partition {
        let along = |number: u32| -> Metre { self.positions[set[number as usize] as usize][axis] };
        let mut sorted: Vec<u32> = (0..set.len() as u32).collect();
        sorted.sort_unstable_by(|&a, &b| along(a).total_cmp(&along(b)).then(set[a as usize].cmp(&set[b as usize])));
        let mut rank = vec![0; set.len()];
        sorted.iter().enumerate().for_each(|(place, &number)| rank[number as usize] = place);
        let reaches: Vec<[usize; 2]> = sorted.iter().map(|&number| rank_reach(graph, &rank, number)).collect();
        let (cut, is_first) = cheapest_cut(&reaches);
        let mut parts = vec![Part::First; set.len()];
        for (place, (&number, [low, high])) in sorted.iter().zip(reaches).enumerate() {
            let touches = if place < cut { is_first && high >= cut } else { !is_first && low < cut };
            let side = if place < cut { Part::First } else { Part::Second };
            parts[number as usize] = if touches { Part::Separator } else { side };
        }
        Partition::new(parts)
    }
}

/// The least and the greatest rank among a node and its neighbours.
fn rank_reach(graph: &Subgraph, rank: &[usize], number: u32) -> [usize; 2] {
    let own = rank[number as usize];
    let ranks = graph.neighbours_of(number).iter().map(|&next| rank[next as usize]);
    ranks.fold([own; 2], |[low, high], rank| [low.min(rank), high.max(rank)])
}

/// The number of nodes before the cheapest cut, and whether those before it that touch the others are fewer.
fn cheapest_cut(reaches: &[[usize; 2]]) -> (usize, bool) {
    let count = reaches.len();
    // changes from each cut to the next of the nodes before it that reach beyond it, and of those behind it that reach before it
    let mut changes = vec![[0_isize; 2]; count + 2];
    for (place, [low, high]) in reaches.iter().enumerate() {
        changes[place + 1][0] += 1;
        changes[high + 1][0] -= 1;
        changes[low + 1][1] += 1;
        changes[place + 1][1] -= 1;
    }
    let least = ((LEAST_SIDE * count as f64) as usize).max(1);
    let mut best = (f64::INFINITY, count / 2, true);
    let mut touching = [0_isize; 2];
    for (cut, change) in changes.iter().enumerate().take(count - least + 1) {
        touching = [touching[0] + change[0], touching[1] + change[1]];
        let share = cut.max(count - cut) as f64 / count as f64;
        let cost = separator_cost(touching[0].min(touching[1]).unsigned_abs(), share);
        if cut >= least && cost < best.0 {
            best = (cost, cut, touching[0] <= touching[1]);
        }
    }
    (best.1, best.2)
}

/// The same elimination with the columns of every subtree consecutive.
// Postorder changes no fill; it lets the factorisation find supernodes and keeps columns near where they are used.
fn tree_postorder(graph: &NodeGraph, order: Vec<u32>) -> Vec<u32> {
    let parents = elimination_tree(graph, &order);
    let mut children = vec![Vec::new(); order.len()];
    let mut stack = Vec::new();
    for (column, parent) in parents.iter().enumerate().rev() {
        match parent {
            Some(parent) => children[*parent].push(column),
            None => stack.push(column),
        }
    }
    // Children were pushed from last to first, so popping visits them from last to first; the reverse is a postorder.
    let mut reversed = Vec::with_capacity(order.len());
    stack.reverse();
    while let Some(column) = stack.pop() {
        reversed.push(order[column]);
        stack.extend(children[column].iter().rev());
    }
    reversed.reverse();
    reversed
}

/// Parent of each column in the elimination tree of the graph under `order`.        [liu1986], algorithm 4.2
fn elimination_tree(graph: &NodeGraph, order: &[u32]) -> Vec<Option<usize>> {
    let mut rank = vec![usize::MAX; graph.len()];
    order.iter().enumerate().for_each(|(column, &node)| rank[node as usize] = column);
    let mut parent = vec![None; order.len()];
    let mut ancestor: Vec<Option<usize>> = vec![None; order.len()];
    for (column, &node) in order.iter().enumerate() {
        for &next in graph.neighbours_of(node) {
            let mut below = rank[next as usize];
            while below < column {
                match ancestor[below].replace(column) {
                    None => {
                        parent[below] = Some(column);
                        break;
                    }
                    Some(higher) if higher == column => break,
                    Some(higher) => below = higher,
                }
            }
        }
    }
    parent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Grid;

    /// Entries of the factor below the diagonal, by merging each column's structure into its parent's.
    fn fill(graph: &NodeGraph, order: &[u32]) -> usize {
        let parents = elimination_tree(graph, order);
        let mut rank = vec![usize::MAX; graph.len()];
        order.iter().enumerate().for_each(|(column, &node)| rank[node as usize] = column);
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); order.len()];
        let mut total = 0;
        for (column, &node) in order.iter().enumerate() {
            let mut rows = std::mem::take(&mut columns[column]);
            rows.extend(graph.neighbours_of(node).iter().map(|&next| rank[next as usize]));
            rows.retain(|&row| row > column && row != usize::MAX);
            rows.sort_unstable();
            rows.dedup();
            total += rows.len();
            if let Some(parent) = parents[column] {
                columns[parent].extend(&rows);
            }
        }
        total
    }

    #[test]
    fn every_active_node_is_eliminated_once_and_no_other() {
        let mesh = Grid::new([16, 4, 4]);
        let graph = mesh.graph();
        let active: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|node| node % 7 != 0).collect();
        let mut order = elimination_order(&mesh.nodes, &graph, active.clone());
        order.sort_unstable();
        assert_eq!(order, active);
    }

    #[test]
    fn each_subtree_is_numbered_consecutively_before_its_parent() {
        let mesh = Grid::new([6, 6, 6]);
        let graph = mesh.graph();
        let order = elimination_order(&mesh.nodes, &graph, (0..mesh.nodes.len() as u32).collect());
        let parents = elimination_tree(&graph, &order);
        let mut size = vec![1; order.len()];
        let mut first: Vec<usize> = (0..order.len()).collect();
        for column in 0..order.len() {
            assert_eq!(first[column] + size[column], column + 1, "the subtree of {column} is consecutive");
            if let Some(parent) = parents[column] {
                assert!(parent > column);
                size[parent] += size[column];
                first[parent] = first[parent].min(first[column]);
            }
        }
    }

    #[test]
    fn nested_dissection_fills_less_than_half_as_much_as_the_natural_order() {
        let mesh = Grid::new([22, 22, 22]);
        let graph = mesh.graph();
        let natural: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
        let order = elimination_order(&mesh.nodes, &graph, natural.clone());
        assert!(2 * fill(&graph, &order) < fill(&graph, &natural));
    }
}
