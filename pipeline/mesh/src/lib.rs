//! Tetrahedral meshes with regions, from closed surfaces or from the files of other meshers.
//!
//! | task | item |
//! |------|------|
//! | STL files to welded [`Surface`]s, and back | [`stl`] |
//! | a body and a plane sheet to a [`TetMesh`] | [`mesh`], [`mesh_without_sheet`] |
//! | bodies of any shape | [`mesh_chosen`] with [`Method::General`] |
//! | a body with inserts and cavities | [`mesh_assembly`], [`Measures`] |
//! | columns over a triangulated plan | [`stack`] |
//! | ten-node elements | [`quadratic`]; on curved surfaces [`Curving`] |
//! | files of gmsh, VTK, MEDIT and TetGen | [`foreign`] |
//! | material points on the skin, means over painted marks | [`embed`], [`embed_mark`] |
//! | volumes and centroids of chambers | [`cavities`] |
//! | dent and bulge of a moved tail's walls | [`wall`] |
//! | the same as a camera above sees them | [`silhouette`] |
//!
//! Lengths are in metres. The same input gives the same mesh, byte for byte.
//!
//! ```
//! use mesh::{Settings, Surface, mesh_without_sheet};
//!
//! // a closed box of 40 × 10 × 20 mm, normals outwards
//! let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { [0.04, 0.01, 0.02][k] } else { 0.0 });
//! let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
//! let body = Surface { points: (0..8).map(corner).collect(), faces };
//!
//! let (tetrahedra, report) = mesh_without_sheet(&body, &Settings::new(5e-3))?;
//! assert!(tetrahedra.nonconformity().is_none());
//! assert!((report.volume_body - 8e-6).abs() < 1e-15);
//! # Ok::<(), mesh::MeshError>(())
//! ```
//!
//! Depends on `si`, `tetrahedralize` (bodies that are no columns), spade (constrained Delaunay triangulation of the plan) and the parsers of the file formats.

mod assembly;
mod cavities;
mod choice;
mod closing;
mod columns;
mod conforming;
mod curving;
mod distance;
mod embed;
pub mod foreign;
pub mod frame;
mod general;
mod hexahedra;
mod measures;
mod method;
mod quadratic;
mod quadratic_face;
pub mod quality;
pub mod silhouette;
mod solid;
mod solid_angle;
pub mod stack;
pub mod stl;
mod surface;
mod tetrahedra;
mod validate;
mod visibility;
pub mod vtu;
pub mod wall;

pub use assembly::Assembly;
pub use cavities::{Cavity, cavities};
pub use choice::{Chosen, ElementChoice, ElementName, mesh_assembly, mesh_chosen};
pub(crate) use columns::mesh_in_hexahedra;
pub use columns::{Grading, LayeredBody, MeshError, Settings, Slab, layers_in_hexahedra, mesh, mesh_without_sheet};
pub use curving::Curving;
pub use embed::{Spot, embed, embed_mark};
pub(crate) use general::mesh_general;
pub use measures::{Interface, Measures, RegionMeasures};
pub use method::{Detail, Method};
pub use quadratic::{QuadraticElements, QuadraticMesh, quadratic};
pub use quadratic_face::QuadraticFace;
pub use solid::Solid;
pub use solid_angle::{chamber_at, chamber_containing};
pub use surface::{SharedEdge, Shell, Surface, SurfaceError};
pub use tetrahedra::{BODY, FACES, SPINE, Skin, SkinFace, TetMesh};
pub use validate::{Chamber, Report, ValidationError};
