//! The choice of elements for a body that is given by its surfaces.

use serde::{Deserialize, Serialize};

use crate::{
    Grading, MeshError, QuadraticMesh, Report, Settings, Surface, mesh, mesh_in_hexahedra, mesh_without_sheet,
    quadratic,
};

/// Elements of second order that a body is meshed in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ElementChoice {
    /// Tetrahedra with edges of one length.
    Tetrahedra,
    /// Hexahedra where rows and levels divide the body, tetrahedra elsewhere.
    HexahedraWherePossible(Grading),
    /// Hexahedra or an error.
    Hexahedra(Grading),
}

/// The same choice as settings and cases name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElementName {
    /// With edges of one length.
    #[default]
    Tetrahedra,
    /// Hexahedra sized by the thinnest wall where rows and levels divide the body, tetrahedra elsewhere.
    Auto,
    /// The same, or an error.
    Hexahedra,
}

impl ElementName {
    /// With a grading of hexahedra.
    pub fn graded(self, grading: Grading) -> ElementChoice {
        match self {
            Self::Tetrahedra => ElementChoice::Tetrahedra,
            Self::Auto => ElementChoice::HexahedraWherePossible(grading),
            Self::Hexahedra => ElementChoice::Hexahedra(grading),
        }
    }
}

/// A body meshed, its report, and why it is not in hexahedra where they were wished for.
pub type Chosen = (QuadraticMesh, Report, Option<MeshError>);

/// Meshes a body with its sheet, if it has one, in the elements of choice.
///
/// # Errors
/// [`MeshError`] of the surfaces; of hexahedra where there is no other choice.
pub fn mesh_chosen(
    body: &Surface,
    spine: Option<&Surface>,
    set: &Settings,
    choice: ElementChoice,
) -> Result<Chosen, MeshError> {
    let refused = match choice {
        ElementChoice::Tetrahedra => None,
        ElementChoice::HexahedraWherePossible(grading) | ElementChoice::Hexahedra(grading) => {
            match mesh_in_hexahedra(body, spine, set, &grading) {
                Ok((solid, report)) => return Ok((solid, report, None)),
                Err(why) => Some(why),
            }
        }
    };
    match (choice, refused) {
        (ElementChoice::Hexahedra(_), Some(why)) => Err(why),
        (_, refused) => {
            let (linear, report) = match spine {
                Some(spine) => mesh(body, spine, set)?,
                None => mesh_without_sheet(body, set)?,
            };
            Ok((quadratic(&linear), report, refused))
        }
    }
}
