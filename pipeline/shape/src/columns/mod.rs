//! Columns: a body and a sheet, as surfaces, become tetrahedra that stand in columns on the sheet's plane.
//!
//! The outlines of all patches (parts that are a height above the sheet's plane), drawn onto that plane, divide it
//! into regions; above each region every vertical line meets the same patches in the same order. The regions are
//! triangulated and filled as a [`crate::stack`]. Bodies that fold over (two layers without a common order) are refused.
//!
//! Stands on: `stack`, `surface`, `validate`. Never knows: the parametric tail, a material, a file.

mod arrange;
mod chains;
mod error;
mod patches;
mod plane;
mod sequence;
mod symmetry;
#[cfg(test)]
mod tests;

pub use error::MeshError;

use crate::frame::Frame;
use crate::stack::{self, Column, Cycle, Stack};
use crate::surface::components;
use crate::validate::{self, Limits};
use crate::{Report, Shell, Surface, TetMesh};
use arrange::{Graph, arrange};
use chains::{Spacing, respace};
use patches::{Part, Patch, dominant_axis, patches, seams};
use plane::{Plane, triangulate};
use sequence::{Reading, Sequence};
use si::{Metre, Point2};
use std::cmp::Ordering;

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

/// Meshes a body around a plane sheet.
///
/// Chambers are numbered by their centroids: first along the sheet's normal, then along x, y, z. The same surfaces and
/// settings give the same mesh, byte for byte.
///
/// # Errors
/// [`MeshError`], which names the surface and the place.
pub fn mesh(body: &Surface, spine: &Surface, set: &Settings) -> Result<(TetMesh, Report), MeshError> {
    let part = |role, surface| Part::new(surface).map_err(|source| MeshError::Surface { role, source });
    let parts = [part("body", body)?, part("spine", spine)?];
    let frame = dominant_axis(spine);
    let tolerance = set.tolerance * body.length().max(spine.length());
    let patches: Vec<Patch> = parts.iter().enumerate().flat_map(|(i, p)| patches(p, i, frame)).collect();
    let (chambers, cavities) = number_chambers(&parts, frame);
    let half = set.use_symmetry && [body, spine].iter().all(|s| symmetry::is_symmetric(s, tolerance));
    let cut = if half { frame.plan_axis(2) } else { None };

    let plane = plan(&parts, frame, cut, set, tolerance)?;
    let reading = Reading { frame, patches: &patches, chambers: &chambers, tolerance, meant: set.edge / 2.0 };
    let regions = reading.regions(&plane)?;
    let (class, classes) = classes(&patches, &regions);
    let columns = columns(&plane, &regions, &class);
    if columns.is_empty() {
        return Err(MeshError::Nothing);
    }
    let members = members(&patches, &class, classes);
    let height = |vertex: u32, sheet: u32| height(&patches, &members[sheet as usize], plane.points[vertex as usize]);
    let stack = Stack {
        frame,
        plan: &plane.points,
        columns: &columns,
        sheets: classes as usize,
        height: &height,
        edge: set.edge,
        merge: tolerance,
        half: cut.is_some(),
    };
    let made = stack::fill(&stack).map_err(|Cycle { lower, upper }| MeshError::Folded {
        lower: patches[members[lower as usize][0] as usize].place,
        upper: patches[members[upper as usize][0] as usize].place,
    })?;
    let limits = Limits { volume: set.volume_limit, distance: set.distance_limit * set.edge };
    let report = validate::validate(&made, body, spine, &cavities, &limits)?;
    Ok((made, report))
}

