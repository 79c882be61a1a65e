//! Table `prototypes`: identified properties of the tails, beside the published column. Paper, table I.

use lab::card::{self, Experiment};
use plot::Column;
use si::MILLIBAR;

use diagnostics::Result;
use records::subject::{Specimen, Study};
use records::{Identified, Mesh};
use workflow::needs::Every;
use workflow::subject::Subject;
use workflow::table::Table;

/// The table.
pub struct Prototypes;

impl Table for Prototypes {
    type Of = Study;
    type Needs = (Every<Identified, Specimen>, Every<Mesh, Specimen>);
    const NAME: &'static str = "prototypes";
    const CAPTION: &'static str = "the tails: measured and published properties";
    const VERSION: u32 = 1;

    fn fill((Every(identifications), Every(meshes)): Self::Needs) -> Result<plot::Table> {
        let quantities = [("E of the body", "MPa"), ("E of the spine", "GPa"), ("cells a side", "")];
        let pairs = quantities.iter().flat_map(|(title, unit)| Column::beside_published(title, unit));
        let columns = [Column::text("specimen"), published_words("material of the body")]
            .into_iter()
            .chain(pairs)
            .chain(Column::beside_published("highest pressure", "bar"))
            .collect();
        let mesh_of = |s: &Specimen| meshes.iter().find(|(owner, _)| owner.name() == s.name()).map(|(_, mesh)| mesh);
        let rows = identifications.iter().map(|(s, identified)| specimen_row(s, identified, mesh_of(s)));
        let table = plot::Table::new(columns, rows.collect())?;
        Ok(table.noted(
            "This study: identified from the films, ± one standard deviation. Published: nominal values of table I.",
        ))
    }
}

fn published_words(title: &str) -> Column {
    Column { published: true, ..Column::text(title) }
}

fn specimen_row(specimen: &Specimen, identified: &Identified, mesh: Option<&Mesh>) -> Vec<String> {
    let [material, body, spine, chambers, pressure] = published_properties(&specimen.name());
    let modulus_text = |name: &str| {
        let modulus = identified.moduli().find(|m| m.solid == name);
        modulus.map_or_else(String::new, |m| format!("{:.3} ± {:.3}", m.best, m.sigma))
    };
    let cells = mesh.map_or_else(String::new, |mesh| cells_a_side(mesh).to_string());
    [
        specimen.name(),
        material.to_owned(),
        modulus_text(card::BODY),
        body.to_owned(),
        modulus_text(card::SPINE),
        spine.to_owned(),
        cells,
        chambers.to_owned(),
        format!("{:.2}", 1e-3 * highest_pressure(specimen)),
        pressure.to_owned(),
    ]
    .into()
}

/// Cells of the first chamber; 0 where there is none.
fn cells_a_side(mesh: &Mesh) -> usize {
    mesh.chambers.first().map_or(0, |chamber| sysid::count_cells(&mesh.solid, chamber.skin))
}

/// The highest commanded pressure of the trials, mbar.
fn highest_pressure(specimen: &Specimen) -> f64 {
    let highest_level = |experiment: &Experiment| match experiment {
        Experiment::Flapping { amplitude, .. } => *amplitude,
        Experiment::Staircase { levels, .. } => levels.iter().copied().fold(0.0, f64::max),
    };
    specimen.card.trial.iter().map(|trial| highest_level(&trial.experiment) / MILLIBAR).fold(0.0, f64::max)
}

/// The paper's table I: silicone, MPa, GPa, chambers, bar.
fn published_properties(specimen: &str) -> [&'static str; 5] {
    match specimen {
        "nemo" => ["Dragon Skin 10", "0.1–0.25", "2.5–5", "9", "0.2"],
        "dory" => ["Dragon Skin 10", "0.1–0.25", "2.5–5", "12", "0.35"],
        "bruce" => ["Dragon Skin 20", "1.1", "2.5–5", "9", "0.5"],
        _ => [""; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_prototypes_are_those_of_the_papers_first_table() {
        // Dragon Skin 20 is the stiffer silicone; the tail of twelve chambers withstands more than that of nine, the stiff one most
        assert_eq!(["nemo", "dory", "bruce"].map(|name| published_properties(name)[3]), ["9", "12", "9"]);
        assert_eq!(["nemo", "dory", "bruce"].map(|name| published_properties(name)[4]), ["0.2", "0.35", "0.5"]);
        assert_eq!(published_properties("bruce")[..2], ["Dragon Skin 20", "1.1"]);
        assert_eq!(published_properties("marlin"), [""; 5]);
    }
}
