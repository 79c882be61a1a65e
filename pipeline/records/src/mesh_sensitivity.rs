//! Mesh sensitivity: the moduli identified on each mesh from the same films.

use serde::{Deserialize, Serialize};
use si::{MILLIMETRE, Metre};

use super::Moduli;
use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The elements of a mesh and their size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cells {
    /// Tetrahedra of 10 or 4 nodes with a target length of an edge, m.
    Tetrahedra {
        /// m.
        edge: Metre,
        /// Nodes an element, 10 or 4.
        nodes: usize,
    },
    /// Hexahedra of second order, graded towards thin walls.
    Hexahedra {
        /// Lengths of the study's cells over theirs.
        finer: f64,
    },
}

/// The moduli identified on one mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshResult {
    /// Its elements.
    pub cells: Cells,
    /// Degrees of freedom before clamping.
    pub dofs: usize,
    /// The moduli of body and sheet.
    pub at: Moduli,
    /// The loss there.
    pub loss: f64,
    /// Where they were searched in a reduced model: the largest difference of a marker from the whole mesh there, over its deviation; a tenth and
    /// more is not certified.
    pub reduced_sigma: Option<f64>,
}

impl Cells {
    /// As part of a metric's id.
    fn id(&self) -> String {
        match self {
            Self::Tetrahedra { edge, nodes } => format!("edge_{:.1}mm_{nodes}_nodes", edge / MILLIMETRE),
            Self::Hexahedra { finer } => format!("hexahedra_{finer}"),
        }
    }

    /// Nodes an element.
    pub fn nodes(&self) -> usize {
        match self {
            Self::Tetrahedra { nodes, .. } => *nodes,
            Self::Hexahedra { .. } => 20,
        }
    }

    /// Their size in words.
    pub fn size_text(&self) -> String {
        match self {
            Self::Tetrahedra { edge, .. } => format!("{:.1} mm", edge / MILLIMETRE),
            Self::Hexahedra { finer } => format!("graded, 1/{finer}"),
        }
    }
}

/// All meshes of a specimen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshSensitivity {
    /// One a mesh.
    pub rows: Vec<MeshResult>,
}

/// Body and sheet: specimens without a sheet have no such record.
const SOLIDS: usize = 2;

impl Record for MeshSensitivity {
    type Of = Specimen;
    const STAGE: &'static str = "mesh_sensitivity";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.has_sheet()
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        RecordFiles::default().scalars("mesh_sensitivity.json", self)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let record: Self = files.read_scalars("mesh_sensitivity.json")?;
        match record.rows.iter().find(|row| row.at.len() != SOLIDS) {
            Some(row) => {
                Err(super::inconsistent_file("mesh_sensitivity.json", format!("{} moduli of {SOLIDS}", row.at.len())))
            }
            None => Ok(record),
        }
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |r: &MeshResult, quantity: &str| format!("mesh_sensitivity.{subject}.{}.{quantity}", r.cells.id());
        let row = |r: &MeshResult| {
            [
                Metric::new(id(r, "body_e_mpa"), 1e-6 * r.at[0], "MPa"),
                Metric::new(id(r, "spine_e_gpa"), 1e-9 * r.at[1], "GPa"),
            ]
        };
        self.rows.iter().flat_map(row).collect()
    }

    fn summary(&self) -> String {
        let text = |r: &MeshResult| {
            let (size, nodes) = (r.cells.size_text(), r.cells.nodes());
            let reduced = r.reduced_sigma.map_or(String::new(), |sigma| format!(" (reduced, {sigma:.2} σ off)"));
            format!("{size}, {nodes} nodes: {:.3} MPa, {:.2} GPa{reduced}", 1e-6 * r.at[0], 1e-9 * r.at[1])
        };
        self.rows.iter().map(text).collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_survive_their_record() {
        let moduli = vec![2e5, 3e9];
        let row =
            |cells: Cells| MeshResult { cells, dofs: 99, at: moduli.clone(), loss: 0.1, reduced_sigma: Some(0.02) };
        let meshes = [Cells::Tetrahedra { edge: 5e-3, nodes: 4 }, Cells::Hexahedra { finer: 1.25 }];
        let sensitivity = MeshSensitivity { rows: meshes.map(row).to_vec() };
        assert_eq!(MeshSensitivity::from_files(&sensitivity.to_files().unwrap()).unwrap(), sensitivity);
        let mut fewer = sensitivity;
        fewer.rows[0].at.pop();
        let error = MeshSensitivity::from_files(&fewer.to_files().unwrap()).unwrap_err().to_string();
        assert!(error.contains("mesh_sensitivity.json") && error.contains("1 moduli of 2"), "{error}");
    }
}
