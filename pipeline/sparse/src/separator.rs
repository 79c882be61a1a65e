//! Vertex separators: of three parts of a graph one keeps the other two apart, and moves of single nodes make it smaller [fiduccia1982].

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Passes over the separator at most; one that gains nothing is the last.
const PASSES: usize = 6;
/// Moves without a gain after which a pass ends: a separator may have to move by a layer of nodes before it shrinks.
const PATIENCE: usize = 120;
/// Largest part of the nodes on one side that a move may lead to.
const LARGEST_SIDE: f64 = 0.6;

/// Neighbours of each node within a set, numbered in the set.
pub(crate) struct Subgraph {
    pub starts: Vec<usize>,
    pub neighbours: Vec<u32>,
}

impl Subgraph {
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn neighbours_of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.starts[node as usize]..self.starts[node as usize + 1]]
    }
}

/// Where a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Part {
    First,
    Second,
    Separator,
}

impl Part {
    fn opposite_side(self) -> Self {
        if self == Self::First { Self::Second } else { Self::First }
    }
}

/// The part of each node, and the number of nodes in each part.
#[derive(Debug, Clone)]
pub(crate) struct Partition {
    pub parts: Vec<Part>,
    sizes: [usize; 3],
}

impl Partition {
    pub(crate) fn new(parts: Vec<Part>) -> Self {
        let size = |part: Part| parts.iter().filter(|own| **own == part).count();
        let sizes = [Part::First, Part::Second, Part::Separator].map(size);
        Self { parts, sizes }
    }

    /// Nodes of the separator, more of them the more the sides differ: what a plane of nodes costs in the factor.
    pub(crate) fn factor_cost(&self) -> f64 {
        let [first, second, separator] = self.sizes;
        let share = first.max(second) as f64 / (first + second).max(1) as f64;
        separator_cost(separator, share)
    }

    /// Makes the separator smaller, as long as that is found to be possible.
    pub(crate) fn refine_separator(&mut self, graph: &Subgraph) {
        for _ in 0..PASSES {
            if !Pass::new(graph, self).shrinks_separator() {
                return;
            }
        }
    }

    fn move_node(&mut self, node: u32, part: Part) {
        let own = &mut self.parts[node as usize];
        self.sizes[*own as usize] -= 1;
        self.sizes[part as usize] += 1;
        *own = part;
    }

    /// What a pass makes smaller: the separator, then the difference of the sides.
    fn objective(&self) -> (usize, usize) {
        (self.sizes[2], self.sizes[0].abs_diff(self.sizes[1]))
    }
}

/// The cost of a separator beside which the larger side has this `share` of the other nodes.
// For half of a thin tail in hexahedra 1 + ½ |share − ½| took 3 % more work in the factor, twice this price 2 % more.
pub(crate) fn separator_cost(nodes: usize, share: f64) -> f64 {
    nodes as f64 * (1.0 + 4.0 * (share - 0.5).powi(2))
}

/// A move of a node from the separator to a side, and the nodes of the other side that it pulled into the separator.
struct Move {
    node: u32,
    side: Part,
    pulled: Vec<u32>,
}

/// Moves in the order of their gains, each node once; in the end those after the smallest separator are undone.
struct Pass<'a> {
    graph: &'a Subgraph,
    partition: &'a mut Partition,
    /// Gain, node and side; of equal gains the lower node first. Gains are of the time when they were entered.
    candidates: BinaryHeap<(i32, Reverse<u32>, Part)>,
    has_moved: Vec<bool>,
    moves: Vec<Move>,
}

impl<'a> Pass<'a> {
    fn new(graph: &'a Subgraph, partition: &'a mut Partition) -> Self {
        let separator = (0..graph.len() as u32)
            .filter(|node| partition.parts[*node as usize] == Part::Separator)
            .collect::<Vec<_>>();
        let (candidates, has_moved) = (BinaryHeap::new(), vec![false; graph.len()]);
        let mut pass = Self { graph, partition, candidates, has_moved, moves: Vec::new() };
        separator.into_iter().for_each(|node| pass.enter_candidates(node));
        pass
    }

