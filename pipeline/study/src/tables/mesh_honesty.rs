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
    const EDITION: u32 = 1;

    fn fill(Every(all): Self::Needs) -> Outcome<plot::Table> {
        let columns = vec![
            Column::words("specimen"),
            Column::numbers("edge", "mm"),
            Column::numbers("nodes an element", ""),
            Column::numbers("freedoms", ""),
            Column::numbers("E of the body", "MPa"),
            Column::numbers("E of the spine", "GPa"),
            Column::numbers("loss", ""),
        ];
        let rows = all.iter().flat_map(|(s, honest)| honest.rows.iter().map(|r| row(&s.name(), r)));
        let table = plot::Table::new(columns, rows.collect()).map_err(Fault::from_tool)?;
        Ok(table.noted("Levels up to a part of the highest pressure, identified anew with each mesh."))
    }
}

fn row(specimen: &str, r: &Honest) -> Vec<String> {
    vec![
        specimen.to_owned(),
        format!("{:.1}", 1e3 * r.edge),
        r.nodes.to_string(),
        r.freedoms.to_string(),
        format!("{:.4}", 1e-6 * r.at.body_e_pa),
        format!("{:.3}", 1e-9 * r.at.spine_e_pa),
        format!("{:.2e}", r.loss),
    ]
}
