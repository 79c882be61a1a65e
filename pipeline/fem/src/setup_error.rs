//! Errors of setting up a system or changing its properties: what is invalid, where, against which limit, and what to
//! do.

use si::{CubicMetre, Kilogram, Metre, Pascal, Point3};
use sparse::FactorError;

/// Larger bodies are taken for bodies in millimetres.
pub(crate) const LARGEST: Metre = 10.0;
/// Smaller bodies are taken for bodies in another unit.
pub(crate) const SMALLEST: Metre = 1e-4;
/// Least ratio of volume to the cube of the longest edge; a regular tetrahedron has 0.118.
pub(crate) const THINNEST: f64 = 1e-7;

/// "3, 4 or 6".
pub(crate) fn alternatives_text(counts: &[usize]) -> String {
    let texts: Vec<String> = counts.iter().map(usize::to_string).collect();
    match texts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} or {last}", before.join(", ")),
        _ => texts.concat(),
    }
}

/// Why no [`crate::System`] can be made of what was given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// The lists of elements and regions differ in length.
    #[error(
        "the mesh has {elements} elements but {regions} region numbers\n  why: each element lies in one region\n  do:  give as many region numbers as elements"
    )]
    Regions {
        /// Elements.
        elements: usize,
        /// Region numbers.
        regions: usize,
    },
    /// A mesh without elements.
    #[error(
        "the mesh has no elements\n  why: a body needs at least one element\n  do:  check the output of the mesher"
    )]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("node {node} lies at ({:e}, {:e}, {:e}) m\n  why: every coordinate must be a finite number\n  do:  check the mesh file at this node", .at[0], .at[1], .at[2])]
    NodeNotFinite {
        /// Which node.
        node: usize,
        /// Where it lies, m.
        at: Point3,
    },
    /// A node number beyond the list.
    #[error(
        "{part} {index} refers to node {node}\n  why: the mesh has {nodes} nodes, counted from 0\n  do:  check whether the numbers were counted from 1"
    )]
    NoSuchNode {
        /// "element", "chamber face" or "clamp".
        part: &'static str,
        /// Which one.
        index: usize,
        /// The node number.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// An edge or a face of another number of nodes.
    #[error(
        "the {part} of a load has {given} nodes\n  why: it must have {}\n  do:  give the nodes of a side of an element, corners first",
        crate::setup_error::alternatives_text(.each)
    )]
    Side {
        /// "edge" or "face".
        part: &'static str,
        /// Number of its nodes.
        given: usize,
        /// Numbers that it may have.
        each: &'static [usize],
    },
    /// A node of no element.
    #[error(
        "node {node} belongs to no element\n  why: the stiffness matrix would be singular there\n  do:  remove unused nodes from the mesh"
    )]
    UnusedNode {
        /// Which node.
        node: usize,
    },
    /// A size that suggests another unit.
    #[error("the mesh is {size:.3e} m long\n  why: sizes from {:.0e} m to {:.0} m are supported; this suggests {}\n  do:  give positions in metres", crate::setup_error::SMALLEST, crate::setup_error::LARGEST, if *.size > 1.0 { "millimetres" } else { "another unit" })]
    Size {
        /// Largest side of its box, m.
        size: Metre,
    },
    /// An inverted element.
    #[error(
        "element {element} has the volume {volume:.3e} m³\n  why: it is inverted at one quadrature point or more\n  do:  swap two of its corners (and their mid-edge nodes), or mesh again"
    )]
    InvertedElement {
        /// Which element.
        element: usize,
        /// Its signed volume, m³.
        volume: CubicMetre,
    },
    /// A degenerate element.
    #[error(
        "element {element} is degenerate: its volume is {volume:.3e} m³, {ratio:.1e} of its longest edge cubed\n  why: the limit is {:.0e}\n  do:  collapse the element, or mesh again",
        crate::setup_error::THINNEST
    )]
    DegenerateElement {
        /// Which element.
        element: usize,
        /// Its volume, m³.
        volume: CubicMetre,
        /// Volume over the cube of the longest edge.
        ratio: f64,
    },
    /// A region without properties.
    #[error(
        "element {element} lies in region {region}\n  why: properties are given for {given} regions, counted from 0\n  do:  give material, E, ν and density of region {region}"
    )]
    RegionWithoutProperties {
        /// The first such element.
        element: usize,
        /// Its region.
        region: u16,
        /// Number of regions with properties.
        given: usize,
    },
    /// A constant outside its range.
    #[error(
        "region {region} has {name} = {value:e} {unit}\n  why: it must lie {range}\n  do:  check its value and unit"
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
    /// A list of element factors of the wrong length.
    #[error(
        "there are {given} factors for {elements} elements\n  why: each element has one\n  do:  give one factor per element, or none"
    )]
    ElementFactors {
        /// Number of factors.
        given: usize,
        /// Number of elements.
        elements: usize,
    },
    /// A factor of an element that is not positive.
    #[error(
        "element {element} has the factor {factor:e}\n  why: a factor of the moduli lies above 0 and below 1e12\n  do:  give a positive modulus to every element"
    )]
    ElementFactor {
        /// Which element.
        element: usize,
        /// Its factor.
        factor: f64,
    },
    /// Element factors with relaxation.
    #[error(
        "elements have factors of their own in a body that relaxes\n  why: relaxation is kept per region\n  do:  remove the relaxation, or give moduli by region"
    )]
    ElementFactorsRelax,
    /// Relaxation of a law that is not objective.
    #[error(
        "region {region} of the law `{law}` cannot relax\n  why: its stress changes in a rigid rotation\n  do:  take neo_hookean, yeoh or corotated"
    )]
    RelaxationLaw {
        /// Which region.
        region: usize,
        /// Its law.
        law: &'static str,
    },
    /// An attached mass outside its range.
    #[error(
        "the mass attached to node {node} is {mass:e} kg\n  why: it must lie above 0 and below 1000 kg\n  do:  give it in kilograms"
    )]
    AttachedMass {
        /// Which node.
        node: u32,
        /// Its mass, kg.
        mass: Kilogram,
    },
    /// A body without degrees of freedom.
    #[error(
        "the clamps constrain all {nodes} nodes along all axes\n  why: there are no degrees of freedom\n  do:  clamp fewer nodes"
    )]
    FullyConstrained {
        /// Number of nodes.
        nodes: usize,
    },
    /// A body with a rigid motion.
    #[error(
        "the part of the mesh around node {node} is not sufficiently constrained\n  why: its clamps allow at least one rigid motion\n  do:  clamp three nodes of it that are not collinear, or remove the part"
    )]
    RigidMotion {
        /// One of its nodes.
        node: usize,
    },
    /// A half model with nodes below its symmetry plane.
    #[error(
        "node {node} of the half model lies at z = {z:.3e} m\n  why: a half model lies at z ≥ 0\n  do:  cut the mesh at z = 0, or set symmetry_plane_z = false"
    )]
    BelowSymmetryPlane {
        /// Which node.
        node: usize,
        /// Its z coordinate, m.
        z: Metre,
    },
    /// A chamber whose surface is not closed.
    #[error("chamber {chamber} is open at edge {}-{} of its face {face}\n  why: no other face of the chamber has this edge in the opposite direction, and it is not on a symmetry plane\n  do:  close the surface of the chamber, and orient all its normals out of the solid", .edge[0], .edge[1])]
    OpenChamber {
        /// Which chamber.
        chamber: usize,
        /// Which of its faces.
        face: usize,
        /// The two nodes.
        edge: [u32; 2],
    },
    /// A chamber with normals into the solid.
    #[error(
        "chamber {chamber} has the volume {volume:.3e} m³\n  why: it must be positive; the normals of its faces must point out of the solid, into the cavity\n  do:  reverse its faces"
    )]
    InvertedChamber {
        /// Which chamber.
        chamber: usize,
        /// Its signed volume, m³.
        volume: CubicMetre,
    },
    /// A chamber face that is not a side of an element.
    #[error(
        "face {face} of chamber {chamber} is not a side of an element\n  why: its nodes {a} and {b} have no common element\n  do:  take chamber faces from the sides of the elements"
    )]
    UnattachedFace {
        /// Which chamber.
        chamber: usize,
        /// Which of its faces.
        face: usize,
        /// A node of the face.
        a: u32,
        /// Another one.
        b: u32,
    },
    /// An ambient pressure outside its range.
    #[error(
        "the ambient pressure of sealed chamber {chamber} is {ambient:e} Pa\n  why: an absolute pressure lies above 0 and below 100 MPa\n  do:  give it in pascals, 101325 for air"
    )]
    AmbientPressure {
        /// Which chamber.
        chamber: usize,
        /// What was given, Pa.
        ambient: Pascal,
    },
    /// A law of contact outside its range.
    #[error(
        "contact has the range {range:e} m and the pressure {pressure:e} Pa\n  why: the range lies above 0 and at most at {largest:.2e} m, a tenth of the body's size; the pressure is a positive number\n  do:  take a range below the thinnest wall, and a tenth of its modulus as the pressure"
    )]
    Contact {
        /// What was given, m.
        range: Metre,
        /// Largest range, m.
        largest: Metre,
        /// What was given, Pa.
        pressure: Pascal,
    },
    /// A share of the μ part outside its range.
    #[error(
        "the share of the shear energy at finer points is {share}\n  why: it lies between 0 and 1; 0.25 holds thin walls beyond their buckle\n  do:  correct `shear_share`"
    )]
    ShearShare {
        /// What was given.
        share: f64,
    },
    /// Chamber faces of another order than the elements.
    #[error(
        "chamber {chamber} has faces of {face} nodes on elements of {element}\n  why: 3-node faces belong to 4-node tetrahedra, 6-node faces to 10-node ones, 8-node faces to 20-node hexahedra; 8-node hexahedra have no chambers\n  do:  give both in one order"
    )]
    MixedOrders {
        /// Which chamber.
        chamber: usize,
        /// Nodes of its faces.
        face: usize,
        /// Nodes of the elements.
        element: usize,
    },
    /// A system too large for the linear algebra.
    #[error("{dofs} degrees of freedom cannot be factorised\n  why: {cause}\n  do:  take a coarser mesh")]
    TooLarge {
        /// Degrees of freedom.
        dofs: usize,
        /// The failed symbolic factorisation.
        #[source]
        cause: FactorError,
    },
    /// A box that cannot be cut into cells.
    #[error(
        "a box of {:e} × {:e} × {:e} m cannot be cut into {} × {} × {} cells\n  why: sides and numbers of cells are positive, and there are at most {largest} cells\n  do:  take fewer cells, or positive sides",
        .size[0], .size[1], .size[2], .cells[0], .cells[1], .cells[2]
    )]
    Box {
        /// Sides, m.
        size: Point3,
        /// Cells along each.
        cells: [usize; 3],
        /// Cells at most.
        largest: usize,
    },
    /// A region or chamber that does not exist.
    #[error("there is no {part} {index}\n  why: there are {count}, counted from 0\n  do:  check the number")]
    NoSuchIndex {
        /// "region" or "chamber".
        part: &'static str,
        /// Which.
        index: usize,
        /// Number of them.
        count: usize,
    },
}