    /// Makes the pass; whether the separator is smaller.
    fn shrinks_separator(mut self) -> bool {
        let size = self.partition.sizes[2];
        let (mut best, mut kept) = (self.partition.objective(), 0);
        while let Some((node, side)) = self.next_move() {
            self.apply_move(node, side);
            let objective = self.partition.objective();
            if objective < best {
                (best, kept) = (objective, self.moves.len());
            } else if self.moves.len() - kept > PATIENCE {
                break;
            }
        }
        while self.moves.len() > kept {
            self.undo_last();
        }
        self.partition.sizes[2] < size
    }

    /// Nodes that leave the separator, less those that enter it.
    fn separator_gain(&self, node: u32, side: Part) -> i32 {
        1 - self.nodes_behind(node, side).count() as i32
    }

    /// The neighbours of a node on the side opposite to `side`.
    fn nodes_behind(&self, node: u32, side: Part) -> impl Iterator<Item = u32> {
        let parts = &self.partition.parts;
        let neighbours = self.graph.neighbours_of(node).iter().copied();
        neighbours.filter(move |next| parts[*next as usize] == side.opposite_side())
    }

    fn enter_candidates(&mut self, node: u32) {
        for side in [Part::First, Part::Second] {
            self.candidates.push((self.separator_gain(node, side), Reverse(node), side));
        }
    }

    /// The best move that is still open.
    fn next_move(&mut self) -> Option<(u32, Part)> {
        let most = LARGEST_SIDE * self.graph.len() as f64;
        while let Some((gain, Reverse(node), side)) = self.candidates.pop() {
            if self.has_moved[node as usize] || self.partition.parts[node as usize] != Part::Separator {
                continue;
            }
            let present_gain = self.separator_gain(node, side);
            if present_gain != gain {
                self.candidates.push((present_gain, Reverse(node), side));
            } else if (self.partition.sizes[side as usize] as f64) < most {
                return Some((node, side));
            }
        }
        None
    }

    fn apply_move(&mut self, node: u32, side: Part) {
        let pulled: Vec<u32> = self.nodes_behind(node, side).collect();
        self.has_moved[node as usize] = true;
        self.partition.move_node(node, side);
        pulled.iter().for_each(|next| self.partition.move_node(*next, Part::Separator));
        for &next in self.graph.neighbours_of(node) {
            if self.partition.parts[next as usize] == Part::Separator && !self.has_moved[next as usize] {
                self.enter_candidates(next);
            }
        }
        self.moves.push(Move { node, side, pulled });
    }

    fn undo_last(&mut self) {
        let Some(Move { node, side, pulled }) = self.moves.pop() else { return };
        pulled.into_iter().for_each(|next| self.partition.move_node(next, side.opposite_side()));
        self.partition.move_node(node, Part::Separator);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Grid;

    #[test]
    fn a_slanted_separator_becomes_a_plane_and_keeps_its_sides_apart() {
        let mesh = Grid::new([16, 4, 4]);
        let neighbours = mesh.graph();
        let mut graph = Subgraph { starts: vec![0], neighbours: Vec::new() };
        for node in 0..neighbours.len() as u32 {
            graph.neighbours.extend(neighbours.neighbours_of(node));
            graph.starts.push(graph.neighbours.len());
        }
        let [long, wide] = [0, 1].map(|axis| mesh.nodes.iter().fold(0.0, |most: f64, at| most.max(at[axis])));
        let is_first: Vec<bool> = mesh.nodes.iter().map(|at| at[0] / long + 0.3 * at[1] / wide < 0.65).collect();
        let part_of = |node: usize| match is_first[node] {
            false => Part::Second,
            true if neighbours.neighbours_of(node as u32).iter().any(|next| !is_first[*next as usize]) => {
                Part::Separator
            }
            true => Part::First,
        };
        let mut partition = Partition::new((0..is_first.len()).map(part_of).collect());
        let (size, cost) = (partition.sizes[2], partition.factor_cost());
        partition.refine_separator(&graph);
        assert!(
            size > 40 && partition.sizes[2] == 25 && partition.factor_cost() < cost,
            "{size} {:?}",
            partition.sizes
        );
        assert_eq!(partition.sizes, Partition::new(partition.parts.clone()).sizes);
        for node in (0..graph.len() as u32).filter(|node| partition.parts[*node as usize] == Part::First) {
            let next_parts = graph.neighbours_of(node).iter().map(|next| partition.parts[*next as usize]);
            assert!(next_parts.into_iter().all(|part| part != Part::Second));
        }
    }
}
