//! Errors of the mesher: the surface, the place and what to do.

use crate::surface::place_text;
use crate::{SurfaceError, ValidationError};
use si::{Metre, Point3};
use tetrahedralize::Refusal;

/// Why two surfaces did not become a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A surface that does not bound a solid.
    #[error("{role} surface: {source}")]
    Surface {
        /// `body` or `spine`.
        role: &'static str,
        /// What is wrong with it.
        source: SurfaceError,
    },
    /// A setting that is none.
    #[error(
        "the mesher has the setting {name} = {value}\n  why: it must be a finite number above 0\n  do:  correct it; lengths are in metres"
    )]
    Settings {
        /// Its name in [`crate::Settings`].
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// More elements than there is memory for.
    #[error(
        "surfaces of {length:.3e} m with edges of {edge:.3e} m would take about {elements:.0e} elements\n  why: the limit is {limit:.0e}\n  do:  check that lengths are in metres, not in millimetres, or take a longer edge"
    )]
    TooLarge {
        /// Longest side of the surfaces, m.
        length: Metre,
        /// Length of edges, m.
        edge: Metre,
        /// Estimated number.
        elements: f64,
        /// The most.
        limit: f64,
    },
    /// A body that rows of quadrilaterals and levels do not divide.
    #[error("the body cannot be divided into hexahedra at {}\n  why: {why}\n  do:  mesh it in tetrahedra", place_text(.at))]
    NotSwept {
        /// Where, m.
        at: Point3,
        /// What is in the way.
        why: &'static str,
    },
    /// Space between body and spine that neither fills.
    #[error("a gap of {:.3} mm lies between body and spine at {}\n  why: they must touch to {:.3} mm (Settings::tolerance times the length)\n  do:  in the CAD program, extend the body to the spine's surface there", .width * 1e3, place_text(.at), .limit * 1e3)]
    Gap {
        /// Where, m.
        at: Point3,
        /// How wide, m.
        width: Metre,
        /// Widest gap that is closed, m.
        limit: Metre,
    },
    /// Space that both body and spine fill.
    #[error("body and spine overlap by {:.3} mm at {}\n  why: they must touch to {:.3} mm (Settings::tolerance times the length)\n  do:  in the CAD program, subtract the spine from the body", .width * 1e3, place_text(.at), .limit * 1e3)]
    Overlap {
        /// Where, m.
        at: Point3,
        /// How far, m.
        width: Metre,
        /// Widest overlap that is closed, m.
        limit: Metre,
    },
    /// A line that enters a solid more often than it leaves it.
    #[error("the {role} is no stack of layers near {}: a column there enters it and does not leave it\n  why: its side is rounded or slanted there, or faces fold over or cut each other; columns need sides along them\n  do:  take the method general or auto, which take any closed surface; if that refuses it too, look at the faces there", place_text(.at))]
    OddCrossings {
        /// `body` or `spine`.
        role: &'static str,
        /// Where, m.
        at: Point3,
    },
    /// Layers without a common order.
    #[error("the layers at {} and at {} have no common order\n  why: one lies below the other in one place and above it in another, so the body is not a stack of layers over the sheet\n  do:  take the method general or auto, which take any closed surface", place_text(.lower), place_text(.upper))]
    NoCommonOrder {
        /// A point of one layer, m.
        lower: Point3,
        /// A point of the other layer, m.
        upper: Point3,
    },
    /// Outlines that cross when they are drawn with edges of the target length.
    #[error("the outlines of the parts cross each other near {} when drawn with edges of {:.2} mm\n  why: parts are closer to each other than the largest distance of an edge from its outline\n  do:  take a shorter edge, or the method general or auto", place_text(.at), .edge * 1e3)]
    CrossingOutlines {
        /// Where, m.
        at: Point3,
        /// Length of edges, m.
        edge: Metre,
    },
    /// Columns whose elements are too flat.
    #[error(
        "columns of the body have angles of {degrees:.2}°\n  why: layers meet at a round or slanted side; the limit is {limit:.1}°\n  do:  take the method general, or auto"
    )]
    Slivers {
        /// The smallest angle between two faces of an element, degrees.
        degrees: f64,
        /// The limit, degrees.
        limit: f64,
    },
    /// Columns with settings of the general method.
    #[error(
        "columns know no envelope, no shortest edge and no number of layers\n  why: these are settings of the general method\n  do:  take the method general or auto, or leave them out"
    )]
    Detail,
    /// Columns that do not follow the body.
    #[error("columns of the body are {:.3} mm off its surface\n  why: the limit is {:.3} mm, a tenth of the edge\n  do:  take a shorter edge, or the method general or auto", .distance * 1e3, .limit * 1e3)]
    Far {
        /// How far, m.
        distance: Metre,
        /// The limit, m.
        limit: Metre,
    },
    /// More parts than columns take.
    #[error(
        "columns cannot be made of a body with {inserts} inserts and {cavities} cavities in files of their own\n  why: they take a body with one sheet in it, or with none\n  do:  take the method general, or auto"
    )]
    ManyParts {
        /// Inserts.
        inserts: usize,
        /// Cavities.
        cavities: usize,
    },
    /// Nothing to mesh.
    #[error(
        "body and spine leave nothing to mesh\n  why: no line along the sheet's normal goes through a solid\n  do:  check that both files have the same unit and the same origin"
    )]
    Nothing,
    /// Surfaces that the general method refuses.
    #[error(transparent)]
    General(#[from] Refusal),
    /// A mesh of the general method that a solver would refuse.
    #[error("{message}")]
    Defect {
        /// What a check of a mesh file would say of it.
        message: String,
    },
    /// Other chambers than the surface has cavities.
    #[error(
        "the mesh has {found} chambers where the surface has {expected} cavities\n  why: a wall or a cavity is thinner than the elements can follow\n  do:  take a shorter edge"
    )]
    Chambers {
        /// Cavities of the surface.
        expected: usize,
        /// Chambers of the mesh.
        found: usize,
    },
    /// A mesh that failed the validation.
    #[error(transparent)]
    Invalid(#[from] ValidationError),
}

impl MeshError {
    /// The place on the surfaces that it names, m, where it names one.
    pub fn place(&self) -> Option<Point3> {
        match self {
            Self::NotSwept { at, .. }
            | Self::Gap { at, .. }
            | Self::Overlap { at, .. }
            | Self::OddCrossings { at, .. }
            | Self::CrossingOutlines { at, .. }
            | Self::NoCommonOrder { lower: at, .. }
            | Self::General(Refusal::Nothing { at })
            | Self::Invalid(ValidationError::Distance { at, .. })
            | Self::Surface { source: SurfaceError::Open { from: at, .. }, .. } => Some(*at),
            _ => None,
        }
    }
}
