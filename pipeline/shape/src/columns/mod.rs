//! Columns: a body and a sheet, as surfaces, become tetrahedra that stand in columns on the sheet's plane.
//!
//! Stands on: `stack`, `surface`, `validate`. Never knows: the parametric tail, a material, a file.

use crate::{Report, Surface, SurfaceError, TetMesh, Unfit};
use si::Metre;

/// How to mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Target length of edges, m.
    pub edge: Metre,
    /// Mesh only z ≥ 0 when both surfaces are symmetric about z = 0.
    pub use_symmetry: bool,
}

/// Why two surfaces did not become a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A surface that does not bound a solid.
    #[error("{role}: {source}")]
    Surface {
        /// `body` or `spine`.
        role: &'static str,
        /// What is wrong with it.
        source: SurfaceError,
    },
    /// A mesh that was made and is not trusted.
    #[error(transparent)]
    Unfit(#[from] Unfit),
}

/// Meshes a body around a plane sheet.
///
/// # Errors
/// [`MeshError`], which names the surface and the place.
pub fn mesh(body: &Surface, spine: &Surface, set: &Settings) -> Result<(TetMesh, Report), MeshError> {
    let _ = set;
    body.shells().map_err(|source| MeshError::Surface { role: "body", source })?;
    spine.shells().map_err(|source| MeshError::Surface { role: "spine", source })?;
    Err(MeshError::Surface { role: "body", source: SurfaceError::Empty })
}
