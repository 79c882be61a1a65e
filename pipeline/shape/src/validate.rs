//! Validate: what a mesh is worth, and the refusal of one that cannot be trusted.
//!
//! Stands on: `tetrahedra`, `surface`, `distance`, `quality`. Never knows: how the mesh was made.

use si::{CubicMetre, Metre, Point3, SquareMetre};

/// A cavity, whole even when only the half is meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Chamber {
    /// Centroid, m.
    pub centroid: Point3,
    /// Volume, m³.
    pub volume: CubicMetre,
}

/// What a mesh is worth. Volumes and areas are those of the whole body, even when only the half is meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Corner nodes.
    pub nodes: usize,
    /// Elements.
    pub tets: usize,
    /// Nodes of the quadratic mesh.
    pub quadratic_nodes: usize,
    /// Smallest angle between two faces of an element, degrees.
    pub min_dihedral_deg: f64,
    /// Largest angle between two faces of an element, degrees.
    pub max_dihedral_deg: f64,
    /// Largest distance between the surfaces and the mesh's skin, sampled both ways, m.
    pub hausdorff_m: Metre,
    /// Volume of the body's elements, m³.
    pub volume_body: CubicMetre,
    /// Volume of the spine's elements, m³.
    pub volume_spine: CubicMetre,
    /// Volume of the body's surface, m³.
    pub volume_body_stl: CubicMetre,
    /// Volume of the spine's surface, m³.
    pub volume_spine_stl: CubicMetre,
    /// Area where body and spine touch, m².
    pub interface_area: SquareMetre,
    /// The cavities, in the order of [`crate::Skin::Chamber`].
    pub chambers: Vec<Chamber>,
    /// Whether only z ≥ 0 is meshed.
    pub half: bool,
}

/// Why a mesh is not trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// A volume that is off.
    #[error("the mesh's {part} has {mesh_mm3:.1} mm³ where the surface encloses {surface_mm3:.1} mm³\n  why: it is off by {percent:.2} %; the limit is {limit_percent:.2} % (volume_limit)\n  do:  take a shorter edge, or look for a thin part of the {part} that the plan cannot resolve")]
    Volume {
        /// Which part.
        part: String,
        /// Volume of the elements, mm³.
        mesh_mm3: f64,
        /// Volume of the surface, mm³.
        surface_mm3: f64,
        /// Difference, per cent.
        percent: f64,
        /// Limit, per cent.
        limit_percent: f64,
    },
}
