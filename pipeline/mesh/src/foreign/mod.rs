//! Foreign meshes: tetrahedra or hexahedra that another program made, read, checked, and given a skin.
//!
//! A reader turns the bytes of a file into a [`RawMesh`], which says no more than the file does: [`gmsh`] (`.msh` 4.1 and 2.2, text
//! and binary), [`vtu`] (VTK's unstructured grid, in all its encodings but lz4 and lzma), [`vtk`] (its legacy form), [`medit`] (`.mesh`, text), [`tetgen`]
//! (`.node` and `.ele`). [`RawMesh::check`] makes it a [`ForeignMesh`], or returns its first [`MeshDefect`].
//!
//! `.msh`, `.vtu` and `.vtk` may hold hexahedra of 8, 20 or 27 nodes in the place of tetrahedra: a solid has the first 20 of them.
//! [`RawMesh::check_hexahedra`] leaves those of 8 as they are.
//!
//! [`write_gmsh`] and [`write_medit`] write meshes of our own for other programs.
//!
//! In a [`RawMesh`], ten-node elements have the mid-edge nodes of 01, 12, 02, 03, 13, 23, whatever the file's own order.

mod arrays;
mod boundary;
mod check;
mod defect;
mod gmsh;
mod gmsh_entities;
mod gmsh_groups;
mod gmsh_legacy;
mod hexahedra;
mod hexahedral_chambers;
mod hexahedral_solid;
mod jacobian;
mod medit;
mod raw_mesh;
mod repair;
mod stream;
mod surfaces;
mod tetgen;
mod tokens;
mod vtk;
mod vtk_cells;
mod vtu;
mod writers;

use std::path::Path;

pub use check::{ForeignMesh, Region};
pub use defect::MeshDefect;
pub use gmsh::gmsh;
pub use hexahedra::HexahedralMesh;
pub use hexahedral_chambers::HexahedralChamber;
pub(crate) use jacobian::least_determinant;
pub use medit::medit;
pub use raw_mesh::{MeshFileError, RawMesh};
pub use surfaces::{NamedSurface, surface};
pub use tetgen::tetgen;
pub use vtk::vtk;
pub use vtu::vtu;
pub(crate) use writers::interface_faces;
pub use writers::{write_gmsh, write_medit};

/// The draft in the `bytes` of a file, by the ending of its name; `nodes` are the bytes of TetGen's other file, which is named
/// like this one but for its ending.
///
/// # Errors
/// [`MeshFileError`] with its place in the file.
pub fn read(file: &Path, bytes: &[u8], nodes: Option<&[u8]>) -> Result<RawMesh, MeshFileError> {
    let ending = file.extension().map(|word| word.to_string_lossy().to_ascii_lowercase());
    match (ending.as_deref(), nodes) {
        (Some("msh"), _) => gmsh(bytes),
        (Some("vtu"), _) => vtu(bytes),
        (Some("vtk"), _) => vtk(bytes),
        (Some("mesh"), _) => medit(bytes),
        (Some("ele"), Some(nodes)) => tetgen(nodes, bytes).map_err(|error| named_nodes(error, file)),
        (other, _) => Err(MeshFileError::new(
            format!("the mesh is of an unknown kind (.{})", other.unwrap_or_default()),
            "meshes are read from .msh, .vtu, .vtk, .mesh and .ele",
            "save the mesh in one of these formats",
        )),
    }
}

/// An error in TetGen's file of nodes, with that file's name: its reader is called by that of the elements, whose file is `file`.
fn named_nodes(mut error: MeshFileError, file: &Path) -> MeshFileError {
    let name = nodes_of(file).as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    if let (Some(rest), Some(name)) = (error.place.strip_prefix(tetgen::NODES), name) {
        error.place = format!("{name}, {rest}");
    }
    error
}

/// The file of the nodes of a mesh, where they lie in one of their own.
pub fn nodes_of(file: &Path) -> Option<std::path::PathBuf> {
    let ending = file.extension()?.to_str()?;
    let nodes = if ending == "ELE" { "NODE" } else { "node" };
    ending.eq_ignore_ascii_case("ele").then(|| file.with_extension(nodes))
}