/// The chamber of each shell of each part, and the volumes (m³) of the cavities in that order.
///
/// A cavity of the body that has the volume and centroid of a shell of the spine is the spine's bed and no chamber.
fn number_chambers(parts: &[Part; 2], frame: Frame) -> ([Vec<Option<u16>>; 2], Vec<f64>) {
    let mut cavities = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let inner = part.shells.iter().enumerate().filter(|(_, s)| s.volume < 0.0 && !(p == 0 && is_bed(s, &parts[1])));
        cavities.extend(inner.map(|(s, shell)| (shell, p, s)));
    }
    let key = |c: &[f64; 3]| [c[frame.normal], c[0], c[1], c[2]];
    cavities.sort_by(|a, b| {
        let (a, b) = (key(&a.0.centroid), key(&b.0.centroid));
        a.iter().zip(&b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    });
    let mut chambers = [0, 1].map(|p: usize| vec![None; parts[p].shells.len()]);
    cavities.iter().enumerate().for_each(|(k, (_, p, s))| chambers[*p][*s] = Some(k as u16));
    (chambers, cavities.iter().map(|c| -c.0.volume).collect())
}

fn is_bed(cavity: &Shell, spine: &Part) -> bool {
    let size = cavity.volume.abs().cbrt();
    let same = |s: &Shell| {
        let apart = (0..3).map(|k| (s.centroid[k] - cavity.centroid[k]).abs()).fold(0.0, f64::max);
        (s.volume + cavity.volume).abs() < 0.01 * s.volume.abs() && apart < 0.01 * size
    };
    spine.shells.iter().any(same)
}

/// The triangulated plan; where parts are too near for the spacing, outlines are followed more closely.
fn plan(
    parts: &[Part; 2],
    frame: Frame,
    cut: Option<usize>,
    set: &Settings,
    tolerance: Metre,
) -> Result<Plane, MeshError> {
    let seams: Vec<[Point2; 2]> = parts.iter().flat_map(|p| seams(p, frame)).collect();
    let segments = match cut {
        Some(axis) => symmetry::cut(&seams, axis, tolerance),
        None => seams,
    };
    let outlines: Graph = arrange(&segments, tolerance);
    let mut tangled = [0.0; 2];
    for closer in [1.0, 0.5, 0.25, 0.1, 0.02] {
        let spacing = Spacing { edge: set.edge, chord: 0.03 * closer * set.edge, noise: 2.0 * tolerance };
        match triangulate(&respace(&outlines, &spacing), set.edge) {
            Ok(plane) => return Ok(plane),
            Err(at) => tangled = at,
        }
    }
    Err(MeshError::Tangled { at: frame.join(tangled, 0.0), edge: set.edge })
}

/// Patches of body and spine that touch somewhere are one sheet: the sheet of each patch, and their number.
fn classes(patches: &[Patch], regions: &[Option<Sequence>]) -> (Vec<u32>, u32) {
    let levels = regions.iter().flatten().flat_map(|s| &s.levels);
    let links = levels.filter(|l| l.patches.len() == 2).map(|l| [l.patches[0], l.patches[1]]);
    components(patches.len(), links)
}

/// The patches of each sheet, those of the spine first: its surface is the better known one.
fn members(patches: &[Patch], class: &[u32], classes: u32) -> Vec<Vec<u32>> {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); classes as usize];
    (0..patches.len()).for_each(|p| members[class[p] as usize].push(p as u32));
    members.iter_mut().for_each(|m| m.sort_by_key(|&p| (1 - patches[p as usize].part, p)));
    members
}

fn columns(plane: &Plane, regions: &[Option<Sequence>], class: &[u32]) -> Vec<Column> {
    let column = |(corners, region): (&[u32; 3], &u32)| {
        let sequence = regions[*region as usize].as_ref()?;
        let sheets = sequence.levels.iter().map(|l| class[l.patches[0] as usize]).collect();
        Some(Column { corners: *corners, sheets, fills: sequence.fills.clone() })
    };
    plane.triangles.iter().zip(&plane.regions).filter_map(column).collect()
}

/// Height of a sheet from the patch of it that lies nearest in the plan, m.
fn height(patches: &[Patch], members: &[u32], at: Point2) -> Metre {
    let heights = members.iter().map(|&p| patches[p as usize].height(at));
    heights.fold((0.0, f64::INFINITY), |best, h| if h.1 < best.1 { h } else { best }).0
}
