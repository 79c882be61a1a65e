//! Shapes: closed surfaces come in, tagged tetrahedra go out.
//!
//! An STL file becomes a welded [`Surface`]; a body surface and a spine surface become a [`TetMesh`] of columns that
//! stand on the spine's plane ([`mesh`], or [`mesh_alone`] where there is no spine); [`quadratic`] gives each edge its middle node and [`embed`] finds a material
//! point on the skin. Meshes of other programs come in through [`foreign`]; a [`Solid`] is a mesh of either order. [`tail`] is
//! the parametric soft tail, from which a virtual bench takes its own mesh and its "CAD export". Everything is in metres and
//! gives the same bytes on every run. Paper: section on the model.
//!
//! Stands on: `si`. Never knows: a material, a pressure, a specimen, a file's path.

mod cavities;
mod columns;
mod distance;
mod embed;
pub mod foreign;
mod frame;
mod quadratic;
mod quality;
mod solid;
mod stack;
pub mod stl;
mod surface;
pub mod tail;
mod tetrahedra;
mod validate;

pub use cavities::{Cavity, cavities};
pub use columns::{MeshError, Settings, mesh, mesh_alone};
pub use embed::{Spot, embed};
pub use quadratic::{QuadraticFace, QuadraticMesh, quadratic};
pub use solid::Solid;
pub use surface::{Joint, Shell, Surface, SurfaceError};
pub use tetrahedra::{BODY, SPINE, Skin, SkinFace, TetMesh};
pub use validate::{Chamber, Report, Unfit};
