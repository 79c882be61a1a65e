//! The stage graph: which stage reads what, laid out in columns for the figure and the page.

mod layers;

use std::collections::BTreeSet;

use serde::Serialize;

use crate::entry::Entry;

pub use layers::{Layout, Place, lay_out};

/// A node: a kind of recording, or a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Node {
    /// Its name.
    pub name: String,
    /// Its description; empty for recordings.
    pub description: String,
    /// The nodes that it reads, by number; all come before it.
    pub reads: Vec<usize>,
}

/// All nodes, recordings first, then stages in the order of the data.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct StageGraph {
    /// The nodes.
    pub nodes: Vec<Node>,
    /// How many of them are recordings.
    pub recordings: usize,
}

impl StageGraph {
    /// The graph of these stages in a project; stages without a subject in it are left out.
    pub fn of<U>(universe: &U, stages: &[Entry<U>]) -> Self {
        let live: Vec<&Entry<U>> = stages.iter().filter(|entry| !(entry.subjects)(universe).is_empty()).collect();
        let reads: Vec<_> = live.iter().map(|entry| (entry.reads)(universe)).collect();
        let kinds: Vec<String> = reads.iter().map(|r| raw_kinds(&r.raw)).collect();
        let mut recordings: Vec<String> = Vec::new();
        for words in kinds.iter().filter(|words| !words.is_empty()) {
            if !recordings.contains(words) {
                recordings.push(words.clone());
            }
        }
        let source = |words: &String| recordings.iter().position(|r| r == words);
        let stage = |name: &&str| live.iter().position(|e| e.name == *name).map(|i| recordings.len() + i);
        let nodes = live.iter().zip(&reads).zip(&kinds).map(|((entry, reads), words)| Node {
            name: entry.name.into(),
            description: entry.description.into(),
            reads: source(words).into_iter().chain(reads.stages.iter().filter_map(stage)).collect(),
        });
        let first = recordings.iter().map(|r| Node { name: r.clone(), description: String::new(), reads: Vec::new() });
        Self { nodes: first.chain(nodes).collect(), recordings: recordings.len() }
    }

    /// The direct inputs of each node without those implied by others (transitive reduction).
    pub fn direct_inputs(&self) -> Vec<Vec<usize>> {
        let ancestors = self.all_ancestors();
        let through = |reads: &[usize], input: usize| reads.iter().any(|&read| ancestors[read].contains(&input));
        let direct = |node: &Node| node.reads.iter().copied().filter(|&input| !through(&node.reads, input)).collect();
        self.nodes.iter().map(direct).collect()
    }

    /// All ancestors of each node.
    fn all_ancestors(&self) -> Vec<BTreeSet<usize>> {
        let mut ancestors: Vec<BTreeSet<usize>> = Vec::new();
        for node in &self.nodes {
            let parents: BTreeSet<usize> = node.reads.iter().copied().filter(|&i| i < ancestors.len()).collect();
            let inherited = parents.iter().flat_map(|&i| ancestors[i].iter().copied()).collect::<BTreeSet<usize>>();
            ancestors.push(parents.union(&inherited).copied().collect());
        }
        ancestors
    }
}

/// The words of a stage's recordings, without of what each is.
fn raw_kinds(raw: &BTreeSet<String>) -> String {
    let kinds: BTreeSet<&str> = raw.iter().filter_map(|word| word.split(" of ").next()).collect();
    kinds.into_iter().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, reads: &[usize]) -> Node {
        Node { name: name.into(), description: String::new(), reads: reads.to_vec() }
    }

    #[test]
    fn an_edge_implied_by_others_is_not_drawn() {
        let nodes = vec![node("film", &[]), node("track", &[0]), node("clock", &[0, 1]), node("fit", &[1, 2])];
        let graph = StageGraph { nodes, recordings: 1 };
        assert_eq!(graph.direct_inputs(), [vec![], vec![0], vec![1], vec![2]]);
    }
}
