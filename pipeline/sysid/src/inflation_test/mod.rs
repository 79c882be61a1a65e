//! Inflation tests: a chamber of a body is inflated in a step and its pressure held, or follows a history. A material that another test identified predicts the
//! motion of the tip and its creep; what the prediction lacks is compared with a fitted modulus, a fitted stiffening, and thicker walls.
//!
//! `page` describes the tests, `recorded` reads the recordings, `body` is the meshed body and its motion, `inflated` its equilibria, `hold` a
//! step of pressure, `carried` the markers, `fits` what each material makes of each recording, `shown` writes table, metrics and figure, and `warnings` finds fits that are none.

mod body;
mod carried;
mod fits;
mod hold;
pub(crate) mod inflated;
pub(crate) mod page;
pub(crate) mod recorded;
mod shown;
mod warnings;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result, input};
use rayon::prelude::*;
use si::Metre;

use crate::identified_materials::file_of;
use crate::{IdentifiedMaterial, IdentifiedMaterials};
use body::Meshed;
use fits::{Bench, Point, Row, start};
pub use page::Page;
use recorded::Recorded;
use simulate::case::{Case, read};

/// The results of a page.
pub struct Report {
    page: Page,
    recorded: Vec<Recorded>,
    rows: Vec<Row>,
    /// Rows of [`Report::rows`] that predict one recording each from the others, by recording, in the order of [`JOINT`].
    left_out: Vec<Vec<usize>>,
}

/// Whether the file `path` is the page of an inflation test.
pub fn is_page(path: &Path) -> bool {
    let text = input::read_text(path, input::PAGE).unwrap_or_default();
    text.parse::<toml::Table>().is_ok_and(|page| page.contains_key("test"))
}

/// Predicts the inflations of the page in the file `path`; recordings are looked for below `root`, the material of the page's source in
/// `out`, or beside the page. Writes a table, metrics and a figure there.
///
/// # Errors
/// A [`diagnostics::Diagnostic`]: the page, a recording, the material, a case or its mesh is refused.
pub fn run(root: &Path, path: &Path, out: Option<&Path>) -> Result<(Report, PathBuf)> {
    evaluate_page(Page::read(path)?, root, path, out).map_err(|refused| refused.in_file_unless_named(path))
}

fn evaluate_page(page: Page, root: &Path, path: &Path, out: Option<&Path>) -> Result<(Report, PathBuf)> {
    let folder = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
    let recorded: Vec<Recorded> =
        page.recording.iter().map(|recording| Recorded::read(&page, recording, root)).collect::<Result<_>>()?;
    let materials = IdentifiedMaterials::read(&folder.join(file_of(&page.material)))?;
    let report = Predictions { page: &page, root, path, folder: &folder }.predict_all(recorded, &materials)?;
    shown::write(&report, &folder)?;
    Ok((report, folder))
}

/// Where everything lies.
struct Predictions<'a> {
    page: &'a Page,
    root: &'a Path,
    path: &'a Path,
    folder: &'a Path,
}

