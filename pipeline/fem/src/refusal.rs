//! Refusals: what is wrong with a mesh or its properties, where, against which limit, and what to do.
//!
//! Stands on: `thiserror`. Never knows: how it was found.

use si::{CubicMetre, Kilogram, Metre, Pascal, Point3};

/// Larger bodies are given in millimetres by mistake.
pub(crate) const LARGEST: Metre = 10.0;
/// Smaller ones in kilometres, or they are a single point.
pub(crate) const SMALLEST: Metre = 1e-4;
/// Volume over the cube of the longest edge, of the flattest element allowed: a regular one has 0.118.
pub(crate) const FLATTEST: f64 = 1e-7;

/// Why no [`crate::System`] can be made of what was given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// Lists that should be equally long are not.
    #[error(
        "the mesh has {elements} elements but {regions} region numbers\n  why: each element lies in one region\n  do:  give as many region numbers as elements"
    )]
    Regions {
        /// Elements.
        elements: usize,
        /// Region numbers.
        regions: usize,
    },
    /// Nothing to solve for.
    #[error("the mesh has no elements\n  why: a body needs at least one tetrahedron\n  do:  check the mesher's output")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("node {node} lies at ({:e}, {:e}, {:e}) m\n  why: every coordinate must be a finite number\n  do:  check the mesh file at this node", .at[0], .at[1], .at[2])]
    NodeNotANumber {
        /// Which node.
        node: usize,
        /// Where it lies, m.
        at: Point3,
    },
    /// A node number beyond the list.
    #[error(
        "{part} {index} names node {node}\n  why: the mesh has {nodes} nodes, counted from 0\n  do:  check whether the numbers were counted from 1"
    )]
    NoSuchNode {
        /// "element", "chamber face" or "clamp".
        part: &'static str,
        /// Which of them.
        index: usize,
        /// The number it names.
        node: u32,
        /// How many nodes there are.
        nodes: usize,
    },
    /// A node that no element uses.
    #[error(
        "node {node} belongs to no element\n  why: nothing would hold it in place\n  do:  drop unused nodes from the mesh"
    )]
    StrayNode {
        /// Which node.
        node: usize,
    },
    /// A size that betrays another unit.
    #[error("the mesh is {size:.3e} m long\n  why: bodies between {:.0e} m and {:.0} m are simulated; this looks like {}\n  do:  give positions in metres", crate::refusal::SMALLEST, crate::refusal::LARGEST, if *.size > 1.0 { "millimetres" } else { "another unit" })]
    Size {
        /// Largest side of its box, m.
        size: Metre,
    },
    /// An element turned inside out.
    #[error(
        "element {element} has the volume {volume:.3e} m³\n  why: it is turned inside out, at least at one point\n  do:  swap two of its corners (and their middle nodes), or mesh anew"
    )]
    InvertedElement {
        /// Which element.
        element: usize,
        /// Its signed volume, m³.
        volume: CubicMetre,
    },
    /// An element without thickness.
    #[error(
        "element {element} is flat: its volume is {volume:.3e} m³, {ratio:.1e} of its longest edge cubed\n  why: the limit is {:.0e}\n  do:  collapse the element, or mesh anew",
        crate::refusal::FLATTEST
    )]
    FlatElement {
        /// Which element.
        element: usize,
        /// Its volume, m³.
        volume: CubicMetre,
        /// Volume over the cube of the longest edge.
        ratio: f64,
    },
    /// A region that nothing is known of.
    #[error(
        "element {element} lies in region {region}\n  why: properties are given for {given} regions, counted from 0\n  do:  give material, E, ν and density of region {region}"
    )]
    RegionWithoutProperties {
        /// The first such element.
        element: usize,
        /// Its region.
        region: u16,
        /// How many have properties.
        given: usize,
    },
    /// A constant outside of its range.
    #[error(
        "region {region} has {name} = {value:e} {unit}\n  why: it must lie {range}\n  do:  check the card's value and unit"
    )]
    Property {
        /// Which region.
        region: usize,
        /// Which property.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Its range.
        range: &'static str,
    },
    /// A mass that cannot be one.
    #[error(
        "the mass attached to node {node} is {mass:e} kg\n  why: it must lie above 0 and below 1000 kg\n  do:  give it in kilograms"
    )]
    AttachedMass {
        /// Which node.
        node: u32,
        /// Its mass, kg.
        mass: Kilogram,
    },
    /// A body that cannot move at all.
    #[error(
        "the clamps hold all {nodes} nodes along all axes\n  why: nothing is left to solve for\n  do:  clamp fewer nodes"
    )]
    AllHeld {
        /// How many nodes there are.
        nodes: usize,
    },
    /// A body that can move without bending.
    #[error(
        "the part of the mesh around node {node} is free\n  why: its clamps leave it at least one rigid motion\n  do:  hold three nodes of it that are not in one line, or remove the part"
    )]
    FreeBody {
        /// A node of it.
        node: usize,
    },
    /// A half model that reaches below its plane.
    #[error(
        "node {node} of the half model lies at z = {z:.3e} m\n  why: a half model lies at z ≥ 0\n  do:  cut the mesh at z = 0, or say that it is whole"
    )]
    BelowSymmetryPlane {
        /// Which node.
        node: usize,
        /// Its height, m.
        z: Metre,
    },
    /// A chamber with a hole.
    #[error("chamber {chamber} is open at edge {}-{} of its face {face}\n  why: no other face of the chamber runs along this edge the other way, and it is not on a symmetry plane\n  do:  close the chamber's surface, and turn all its normals out of the solid", .edge[0], .edge[1])]
    OpenChamber {
        /// Which chamber.
        chamber: usize,
        /// Which of its faces.
        face: usize,
        /// The two nodes.
        edge: [u32; 2],
    },
    /// A chamber whose normals point into the solid.
    #[error(
        "chamber {chamber} has the volume {volume:.3e} m³\n  why: it must be positive; the normals of its faces must point out of the solid, into the cavity\n  do:  turn its faces"
    )]
    ChamberInsideOut {
        /// Which chamber.
        chamber: usize,
        /// Its signed volume, m³.
        volume: CubicMetre,
    },
    /// A face that is no side of an element.
    #[error(
        "face {face} of chamber {chamber} is no side of an element\n  why: its nodes {a} and {b} share no element\n  do:  take chamber faces from the sides of the elements"
    )]
    FaceOfNoElement {
        /// Which chamber.
        chamber: usize,
        /// Which of its faces.
        face: usize,
        /// A node of the face.
        a: u32,
        /// Another one.
        b: u32,
    },
    /// Surroundings that cannot be.
    #[error(
        "the surroundings of sealed chamber {chamber} have {ambient:e} Pa\n  why: an absolute pressure lies above 0 and below 100 MPa\n  do:  give it in pascals, 101325 for air"
    )]
    Ambient {
        /// Which chamber.
        chamber: usize,
        /// What was given, Pa.
        ambient: Pascal,
    },
    /// Faces of another order than the elements.
    #[error(
        "chamber {chamber} has faces of {face} nodes on elements of {element}\n  why: 3-node faces belong to 4-node tetrahedra, 6-node faces to 10-node ones\n  do:  give both in one order"
    )]
    MixedOrders {
        /// Which chamber.
        chamber: usize,
        /// Nodes of its faces.
        face: usize,
        /// Nodes of the elements.
        element: usize,
    },
    /// The linear algebra ran out of memory or numbers.
    #[error("the factor of {freedoms} degrees of freedom cannot be laid out\n  why: {why}\n  do:  take a coarser mesh")]
    TooLarge {
        /// Degrees of freedom.
        freedoms: usize,
        /// faer's own words.
        why: String,
    },
    /// A name that does not exist.
    #[error("there is no {part} {index}\n  why: there are {count}, counted from 0\n  do:  check the number")]
    NoSuch {
        /// "region" or "chamber".
        part: &'static str,
        /// Which.
        index: usize,
        /// How many there are.
        count: usize,
    },
}
