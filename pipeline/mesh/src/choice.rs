//! The choice of elements for a body that is given by its surfaces.

use serde::{Deserialize, Serialize};

use crate::{
    Grading, MeshError, Method, QuadraticMesh, Report, Settings, Surface, TetMesh, mesh, mesh_general,
    mesh_in_hexahedra, mesh_without_sheet, quadratic,
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

/// A body meshed, its report, and what was refused before.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The mesh.
    pub solid: QuadraticMesh,
    /// Its report.
    pub report: Report,
    /// Why it is not in hexahedra where they were wished for.
    pub not_hexahedra: Option<MeshError>,
    /// Why it is not in columns where they were tried first.
    pub not_columns: Option<MeshError>,
}

/// Meshes a body with its sheet, if it has one, in the elements of choice and by the method of the settings.
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
                Ok((solid, report)) => {
                    return Ok(Chosen { solid, report, not_hexahedra: None, not_columns: None });
                }
                Err(why) => Some(why),
            }
        }
    };
    match (choice, refused) {
        (ElementChoice::Hexahedra(_), Some(why)) => Err(why),
        (_, not_hexahedra) => {
            let ((linear, report), not_columns) = tetrahedra(body, spine, set)?;
            Ok(Chosen { solid: quadratic(&linear), report, not_hexahedra, not_columns })
        }
    }
}

/// A body in tetrahedra, and why not in columns where these were tried first.
type Tetrahedra = ((TetMesh, Report), Option<MeshError>);

/// A body in tetrahedra by the method of the settings.
fn tetrahedra(body: &Surface, spine: Option<&Surface>, set: &Settings) -> Result<Tetrahedra, MeshError> {
    let columns = || match spine {
        Some(spine) => mesh(body, spine, set),
        None => mesh_without_sheet(body, set),
    };
    match set.method {
        Method::Columns => Ok((columns()?, None)),
        Method::General => Ok((mesh_general(body, spine, set)?, None)),
        Method::Auto => match columns() {
            Ok(made) => Ok((made, None)),
            // the general method would take as much
            Err(why @ (MeshError::TooLarge { .. } | MeshError::Settings { .. })) => Err(why),
            Err(why) => Ok((mesh_general(body, spine, set)?, Some(why))),
        },
    }
}
