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
pub fn text(graph: &StageGraph, shares: &BTreeMap<&'static str, Share>) -> String {
    let direct = graph.direct();
    let mut children: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, reads) in direct.iter().enumerate() {
        if let Some(parent) = reads.iter().max() {
            children.entry(*parent).or_default().push(node);
        }
    }
    let roots: Vec<usize> = (0..graph.nodes.len()).filter(|node| direct[*node].is_empty()).collect();
    let mut tree = Tree { graph, direct, children, shares, lines: Vec::new() };
    for root in roots {
        let label = tree.label(root);
        tree.lines.push(label);
        tree.branch(root, "");
    }
    tree.lines.join("\n")
}

impl Tree<'_> {
    fn branch(&mut self, of: usize, indent: &str) {
        let own = self.children.get(&of).cloned().unwrap_or_default();
        for (i, child) in own.iter().enumerate() {
            let last = i + 1 == own.len();
            let label = self.label(*child);
            self.lines.push(format!("{indent}{} {label}", if last { "└─" } else { "├─" }));
            self.branch(*child, &format!("{indent}{} ", if last { "  " } else { "│ " }));
        }
    }

    /// Its name, its share of records, and what it reads beside the node above it.
    fn label(&self, node: usize) -> String {
        let name = &self.graph.nodes[node].name;
        let share = self.shares.get(name.as_str()).map_or_else(String::new, |share| format!("  {}", share.in_words()));
        let parent = self.direct[node].iter().max();
        let others = self.direct[node].iter().filter(|read| Some(*read) != parent);
        let others: Vec<&str> = others.map(|read| self.graph.nodes[*read].name.as_str()).collect();
        let others = if others.is_empty() { String::new() } else { format!("  (also reads {})", others.join(", ")) };
        format!("{name}{share}{others}")
    }
}
