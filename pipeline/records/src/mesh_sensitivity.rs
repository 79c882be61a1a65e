//! Mesh sensitivity: the moduli identified on each mesh from the same films.

use serde::{Deserialize, Serialize};
use si::Metre;

use super::Moduli;
use crate::subject::Specimen;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The moduli identified on one mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshResult {
    /// Target length of an edge, m.
    pub edge: Metre,
    /// Nodes an element, 10 or 4.
    pub nodes: usize,
    /// Degrees of freedom before clamping.
    pub dofs: usize,
    /// The moduli of body and sheet.
    pub at: Moduli,
    /// The loss there.
    pub loss: f64,
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
        let id = |r: &MeshResult, quantity: &str| {
            format!("mesh_sensitivity.{}.edge_{:.1}mm_{}_nodes.{quantity}", subject, 1e3 * r.edge, r.nodes)
        };
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
            format!("{:.1} mm, {} nodes: {:.3} MPa, {:.2} GPa", 1e3 * r.edge, r.nodes, 1e-6 * r.at[0], 1e-9 * r.at[1])
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
        let sensitivity =
            MeshSensitivity { rows: vec![MeshResult { edge: 5e-3, nodes: 4, dofs: 99, at: moduli, loss: 0.1 }] };
        assert_eq!(MeshSensitivity::from_files(&sensitivity.to_files().unwrap()).unwrap(), sensitivity);
        let mut fewer = sensitivity;
        fewer.rows[0].at.pop();
        let error = MeshSensitivity::from_files(&fewer.to_files().unwrap()).unwrap_err().to_string();
        assert!(error.contains("mesh_sensitivity.json") && error.contains("1 moduli of 2"), "{error}");
    }
}
