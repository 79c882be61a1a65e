//! Defects of a mesh that make a simulation impossible. Numbers of nodes and elements are those of the file.

use crate::surface::place_text;
use si::{CubicMetre, Metre, Point3};

/// A defect of a mesh that could be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshDefect {
    /// No tetrahedra.
    #[error(
        "the file has no tetrahedra\n  why: a solid needs at least one; {ignored} points, lines and faces are not read\n  do:  mesh the volume and save it, not the surface alone"
    )]
    Empty {
        /// Other elements.
        ignored: usize,
    },
    /// A coordinate that is not finite.
    #[error("node {node} lies at ({}, {}, {})\n  why: every coordinate must be a finite number\n  do:  check the file at this node", .at[0], .at[1], .at[2])]
    NotFinite {
        /// Which node.
        node: u64,
        /// Where it lies, in the file's unit.
        at: Point3,
    },
    /// An implausible size.
    #[error("the mesh is {size:.3e} m long when its numbers are read as {}\n  why: bodies between 0.0001 m and 10 m are simulated\n  do:  set unit = \"{}\" if the file was written so, or scale it", unit_of(*.unit), if *.size > 10.0 { "mm" } else { "m" })]
    Size {
        /// Longest side of its box, m.
        size: Metre,
        /// One of the file's unit, m.
        unit: Metre,
    },
    /// Four corners in one plane.
    #[error(
        "element {element} at {} is flat: its volume is {volume:.3e} m³, {ratio:.1e} of its longest edge cubed\n  why: the limit is 1e-7\n  do:  optimise the mesh, or mesh anew", place_text(.at)
    )]
    DegenerateElement {
        /// Which element.
        element: u64,
        /// A corner of it, m.
        at: Point3,
        /// Its volume, m³.
        volume: CubicMetre,
        /// Volume over the cube of the longest edge.
        ratio: f64,
    },
    /// An inverted element.
    #[error(
        "element {element} is inverted: its volume is {volume:.3e} m³, and its determinant falls to {least:.3e} m³\n  why: the determinant must be positive everywhere, as in the other elements\n  do:  mesh anew; of a 10-node element, check that its middle nodes are in the format's order and on their edges"
    )]
    InvertedElement {
        /// Which element.
        element: u64,
        /// Its volume, m³.
        volume: CubicMetre,
        /// Least determinant, m³.
        least: f64,
    },
    /// The same element twice.
    #[error(
        "element {second} has the corners of element {first}\n  why: one of them would count twice\n  do:  remove one; volumes that overlap are often saved so"
    )]
    DuplicateElement {
        /// The first one.
        first: u64,
        /// The other one.
        second: u64,
    },
    /// Two middle nodes on one edge.
    #[error("the edge {}-{} has the middle nodes {first} and {second}\n  why: elements that share an edge share its middle node\n  do:  merge nodes that lie at the same place", .edge[0], .edge[1])]
    SplitEdge {
        /// Its ends.
        edge: [u64; 2],
        /// The middle node of one element.
        first: u64,
        /// And of another.
        second: u64,
    },
    /// Nodes at the same place.
    #[error(
        "nodes {first} and {second} lie at the same place, one of {count} such pairs\n  why: the parts that meet there would not be connected\n  do:  merge them (gmsh: Coherence, or fragment the volumes before meshing)"
    )]
    CoincidentNodes {
        /// One node.
        first: u64,
        /// Another.
        second: u64,
        /// Pairs in the mesh.
        count: usize,
    },
    /// A face of more than two elements, or of two on its same side.
    #[error("the face {}-{}-{} belongs to {count} elements, among them {first} and {second}\n  why: a face has one element on each side\n  do:  remove what overlaps, or mesh anew", .face[0], .face[1], .face[2])]
    NonManifoldFace {
        /// Its corners.
        face: [u64; 3],
        /// How many elements share it.
        count: usize,
        /// One of them.
        first: u64,
        /// Another.
        second: u64,
    },
    /// An edge of the skin with other than two faces.
    #[error("the edge {}-{} of the skin joins {count} faces\n  why: in a closed skin it joins 2; parts that touch along an edge only leave a chamber open\n  do:  join the parts over a face, or separate them", .edge[0], .edge[1])]
    NonManifoldEdge {
        /// Its ends.
        edge: [u64; 2],
        /// How many faces of the skin it joins.
        count: usize,
    },
    /// A half model below its plane.
    #[error(
        "node {node} of the half model lies at z = {z:.3e} m\n  why: a half model lies at z ≥ 0\n  do:  cut the mesh at z = 0, or set half = false"
    )]
    BelowPlane {
        /// Which node.
        node: u64,
        /// Its height, m.
        z: Metre,
    },
    /// A half model without faces on its plane.
    #[error(
        "the half model has no face on z = 0\n  why: its other half begins there\n  do:  move the mesh so that it is cut at z = 0, or set half = false"
    )]
    NoSymmetryPlane,
    /// A node that an element names twice.
    #[error(
        "element {element} names node {node} twice\n  why: each corner is a node of its own; wedges and pyramids are not simulated\n  do:  mesh with tetrahedra or with whole hexahedra"
    )]
    RepeatedNode {
        /// Which element.
        element: u64,
        /// The node.
        node: u64,
    },
    /// One name for two tags.
    #[error(
        "the tags {first} and {second} are both named `{name}`\n  why: materials are given by name\n  do:  give them one tag, or two names"
    )]
    RegionName {
        /// The name.
        name: String,
        /// One tag.
        first: i64,
        /// The other.
        second: i64,
    },
    /// Too many regions.
    #[error("the mesh has {count} tags\n  why: at most 1000 regions are simulated\n  do:  tag elements by material")]
    TooManyRegions {
        /// How many.
        count: usize,
    },
}

fn unit_of(unit: Metre) -> &'static str {
    if unit == 1.0 { "metres" } else { "millimetres" }
}
