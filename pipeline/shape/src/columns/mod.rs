//! Columns: a body and a sheet, as surfaces, become tetrahedra that stand in columns on the sheet's plane.
//!
//! The outlines of all patches (parts that are a height above the sheet's plane), drawn onto that plane, divide it
//! into regions; above each region every vertical line meets the same patches in the same order. The regions are
//! triangulated and filled as a [`crate::stack`]. Bodies that fold over (two layers without a common order) are refused.
//!
//! Stands on: `stack`, `surface`, `validate`. Never knows: the parametric tail, a material, a file.

mod arrange;
mod chains;
mod chambers;
mod error;
mod patches;
mod plane;
mod sequence;
mod settle;
mod sheets;
pub(crate) mod symmetry;
#[cfg(test)]
mod tests;

pub use error::MeshError;

use crate::frame::Frame;
use crate::stack::{self, Cycle, Stack};
use crate::validate::{self, Limits};
use crate::{Report, Surface, TetMesh};
use arrange::{Graph, arrange};
use chains::{Spacing, respace};
use chambers::Chambers;
use patches::{Part, Patch, dominant_axes, patches, seams};
use plane::{Plane, triangulate};
use sequence::{Reading, Sequence};
use settle::settle;
use sheets::Sheets;
use si::{Metre, Point2};

/// How to mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Target length of edges, m.
    pub edge: Metre,
    /// Mesh only z ≥ 0 when both surfaces are symmetric about z = 0.
    pub use_symmetry: bool,
    /// Distance below which surfaces touch and outlines coincide, as a share of the longest side.
    pub tolerance: f64,
    /// Largest difference between the volumes of surfaces and mesh, as a share.
    pub volume_limit: f64,
    /// Largest distance between surfaces and mesh, as a share of `edge`.
    pub distance_limit: f64,
}

impl Settings {
    /// Edges of a length (m), the half where the surfaces are symmetric, and limits that a sound CAD export keeps.
    pub fn new(edge: Metre) -> Self {
        Self { edge, use_symmetry: true, tolerance: 2e-4, volume_limit: 0.02, distance_limit: 0.2 }
    }
}

/// A surface that bends away from a flat triangle by more than this share of the target length is divided further.
const BEND: f64 = 0.05;
/// Layers thinner than this share of the target length vanish on a line, as they do at a round body's rim: elements that
/// thin would be needles. A sheet that thin altogether fails the check of volumes.
const MERGE: f64 = 0.02;
/// How often triangles over which a surface bends are divided.
const ROUNDS: usize = 3;

/// Meshes a body around a plane sheet.
///
/// Chambers are numbered by their centroids: first those below the sheet (along its normal), then those above, each
/// along x. The same surfaces and settings give the same mesh, byte for byte.
///
/// # Errors
/// [`MeshError`], which names the surface and the place.
pub fn mesh(body: &Surface, spine: &Surface, set: &Settings) -> Result<(TetMesh, Report), MeshError> {
    let part = |role, surface| Part::new(surface).map_err(|source| MeshError::Surface { role, source });
    let [normal, ..] = dominant_axes(spine);
    stand([part("body", body)?, part("spine", spine)?], normal, set)
}

/// Meshes a body without a sheet, in columns along whichever axis it stands on: the one that most of its area looks along, or
/// another where that one fails.
///
/// # Errors
/// [`MeshError`] of the first axis, where no axis serves.
pub fn mesh_alone(body: &Surface, set: &Settings) -> Result<(TetMesh, Report), MeshError> {
    let none = Surface::default();
    let along = |frame| {
        let part = Part::new(body).map_err(|source| MeshError::Surface { role: "body", source })?;
        stand([part, Part::none(&none)], frame, set)
    };
    let [first, second, third] = dominant_axes(body);
    along(first).or_else(|why| along(second).or_else(|_| along(third)).map_err(|_| why))
}

