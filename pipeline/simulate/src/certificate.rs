//! A certificate of resolution: the same case on cells that are shorter, and by how much its displacements differ there.
//!
//! The difference is an estimate of the error of the first mesh [roache1997]: at second order and cells shorter by 1.5 it is five ninths of
//! it, at higher order more.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use si::{MILLIMETRE, Metre};

use crate::case::{Case, read};
use crate::{RunOptions, Summary, results_folder, simulate_case, stem_of};

/// By how much cells are shorter on the second mesh.
const FINER: f64 = 1.5;

/// The displacement of a node or marker at the last level, on both meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Its name in the case.
    pub name: String,
    /// How far it moves on the mesh of the case, m.
    pub moved: Metre,
    /// Distance of its places on both meshes, m.
    pub apart: Metre,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, moved, apart } = self;
        let [moved_mm, apart_mm] = [moved, apart].map(|length| length / MILLIMETRE);
        let percent = 100.0 * apart / moved.max(f64::MIN_POSITIVE);
        write!(
            f,
            "{name} moves by {moved_mm:.4} mm; on cells shorter by {FINER} it is {apart_mm:.4} mm away, {percent:.2} %"
        )
    }
}

/// Simulates the static case in the file `path` as [`crate::run_with`] does, then on shorter cells, with results in the folder `finer` beside
/// the others.
///
/// # Errors
/// As [`crate::run_with`]; a case that has no finer mesh, no level or no node or marker whose displacements could be compared.
pub fn certify(path: &Path, options: RunOptions) -> Result<(Summary, Vec<Difference>)> {
    let case = read(path)?;
    check_comparable(&case).map_err(|e| e.in_file_unless_named(path))?;
    let folder = results_folder(path, options.out.as_deref());
    let finer = Case { mesh: crate::case::Source { finer: FINER, ..case.mesh.clone() }, ..case.clone() };
    let named = |e: Diagnostic| e.in_file_unless_named(path);
    let summary = simulate_case(&case, path, options.clone()).map_err(named)?;
    let finer_folder = folder.join("finer");
    simulate_case(&finer, path, RunOptions { out: Some(finer_folder.clone()), ..options }).map_err(named)?;
    let table = format!("{}.csv", stem_of(path));
    let [here, there] = [folder.join(&table), finer_folder.join(&table)].map(LastRow::read_from);
    let names =
        case.output.node.iter().map(|node| &node.name).chain(case.output.marker.iter().map(|marker| &marker.name));
    let (here, there) = (here?, there?);
    Ok((summary, names.map(|name| difference_of(name, &here, &there)).collect::<Result<_>>()?))
}

/// Refuses a case without a second mesh to compare with.
fn check_comparable(case: &Case) -> Result<()> {
    const WHAT: &str = "the error of the mesh cannot be estimated";
    if case.mesh.body.is_none() {
        return Err(Diagnostic::new(
            WHAT,
            "the mesh is read from a file, of which there is no finer one",
            "name the surfaces (mesh.body), or simulate a finer mesh of your own beside it",
        ));
    }
    if case.statics.as_ref().is_none_or(|set| set.arc_length.is_some()) {
        let reason = "levels of [static] are compared, not motions and not paths, whose steps differ from mesh to mesh";
        return Err(Diagnostic::new(WHAT, reason, "certify the same loads as levels of [static]"));
    }
    if case.output.node.is_empty() && case.output.marker.is_empty() {
        return Err(Diagnostic::new(WHAT, "the case names no node and no marker", "add an [[output.marker]]"));
    }
    Ok(())
}

/// The last line of a table of results.
struct LastRow {
    path: PathBuf,
    titles: Vec<String>,
    values: Vec<f64>,
}

impl LastRow {
    fn read_from(path: PathBuf) -> Result<Self> {
        let refused = |why: String| Diagnostic::file(&path, "the results cannot be compared", why, "simulate it again");
        let mut reader = csv::Reader::from_path(&path).map_err(|e| refused(e.to_string()))?;
        let titles = reader.headers().map_err(|e| refused(e.to_string()))?.iter().map(str::to_owned).collect();
        let last = reader.records().last().ok_or_else(|| refused("it has no line".into()))?;
        let last = last.map_err(|e| refused(e.to_string()))?;
        let values: std::result::Result<_, _> = last.iter().map(str::parse).collect();
        let values = values.map_err(|e: std::num::ParseFloatError| refused(e.to_string()))?;
        Ok(Self { titles, values, path })
    }

    /// The displacement of a node or marker, m.
    fn displacement_of(&self, name: &str) -> Result<[Metre; 3]> {
        let mut displacement = [0.0; 3];
        for (component, axis) in displacement.iter_mut().zip(["ux", "uy", "uz"]) {
            let title = format!("{name}_{axis}_m");
            let column = self.titles.iter().position(|known| *known == title);
            let value = column.and_then(|column| self.values.get(column)).ok_or_else(|| {
                let problem = format!("the column {title} is missing");
                Diagnostic::file(&self.path, problem, "the table was not written to its end", "simulate it again")
            })?;
            *component = *value;
        }
        Ok(displacement)
    }
}

fn difference_of(name: &str, here: &LastRow, there: &LastRow) -> Result<Difference> {
    let [moved, finer] = [here.displacement_of(name)?, there.displacement_of(name)?];
    let length = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let distance = length([0, 1, 2].map(|k| moved[k] - finer[k]));
    Ok(Difference { name: name.to_owned(), moved: length(moved), apart: distance })
}
