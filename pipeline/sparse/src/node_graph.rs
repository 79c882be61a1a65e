//! The node graph of a mesh: which nodes share an element.

use std::collections::{BTreeMap, BTreeSet};

/// Neighbours of each node, in rising order, itself not among them.
#[derive(Debug)]
pub struct NodeGraph {
    start: Vec<usize>,
    neighbours: Vec<u32>,
}

impl NodeGraph {
    /// From the elements between `nodes` nodes: the nodes of one element after those of the other, `each` of them.
    pub fn new(nodes: usize, elements: &[u32], each: usize) -> Self {
        let incidence = elements_at(nodes, elements, each);
        let mut graph = Self { start: vec![0], neighbours: Vec::new() };
        let mut adjacent: Vec<u32> = Vec::new();
        for node in 0..nodes {
            adjacent.clear();
            for &element in &incidence.neighbours[incidence.start[node]..incidence.start[node + 1]] {
                adjacent.extend_from_slice(&elements[each * element as usize..each * (element as usize + 1)]);
            }
            adjacent.sort_unstable();
            adjacent.dedup();
            graph.neighbours.extend(adjacent.iter().filter(|&&neighbour| neighbour as usize != node));
            graph.start.push(graph.neighbours.len());
        }
        graph
    }

    /// The same with the pairs of `further` as neighbours too.
    pub fn with_edges(&self, further: &BTreeSet<(u32, u32)>) -> Self {
        let mut added: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &(a, b) in further.iter().filter(|(a, b)| a != b) {
            added.entry(a).or_default().push(b);
            added.entry(b).or_default().push(a);
        }
        let mut graph = Self { start: vec![0], neighbours: Vec::new() };
        for node in 0..self.len() as u32 {
            let mut adjacent = self.neighbours_of(node).to_vec();
            adjacent.extend(added.get(&node).into_iter().flatten());
            adjacent.sort_unstable();
            adjacent.dedup();
            graph.neighbours.extend(adjacent);
            graph.start.push(graph.neighbours.len());
        }
        graph
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether it has no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The nodes that share an element with `node`.
    pub fn neighbours_of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.start[node as usize]..self.start[node as usize + 1]]
    }
}

/// Elements at each node, in the same compressed form.
fn elements_at(nodes: usize, elements: &[u32], each: usize) -> NodeGraph {
    let mut start = vec![0; nodes + 1];
    elements.iter().for_each(|&node| start[node as usize + 1] += 1);
    for node in 0..nodes {
        start[node + 1] += start[node];
    }
    let mut next = start.clone();
    let mut list = vec![0; start[nodes]];
    for (element, corners) in elements.chunks_exact(each).enumerate() {
        for &node in corners {
            list[next[node as usize]] = element as u32;
            next[node as usize] += 1;
        }
    }
    NodeGraph { start, neighbours: list }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nodes_of_an_element_are_neighbours_and_none_is_its_own() {
        let graph = NodeGraph::new(5, &[0, 1, 2, 2, 3, 1], 3);
        assert_eq!((graph.len(), graph.is_empty()), (5, false));
        assert_eq!(
            [0, 1, 2, 3, 4].map(|node| graph.neighbours_of(node).to_vec()),
            [vec![1, 2], vec![0, 2, 3], vec![0, 1, 3], vec![1, 2], vec![]]
        );
        assert!(NodeGraph::new(0, &[], 3).is_empty());
    }

    #[test]
    fn further_edges_join_both_of_their_nodes_once() {
        let graph = NodeGraph::new(5, &[0, 1, 2, 2, 3, 1], 3);
        let graph = graph.with_edges(&[(0, 4), (1, 2), (3, 3), (0, 3)].into());
        assert_eq!(
            [0, 1, 2, 3, 4].map(|node| graph.neighbours_of(node).to_vec()),
            [vec![1, 2, 3, 4], vec![0, 2, 3], vec![0, 1, 3], vec![0, 1, 2], vec![0]]
        );
    }
}
