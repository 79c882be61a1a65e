//! Closed triangle surfaces, clean or not, to labelled tetrahedra.
//!
//! Surfaces are remeshed towards the target length within an envelope, their nodes and a graded lattice become Delaunay tetrahedra, their triangles
//! are inserted by splits of edges, winding numbers say which tetrahedra are solid, and local operations bring the elements to length and
//! shape \[hu2018\] \[hu2020\]. A result that keeps to the envelope and is valid is preferred to a refusal: what cannot be inserted is approximated.
//!
//! | task | item |
//! |------|------|
//! | surfaces with what fills them | [`Part`], [`Fill`] |
//! | lengths and limits | [`Settings`] |
//! | inside and outside | [`Winding`] |
//! | tetrahedra | [`tetrahedralize`], [`Tetrahedra`] |
//!
//! The constrained Delaunay alternative (a facet is recovered exactly, or the surface is refused) takes clean surfaces only. Isosurface stuffing needs cells as small as the thinnest wall in every direction.
//!
//! ```
//! use tetrahedralize::{Fill, Part, Settings, tetrahedralize};
//!
//! // a closed box of 40 × 10 × 20 mm, normals outwards
//! let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { [0.04, 0.01, 0.02][k] } else { 0.0 });
//! let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
//! let body = Part { points: (0..8).map(corner).collect(), faces, fill: Fill::Region(0) };
//!
//! let solid = tetrahedralize(&[body], &Settings::new(4e-3))?;
//! assert!((solid.volume(0) - 8e-6).abs() < 1e-10);
//! # Ok::<(), tetrahedralize::Refusal>(())
//! ```
//!
//! Lengths are in metres. The same input gives the same mesh, byte for byte; there is one thread.

mod complex;
mod delaunay;
mod envelope;
mod estimate;
mod geometry;
mod improve;
mod insertion;
mod labels;
mod lattice;
mod orient;
mod pipeline;
mod refusal;
mod remesh;
mod shared_faces;
mod topology;
mod tree;
mod winding;

pub use orient::Repair;
pub use pipeline::{tetrahedralize, tetrahedralize_watched};
pub use refusal::Refusal;
pub use winding::Winding;

use si::{CubicMetre, Metre, Point3};

/// What a closed surface holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fill {
    /// Material of this region.
    Region(u16),
    /// Nothing: a cavity in the parts before it.
    Void,
}

/// A surface and what fills it; a later part displaces earlier ones where both are.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Corner positions, m.
    pub points: Vec<Point3>,
    /// Three corners a face, normals outwards.
    pub faces: Vec<[u32; 3]>,
    /// What is inside.
    pub fill: Fill,
}

impl Part {
    /// The corners of each face.
    pub(crate) fn triangles(&self) -> Vec<[Point3; 3]> {
        self.faces.iter().map(|f| f.map(|n| self.points[n as usize])).collect()
    }
}

/// Lengths and limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Target length of edges, m.
    pub edge: Metre,
    /// Largest distance between the surfaces and the mesh's, m.
    pub envelope: Metre,
    /// Shortest target length, m: walls and features that are smaller get elements of this length along them.
    pub least: Metre,
    /// Target length over the thickness of a wall; 0.5 asks for two elements through it.
    pub aspect: f64,
    /// Growth of the target length per length.
    pub gradation: f64,
    /// Most elements, by an estimate before any are made.
    pub max_elements: f64,
    /// Rounds of operations.
    pub rounds: usize,
}

impl Settings {
    /// Edges of a given length (m), an envelope of 2 % of it, walls with elements five times as long as they are thick.
    pub fn new(edge: Metre) -> Self {
        Self {
            edge,
            envelope: 0.02 * edge,
            least: edge / 16.0,
            // of quadratic elements; 3 takes twice as many in a tail with walls of 0.4 mm, and their angles are no better
            aspect: 5.0,
            gradation: 0.4,
            max_elements: 5e6,
            rounds: 4,
        }
    }
}

/// Labelled tetrahedra.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tetrahedra {
    /// Node positions, m.
    pub nodes: Vec<Point3>,
    /// Four nodes each, of positive volume.
    pub tets: Vec<[u32; 4]>,
    /// Region of each.
    pub regions: Vec<u16>,
    /// What was changed of the surfaces before.
    pub repairs: Vec<Repair>,
}

impl Tetrahedra {
    /// Volume of a region, m³.
    pub fn volume(&self, region: u16) -> CubicMetre {
        let members = self.tets.iter().zip(&self.regions).filter(|(_, r)| **r == region);
        members.map(|(t, _)| geometry::six_volumes(t.map(|n| self.nodes[n as usize])) / 6.0).sum()
    }

    /// The smallest dihedral angle of each tetrahedron, rad.
    pub fn smallest_angles(&self) -> Vec<f64> {
        let angles = |t: &[u32; 4]| geometry::dihedral_angles(t.map(|n| self.nodes[n as usize]));
        self.tets.iter().map(|t| angles(t).into_iter().fold(f64::INFINITY, f64::min)).collect()
    }
}
