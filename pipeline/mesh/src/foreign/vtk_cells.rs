//! Cells of VTK, in its legacy and its XML files.

use super::raw_mesh::{MeshFileError, RawMesh, other_solid};

/// Names of arrays that hold the region of a cell, in lower case, by priority.
pub(super) const TAGS: [&str; 9] = [
    "region",
    "regions",
    "gmsh:physical",
    "cellentityids",
    "medit:ref",
    "tetgen:ref",
    "cell_tags",
    "material",
    "gmsh:geometrical",
];

/// A whole number that a file has as a real one.
pub(super) fn whole_number(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0 && value < 4e9).then_some(value as usize)
}

/// Adds a cell, its type and its nodes, which are counted from `first`.
pub(super) fn add_cell(
    raw: &mut RawMesh,
    first: usize,
    (kind, list): (f64, &[f64]),
    tag: i64,
) -> Result<(), MeshFileError> {
    let label = (raw.len() + raw.ignored) as u64;
    match (kind as u8, list.len()) {
        (10 | 71, 4) | (24 | 71, 10) | (12, 8) | (25, 20) | (29, 27) => {
            let nodes: Option<Vec<u32>> =
                list.iter().map(|&node| u32::try_from(whole_number(node)? + first).ok()).collect();
            let nodes = nodes.ok_or_else(|| {
                let message = format!("cell {label} names a broken node");
                MeshFileError::new(message, "it is no count", "save the mesh again")
            })?;
            raw.add_tetrahedron(label, &nodes, tag)
        }
        // points, lines and faces of VTK, linear, quadratic and Lagrange's
        (1..=9 | 21..=23 | 28 | 30 | 34 | 36 | 68..=70, _) => {
            raw.ignored += 1;
            Ok(())
        }
        (kind, nodes) => Err(other_solid(&format!("cells of VTK's type {kind} with {nodes} nodes"))),
    }
}
