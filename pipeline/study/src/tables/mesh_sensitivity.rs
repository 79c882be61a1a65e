//! Table `mesh_sensitivity`: the effect of locking on identified moduli.

use plot::Column;

use diagnostics::Result;
use records::subject::{Specimen, Study};
use records::{self, MeshResult};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct MeshSensitivity;

impl Table for MeshSensitivity {
    type Of = Study;
    type Needs = Every<records::MeshSensitivity, Specimen>;
    const NAME: &'static str = "mesh_sensitivity";
    const CAPTION: &'static str = "identified moduli depend on the mesh";
    const VERSION: u32 = 3;

    fn fill(Every(sensitivities): Self::Needs) -> Result<plot::Table> {
        let columns = vec![
            Column::text("specimen"),
            Column::text("edge"),
            Column::numbers("nodes an element", ""),
            Column::numbers("dofs", ""),
        ];
        let moduli = [("E of the body", "MPa"), ("E of the spine", "GPa")];
        let pairs = moduli.iter().flat_map(|(title, unit)| Column::beside_published(title, unit));
        let columns = columns.into_iter().chain(pairs).chain([Column::numbers("loss", "")]).collect();
        let rows =
            sensitivities.iter().flat_map(|(s, sensitivity)| sensitivity.rows.iter().map(|r| mesh_row(&s.name(), r)));
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted(
            "Identified on tetrahedra from the levels up to a fraction of the highest pressure, on hexahedra, graded towards thin walls with cells shorter than \
             those of the study, from all. Published: typical values.",
        ))
    }
}

fn mesh_row(specimen: &str, r: &MeshResult) -> Vec<String> {
    vec![
        specimen.to_owned(),
        r.cells.size_text(),
        r.cells.nodes().to_string(),
        r.dofs.to_string(),
        format!("{:.4}", 1e-6 * r.at[0]),
        published_modulus(specimen).to_owned(),
        format!("{:.3}", 1e-9 * r.at[1]),
        "2.5–5".to_owned(),
        format!("{:.2e}", r.loss),
    ]
}

/// Typical Young's moduli of the silicone in the paper's table I, MPa.
fn published_modulus(specimen: &str) -> &'static str {
    match specimen {
        "nemo" | "dory" => "0.1–0.25",
        "bruce" => "1.1",
        _ => "",
    }
}
