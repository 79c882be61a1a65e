//! Mesh honesty: the moduli that each mesh was given by the same films.

use serde::{Deserialize, Serialize};
use si::Metre;

use super::Point;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Specimen;

/// What one mesh was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Honest {
    /// Target length of an edge, m.
    pub edge: Metre,
    /// Nodes an element, 10 or 4.
    pub nodes: usize,
    /// Degrees of freedom before clamping.
    pub freedoms: usize,
    /// The moduli.
    pub at: Point,
    /// The loss there.
    pub loss: f64,
}

/// All meshes of a specimen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshHonesty {
    /// One a mesh.
    pub rows: Vec<Honest>,
}

impl Record for MeshHonesty {
    type Of = Specimen;
    const STAGE: &'static str = "mesh_honesty";

    fn pack(&self) -> Result<Parcel, RecordError> {
        Parcel::default().scalars("mesh_honesty.json", self)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        parcel.read_scalars("mesh_honesty.json")
    }

    fn metrics(&self, of: &Specimen) -> Vec<Metric> {
        let id = |r: &Honest, what: &str| {
            format!("mesh_honesty.{}.edge_{:.1}mm_{}_nodes.{what}", of.card.name, 1e3 * r.edge, r.nodes)
        };
        let row = |r: &Honest| {
            [
                Metric::new(id(r, "body_e_mpa"), 1e-6 * r.at.body_e_pa, "MPa"),
                Metric::new(id(r, "spine_e_gpa"), 1e-9 * r.at.spine_e_pa, "GPa"),
            ]
        };
        self.rows.iter().flat_map(row).collect()
    }

    fn telling(&self) -> String {
        let said = |r: &Honest| {
            format!(
                "{:.1} mm, {} nodes: {:.3} MPa, {:.2} GPa",
                1e3 * r.edge,
                r.nodes,
                1e-6 * r.at.body_e_pa,
                1e-9 * r.at.spine_e_pa
            )
        };
        self.rows.iter().map(said).collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_survive_their_record() {
        let at = Point { body_e_pa: 2e5, spine_e_pa: 3e9 };
        let whole = MeshHonesty { rows: vec![Honest { edge: 5e-3, nodes: 4, freedoms: 99, at, loss: 0.1 }] };
        assert_eq!(MeshHonesty::unpack(&whole.pack().unwrap()).unwrap(), whole);
    }
}
