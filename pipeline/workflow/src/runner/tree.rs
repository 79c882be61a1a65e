//! The plan as a tree: each stage under the last one that it reads, with how many of its records would be kept or made.

use std::collections::BTreeMap;

use super::plan::Share;
use crate::stage_graph::StageGraph;

/// The tree's lines so far, and what each node prints.
struct Tree<'a> {
    graph: &'a StageGraph,
    direct: Vec<Vec<usize>>,
    children: BTreeMap<usize, Vec<usize>>,
    shares: &'a BTreeMap<&'static str, Share>,
    lines: Vec<String>,
}

/// One line a recording or stage.
pub(crate) fn tree_text(graph: &StageGraph, shares: &BTreeMap<&'static str, Share>) -> String {
    let direct = graph.direct_inputs();
    let mut children: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, reads) in direct.iter().enumerate() {
        if let Some(parent) = reads.iter().max() {
            children.entry(*parent).or_default().push(node);
        }
    }
    let roots: Vec<usize> = (0..graph.nodes.len()).filter(|node| direct[*node].is_empty()).collect();
    let mut tree = Tree { graph, direct, children, shares, lines: Vec::new() };
    for root in roots {
        let label = tree.node_label(root);
        tree.lines.push(label);
        tree.add_branch(root, "");
    }
    tree.lines.join("\n")
}

impl Tree<'_> {
    fn add_branch(&mut self, node: usize, indent: &str) {
        let children = self.children.get(&node).cloned().unwrap_or_default();
        for (i, child) in children.iter().enumerate() {
            let last = i + 1 == children.len();
            let label = self.node_label(*child);
            self.lines.push(format!("{indent}{} {label}", if last { "└─" } else { "├─" }));
            self.add_branch(*child, &format!("{indent}{} ", if last { "  " } else { "│ " }));
        }
    }

    /// Its name, its share of records, and what it reads beside the node above it.
    fn node_label(&self, node: usize) -> String {
        let name = &self.graph.nodes[node].name;
        let share = self.shares.get(name.as_str()).map_or_else(String::new, |share| format!("  {}", share.in_words()));
        let parent = self.direct[node].iter().max();
        let other_inputs = self.direct[node].iter().filter(|read| Some(*read) != parent);
        let other_inputs: Vec<&str> = other_inputs.map(|read| self.graph.nodes[*read].name.as_str()).collect();
        let other_inputs =
            if other_inputs.is_empty() { String::new() } else { format!("  (also reads {})", other_inputs.join(", ")) };
        format!("{name}{share}{other_inputs}")
    }
}