impl Predictions<'_> {
    fn predict_all(&self, recorded: Vec<Recorded>, materials: &IdentifiedMaterials) -> Result<Report> {
        let (page, count) = (self.page, recorded.len());
        let case = read(&self.path.parent().unwrap_or(Path::new(".")).join(&page.case))?;
        let mesh = |section: f64| Meshed::new(page, &case, &self.surface_folder(&case)?, (section, self.folder));
        std::fs::create_dir_all(self.folder)
            .map_err(|e| Diagnostic::io(self.folder, e, "name another folder with --out"))?;
        let body = mesh(1.0)?;
        let bench = Bench { page, recorded: &recorded, body: &body };
        let (supported, chosen) = (materials.law(None)?, materials.law(page.law.as_deref())?);
        let mut rows = vec![bench.row(&format!("{}, {}", page.material, supported.name), supported.clone(), &body)?];
        if chosen != supported {
            rows.push(bench.row(&format!("{}, {}", page.material, chosen.name), chosen.clone(), &body)?);
        }
        for section in &page.sections {
            let name = format!("{}, {}, sections scaled by {section}", page.material, chosen.name);
            rows.push(bench.row(&name, chosen.clone(), &mesh(*section)?)?);
        }
        let fitted: Vec<usize> = (0..count).filter(|k| page.recording[*k].fitted).collect();
        let modulus = bench.fit(chosen, &fitted, bench.linearised(chosen, (start(chosen, 1), 1), &fitted)?)?;
        rows.push(bench.fitted("modulus fitted", (chosen, &modulus), &fitted)?);
        let mut left_out = vec![Vec::new(); count];
        if count > 1 {
            let mut start_point = start(chosen, 2);
            for (free, name) in JOINT.into_iter().take(if page.settling.is_some() { 2 } else { 1 }) {
                start_point = cross_validated(&bench, (chosen, name), (start_point, free), (&mut rows, &mut left_out))?;
            }
        }
        Ok(Report { page: page.clone(), recorded, rows, left_out })
    }

    /// The folder of the case's surface or mesh: beside the page, or one of the page's folders.
    fn surface_folder(&self, case: &Case) -> Result<PathBuf> {
        let page_folder = self.path.parent().unwrap_or(Path::new(".")).to_owned();
        let folders = self.page.folders.iter().map(|folder| self.root.join(folder));
        let candidates: Vec<PathBuf> = std::iter::once(page_folder).chain(folders).collect();
        candidates.iter().find(|folder| folder.join(case.mesh.name()).is_file()).cloned().ok_or_else(|| {
            let searched: Vec<String> = candidates.iter().map(|folder| folder.display().to_string()).collect();
            let message = format!("the surface {} is not there", case.mesh.name());
            Diagnostic::new(message, format!("searched {}", searched.join(", ")), "put it into one of these folders")
        })
    }
}

/// What is fitted to several recordings together: the number of free parameters, and its name. What is missing of the pressure at first
/// is fitted where the page says how it settles.
const JOINT: [(usize, &str); 2] =
    [(2, "modulus and stiffening fitted"), (3, "modulus, stiffening and missing pressure fitted")];

/// The rows of a joint fit from `start` on, of so many free parameters: to all recordings, and to all but each one to which the modulus alone
/// was not fitted, which is then predicted by the row that is added to `left_out`. Returns the point of all.
fn cross_validated(
    bench: &Bench,
    (material, name): (&IdentifiedMaterial, &str),
    start: (Point, usize),
    (rows, left_out): (&mut Vec<Row>, &mut [Vec<usize>]),
) -> Result<Point> {
    let every: Vec<usize> = (0..left_out.len()).collect();
    let joint = bench.fit(material, &every, bench.linearised(material, start, &every)?)?;
    rows.push(bench.fitted(name, (material, &joint), &every)?);
    let predict = |k: usize| {
        let remaining: Vec<usize> = every.iter().copied().filter(|recording| *recording != k).collect();
        // From the end of the joint fit with its Jacobian: a motion under a history costs ten seconds for each parameter and recording.
        let end = bench.fit(material, &remaining, joint.only(&remaining))?;
        Ok((k, bench.fitted(name, (material, &end), &remaining)?))
    };
    let omitted: Vec<usize> = every.iter().copied().filter(|k| !bench.page.recording[*k].fitted).collect();
    for (k, row) in omitted.into_par_iter().map(predict).collect::<Result<Vec<_>>>()? {
        left_out[k].push(rows.len());
        rows.push(row);
    }
    Ok(joint.at)
}

impl Report {
    /// The thickness of the walls with which the sections' row of the same material would show the measured displacement of recording
    /// `k`, m: linear in its logarithm between two rows; none where no two enclose it.
    fn explaining_wall(&self, k: usize) -> Option<Metre> {
        let chosen = self.rows.iter().rev().find(|row| row.used.is_empty()).map(|row| &row.material)?;
        let section_rows = self.rows.iter().filter(|row| row.used.is_empty() && row.material == *chosen);
        let wall_and_ratio = |row: &Row| {
            let ratio = row.predictions[k].features?.early / self.recorded[k].features.early;
            (ratio > 0.0).then(|| Some((row.wall?, ratio.ln())))?
        };
        let mut walls: Vec<(Metre, f64)> = section_rows.filter_map(wall_and_ratio).collect();
        walls.sort_by(|a, b| a.0.total_cmp(&b.0));
        let crossing = walls.windows(2).find(|pair| pair[0].1 * pair[1].1 <= 0.0)?;
        let part = crossing[0].1 / (crossing[0].1 - crossing[1].1);
        Some(crossing[0].0 + part * (crossing[1].0 - crossing[0].0))
    }
}

#[cfg(test)]
pub(crate) mod tests;
