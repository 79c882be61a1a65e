//! Table `mesh_honesty`: what locking does to a modulus.
//!
//! Stands on: plot. Never knows: how a number was computed.

use plot::Column;

use crate::fault::{Fault, Outcome};
use crate::needs::Every;
use crate::records::{self, Honest};
use crate::subject::Scope;
use crate::table::Table;

/// The table.
pub struct MeshHonesty;

impl Table for MeshHonesty {
    type Needs = Every<records::MeshHonesty>;
    const NAME: &'static str = "mesh_honesty";
    const SHOWS: &'static str = "the same films tell other meshes other moduli";
    const EDITION: u32 = 2;

    fn fill(Every(all): Self::Needs) -> Outcome<plot::Table> {
        let columns = vec![
            Column::words("specimen"),
            Column::numbers("edge", "mm"),
            Column::numbers("nodes an element", ""),
            Column::numbers("freedoms", ""),
        ];
        let moduli = [("E of the body", "MPa"), ("E of the spine", "GPa")];
        let pairs = moduli.iter().flat_map(|(title, unit)| Column::beside_published(title, unit));
        let columns = columns.into_iter().chain(pairs).chain([Column::numbers("loss", "")]).collect();
        let rows = all.iter().flat_map(|(s, honest)| honest.rows.iter().map(|r| row(&s.name(), r)));
        let table = plot::Table::new(columns, rows.collect()).map_err(Fault::from_tool)?;
        Ok(table.noted(
            "Levels up to a part of the highest pressure, identified anew with each mesh. Published: typical values.",
        ))
    }
}

fn row(specimen: &str, r: &Honest) -> Vec<String> {
    vec![
        specimen.to_owned(),
        format!("{:.1}", 1e3 * r.edge),
        r.nodes.to_string(),
        r.freedoms.to_string(),
        format!("{:.4}", 1e-6 * r.at.body_e_pa),
        published(specimen).to_owned(),
        format!("{:.3}", 1e-9 * r.at.spine_e_pa),
        "2.5–5".to_owned(),
        format!("{:.2e}", r.loss),
    ]
}

/// Typical Young's moduli of the silicone in the paper's table I, MPa.
fn published(specimen: &str) -> &'static str {
    match specimen {
        "nemo" | "dory" => "0.1–0.25",
        "bruce" => "1.1",
        _ => "",
    }
}