/// Columns of both parts along `frame`'s normal.
fn stand(parts: [Part; 2], frame: Frame, set: &Settings) -> Result<(TetMesh, Report), MeshError> {
    let [body, spine] = parts.each_ref().map(|p| p.surface);
    let tolerance = set.tolerance * body.length().max(spine.length());
    let patches: Vec<Patch> = parts.iter().enumerate().flat_map(|(i, p)| patches(p, i, frame)).collect();
    let chambers = Chambers::new(&parts, frame);
    let half = set.use_symmetry && [body, spine].iter().all(|s| symmetry::is_symmetric(s, tolerance));
    let cut = if half { frame.plan_axis(2) } else { None };

    let outlines = outlines(&parts, frame, cut, tolerance);
    let reading = Reading { frame, patches: &patches, chambers: &chambers.of_shell, tolerance, meant: set.edge / 2.0 };
    let made = build(&outlines, &reading, set, cut.is_some())?;
    let limits = Limits { volume: set.volume_limit, distance: set.distance_limit * set.edge };
    let report = validate::validate(&made, body, spine, &chambers.volumes, &limits)?;
    Ok((made, report))
}

/// All outlines in the plan as one graph.
fn outlines(parts: &[Part; 2], frame: Frame, cut: Option<usize>, tolerance: Metre) -> Graph {
    let seams: Vec<[Point2; 2]> = parts.iter().flat_map(|p| seams(p, frame)).collect();
    match cut {
        Some(axis) => arrange(&symmetry::cut(&seams, axis, tolerance), tolerance),
        None => arrange(&seams, tolerance),
    }
}

/// Triangulates and reads the plan, again with more points where a surface bends, and fills it.
fn build(outlines: &Graph, reading: &Reading, set: &Settings, half: bool) -> Result<TetMesh, MeshError> {
    let mut extra = Vec::new();
    for round in 0.. {
        let plane = plan(outlines, &extra, reading, set)?;
        let regions = reading.regions(&plane)?;
        let sheets = Sheets::new(reading.patches, &regions);
        let bends = sheets.bends(&plane, &regions, BEND * set.edge, 0.4 * set.edge);
        if bends.is_empty() || round == ROUNDS {
            return fill(&plane, &regions, &sheets, reading, set, half);
        }
        extra.extend(bends);
    }
    unreachable!("the loop returns in its last round")
}

fn fill(
    plane: &Plane,
    regions: &[Option<Sequence>],
    sheets: &Sheets,
    reading: &Reading,
    set: &Settings,
    half: bool,
) -> Result<TetMesh, MeshError> {
    let columns = sheets.columns(plane, regions);
    if columns.is_empty() {
        return Err(MeshError::Nothing);
    }
    let stack = Stack {
        frame: reading.frame,
        plan: &plane.points,
        columns: &columns,
        sheets: sheets.count(),
        height: &|vertex, sheet| sheets.height(plane.points[vertex as usize], sheet),
        edge: set.edge,
        merge: reading.tolerance.max(MERGE * set.edge),
        half,
    };
    stack::fill(&stack)
        .map_err(|Cycle { lower, upper }| MeshError::Folded { lower: sheets.place(lower), upper: sheets.place(upper) })
}

/// The triangulated plan; where parts are too near for the spacing, outlines are followed more closely.
fn plan(outlines: &Graph, extra: &[Point2], reading: &Reading, set: &Settings) -> Result<Plane, MeshError> {
    let mut tangled = [0.0; 2];
    for closer in [1.0, 0.5, 0.25, 0.1, 0.02] {
        let spacing = Spacing { edge: set.edge, chord: 0.03 * closer * set.edge, noise: 2.0 * reading.tolerance };
        match triangulate(&respace(outlines, &spacing), extra, set.edge) {
            Ok(mut plane) => {
                settle(&mut plane, outlines, 2.0 * spacing.chord);
                return Ok(plane);
            }
            Err(at) => tangled = at,
        }
    }
    Err(MeshError::Tangled { at: reading.frame.join(tangled, 0.0), edge: set.edge })
}
