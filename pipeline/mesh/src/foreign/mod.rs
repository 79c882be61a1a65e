//! Foreign meshes: tetrahedra that another program made, read, checked, and given a skin.
//!
//! A reader turns the bytes of a file into a [`RawMesh`], which says no more than the file does: [`gmsh`] (`.msh` 4.1, text and
//! binary), [`vtu`] (VTK's unstructured grid, in all its encodings but lz4 and lzma), [`medit`] (`.mesh`, text), [`tetgen`]
//! (`.node` and `.ele`). [`RawMesh::check`] makes it a [`ForeignMesh`], or returns its first [`MeshDefect`].
//!
//! In a [`RawMesh`], ten-node elements have the mid-edge nodes of 01, 12, 02, 03, 13, 23, whatever the file's own order.

mod arrays;
mod boundary;
mod check;
mod defect;
mod gmsh;
mod jacobian;
mod medit;
mod raw_mesh;
mod repair;
mod stream;
mod tetgen;
mod tokens;
mod vtu;

pub use check::{ForeignMesh, Region};
pub use defect::MeshDefect;
pub use gmsh::gmsh;
pub use medit::medit;
pub use raw_mesh::{MeshFileError, RawMesh};
pub use tetgen::tetgen;
pub use vtu::vtu;
