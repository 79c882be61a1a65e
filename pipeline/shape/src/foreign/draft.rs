//! Drafts: what a file of tetrahedra says, before anything of it is believed.
//!
//! Stands on: `si`. Never knows: which format it came from.

use si::Point3;
use std::collections::BTreeMap;

/// A file that is not what its format asks for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}{what}\n  why: {why}\n  do:  {act}")]
pub struct Malformed {
    /// Where in the file, with a colon and a space behind it; empty for the whole of it.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What was expected.
    pub why: String,
    /// The next move.
    pub act: String,
}

impl Malformed {
    pub(super) fn new(what: impl Into<String>, why: impl Into<String>, act: impl Into<String>) -> Self {
        Self { place: String::new(), what: what.into(), why: why.into(), act: act.into() }
    }

    pub(super) fn at(mut self, place: impl Into<String>) -> Self {
        self.place = place.into();
        self
    }
}

/// Nodes and tetrahedra as a file gives them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Draft {
    /// Node positions, in the file's unit.
    pub nodes: Vec<Point3>,
    /// The file's own number of each node.
    pub node_labels: Vec<u64>,
    /// Nodes of all tetrahedra, one tetrahedron after the other, in the house's order.
    pub corners: Vec<u32>,
    /// Nodes a tetrahedron: 4 or 10; 0 before the first.
    pub each: usize,
    /// The file's own number of each tetrahedron.
    pub labels: Vec<u64>,
    /// The tag of each tetrahedron: physical group, cell data, reference or attribute; 0 where the file has none.
    pub tags: Vec<i64>,
    /// What the file calls a tag.
    pub names: BTreeMap<i64, String>,
    /// Points, lines and faces that were passed over.
    pub passed_over: usize,
}

impl Draft {
    /// Adds a node.
    pub(super) fn node(&mut self, label: u64, at: Point3) {
        self.nodes.push(at);
        self.node_labels.push(label);
    }

    /// Adds a tetrahedron of 4 or 10 nodes.
    ///
    /// # Errors
    /// [`Malformed`] when those before it have another number of nodes, or a node is not there.
    pub(super) fn tetrahedron(&mut self, label: u64, nodes: &[u32], tag: i64) -> Result<(), Malformed> {
        if self.each != 0 && self.each != nodes.len() {
            let what = format!("element {label} has {} nodes where those before it have {}", nodes.len(), self.each);
            return Err(Malformed::new(
                what,
                "a mesh is of one order",
                "save it with 4-node or with 10-node tetrahedra alone",
            ));
        }
        if let Some(node) = nodes.iter().find(|&&node| node as usize >= self.nodes.len()) {
            let what = format!("element {label} names the node at place {node}");
            let why = format!("the file has {} nodes, counted here from 0", self.nodes.len());
            return Err(Malformed::new(what, why, "save the mesh again; the file was cut or edited"));
        }
        self.each = nodes.len();
        self.corners.extend(nodes);
        self.labels.push(label);
        self.tags.push(tag);
        Ok(())
    }

    /// How many tetrahedra there are.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// Nodes of one tetrahedron.
    pub fn element(&self, element: usize) -> &[u32] {
        &self.corners[element * self.each..(element + 1) * self.each]
    }
}

/// A solid that is no tetrahedron.
pub(super) fn other_solid(name: &str) -> Malformed {
    let what = format!("the file has {name}");
    Malformed::new(what, "tetrahedra of 4 or 10 nodes are simulated", "mesh the solid with tetrahedra of order 1 or 2")
}

/// Ten nodes in the house's order: the file's places of corners and of the middles of 01, 12, 02, 03, 13, 23.
pub(super) fn reordered(nodes: &[u32], places: &[usize; 10]) -> Vec<u32> {
    if nodes.len() == 10 { places.iter().map(|&place| nodes[place]).collect() } else { nodes.to_vec() }
}
