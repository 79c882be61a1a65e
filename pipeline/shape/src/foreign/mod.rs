//! Foreign meshes: tetrahedra that another program made, read, checked, and given a skin.
//!
//! A reader turns the bytes of a file into a [`Draft`], which says no more than the file does: [`gmsh`] (`.msh` 4.1, text and
//! binary), [`vtu`] (VTK's unstructured grid, in all its encodings but lz4 and lzma), [`medit`] (`.mesh`, text), [`tetgen`]
//! (`.node` and `.ele`). [`Draft::check`] makes it a [`Foreign`] that can be trusted, or says what is wrong with it.
//!
//! Ten-node elements leave a reader with the middles of edges 01, 12, 02, 03, 13, 23, whatever the file's own order.
//!
//! Stands on: `solid`, `skin`, roxmltree, base64, flate2. Never knows: a material, a file's path.
//! A new format: one file here, its line in this list, and the ball of `tests/data` written in it.

mod arrays;
mod check;
mod draft;
mod gmsh;
mod jacobian;
mod medit;
mod sides;
mod stream;
mod tetgen;
mod tidy;
mod untrusted;
mod vtu;
mod words;

pub use check::{Foreign, Region};
pub use draft::{Draft, Malformed};
pub use gmsh::gmsh;
pub use medit::medit;
pub use tetgen::tetgen;
pub use untrusted::Untrusted;
pub use vtu::vtu;
