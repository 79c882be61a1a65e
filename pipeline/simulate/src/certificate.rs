//! How far a case is from converged: the same case on cells of another length, and by how much its displacements differ there.
//!
//! The difference to *shorter* cells is a certificate [roache1997]: at second order and cells shorter by 1.5 it is five ninths of the error of the
//! case's own mesh, at higher order more. It costs three to six times the case. The difference to *longer* cells is an estimate for a quarter of the
//! case, and is made without being asked for: at second order it is 1.25 of the error.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use mesh::ElementName;
use si::{MILLIMETRE, Metre};

use crate::case::{Case, Source, read};
use crate::console::Console;
use crate::{Loaded, RunOptions, Summary, load_beside, results_folder, simulate_loaded, stem_of};

/// By how much cells of the second mesh are shorter, or longer.
const STEP: f64 = 1.5;
/// A second mesh with more nodes than this part of the first has no longer cells to speak of, as walls and ribs allow none, and costs as much.
const ALIKE: f64 = 0.7;

/// The displacement of a node or marker at the last level, on both meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Its name in the case.
    pub name: String,
    /// How far it moves on the mesh of the case, m.
    pub moved: Metre,
    /// Distance of its places on both meshes, m.
    pub apart: Metre,
    /// Whether cells of the second mesh are shorter.
    pub is_finer: bool,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, moved, apart, is_finer } = self;
        let [moved_mm, apart_mm] = [moved, apart].map(|length| length / MILLIMETRE);
        let percent = 100.0 * apart / moved.max(f64::MIN_POSITIVE);
        let (length, meaning) = match is_finer {
            true => ("shorter", ""),
            false => ("longer", ": about so far it is from converged"),
        };
        write!(
            f,
            "{name} moves by {moved_mm:.4} mm; on cells {length} by {STEP} it is {apart_mm:.4} mm away, {percent:.2} %{meaning}"
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
    let named = |e: Diagnostic| e.in_file_unless_named(path);
    check_comparable(&case).map_err(named)?;
    let solved = Solved::new(&case, path, options).map_err(named)?;
    let differences = solved.differences(true).map_err(named)?;
    Ok((solved.summary, differences))
}

/// Simulates the case in the file `path` as [`crate::run_with`] does. Of a body that was meshed from surfaces it is then said how far its results
/// are from converged, or why that is not known; that is not asked where the options are quiet.
///
/// # Errors
/// As [`crate::run_with`].
pub fn run_with_estimate(path: &Path, options: RunOptions) -> Result<Summary> {
    let named = |e: Diagnostic| e.in_file_unless_named(path);
    let case = read(path)?;
    let is_asked = case.mesh.body.is_some() && !options.quiet;
    let solved = Solved::new(&case, path, options).map_err(named)?;
    if is_asked {
        let console = Console::new(&stem_of(path), false);
        match check_comparable(&case).and_then(|()| solved.differences(false)) {
            Ok(differences) => differences.iter().for_each(|difference| console.print_line(&difference.to_string())),
            Err(why) => {
                console.print_line(&format!("how far it is from converged is not known: {}; {}", why.why, why.action))
            }
        }
    }
    Ok(solved.summary)
}

/// A case that was solved on its own mesh.
struct Solved<'a> {
    case: &'a Case,
    path: &'a Path,
    options: RunOptions,
    loaded: Loaded,
    summary: Summary,
}

impl<'a> Solved<'a> {
    fn new(case: &'a Case, path: &'a Path, options: RunOptions) -> Result<Self> {
        let loaded = load_beside(case, path)?;
        let summary = simulate_loaded(case, &loaded, path, options.clone())?;
        Ok(Self { case, path, options, loaded, summary })
    }

    /// Solves it on shorter or longer cells of the same kind, with results in a folder of their own beside the others, and compares.
    fn differences(&self, is_finer: bool) -> Result<Vec<Difference>> {
        let Self { case, path, options, .. } = self;
        let (finer, name) = if is_finer { (STEP, "finer") } else { (1.0 / STEP, "coarser") };
        let is_hexahedral = self.loaded.solid.is_hexahedral();
        let kind = if is_hexahedral { ElementName::Hexahedra } else { ElementName::Tetrahedra };
        let second = Case { mesh: Source { finer, elements: Some(kind), ..case.mesh.clone() }, ..Case::clone(case) };
        let second_mesh = load_beside(&second, path)?;
        let [nodes, second_nodes] = [&self.loaded, &second_mesh].map(|mesh| mesh.solid.nodes().len() as f64);
        if !is_finer && second_nodes > ALIKE * nodes {
            let reason = "walls and ribs allow no cells long enough to compare with";
            return Err(Diagnostic::new(WHAT, reason, "--certify compares with shorter ones"));
        }
        let folder = results_folder(path, options.out.as_deref());
        let out = folder.join(name);
        let quiet = options.quiet || !is_finer;
        simulate_loaded(&second, &second_mesh, path, RunOptions { out: Some(out.clone()), quiet, ..options.clone() })?;
        let table = format!("{}.csv", stem_of(path));
        let (first, second) = (LastRow::read_from(folder.join(&table))?, LastRow::read_from(out.join(&table))?);
        let nodes = case.output.node.iter().map(|node| &node.name);
        let names = nodes.chain(case.output.marker.iter().map(|marker| &marker.name));
        names.map(|name| difference_between(name, &first, &second, is_finer)).collect()
    }
}

const WHAT: &str = "the error of the mesh cannot be estimated";

/// Refuses a case without a second mesh to compare with.
fn check_comparable(case: &Case) -> Result<()> {
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

fn difference_between(name: &str, first: &LastRow, second: &LastRow, is_finer: bool) -> Result<Difference> {
    let [here, there] = [first.displacement_of(name)?, second.displacement_of(name)?];
    let length = |vector: [f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = length([0, 1, 2].map(|k| here[k] - there[k]));
    Ok(Difference { name: name.to_owned(), moved: length(here), apart, is_finer })
}
