//! Meshing of bodies of any shape, by the crate `tetrahedralize`: no plan, no order of layers.
//!
//! A mesh is judged by its angles and its distance from the surfaces. Where it misses what is aimed at it is made again with another lattice or a
//! closer envelope, and the best one is taken: operations that keep validity promise no quality, and another start mostly reaches it.

use crate::closing::{Repairs, closed_surface};
use crate::columns::check_size;
use crate::curving::{Curving, curve_middles};
use crate::foreign::RawMesh;
use crate::quality::dihedral_quantile;
use crate::validate::{self, Limits, Reference};
use crate::visibility::Visibility;
use crate::{Assembly, Detail, MeshError, QuadraticMesh, Report, Settings, Solid, Surface, TetMesh, quadratic};
use si::Metre;
use tetrahedralize::tetrahedralize_watched;

/// Gaps are welded that are narrower than this part of the envelope: wider ones may be slits.
const SEAM: f64 = 0.25;
/// Times that a body is meshed.
const ATTEMPTS: usize = 3;
/// The smallest angle of all elements and of all but one in a thousand that are aimed at, degrees.
const LEAST_ANGLE: f64 = 1.0;
const USUAL_ANGLE: f64 = 5.0;
/// A further attempt is worth its time where the last one came nearer by this factor, or misses by little.
const WORTH: f64 = 0.95;
const LITTLE: f64 = 1.1;
/// Edge of the next lattice over the last one's.
// A lattice a little finer moves against the surfaces everywhere, and takes a quarter more elements; half the edge
// would take eight times as many.
const OTHER_LATTICE: f64 = 0.93;

/// A mesh with its report, and how far it misses what is aimed at: 1 and less where it does not.
struct Candidate {
    mesh: TetMesh,
    report: Report,
    miss: f64,
}

/// Meshes a body with its inserts and cavities, whatever their shapes. Only whole bodies are meshed. `watch` hears of each step.
///
/// Chambers are numbered along x, y, z of their centroids, as those of mesh files are.
///
/// # Errors
/// [`MeshError`], which names the part and the place; before anything is made, when that would take too much memory.
pub(crate) fn mesh_general(
    assembly: &Assembly,
    set: &Settings,
    watch: &dyn Fn(&str),
) -> Result<(QuadraticMesh, Report, Curving), MeshError> {
    let request = general_settings(set);
    let closed = ClosedParts::of_assembly(assembly, SEAM * request.envelope);
    let assembly = &closed.assembly();
    let parts = assembly.inserts.iter().map(|s| ("insert", *s)).chain(assembly.cavities.iter().map(|s| ("cavity", *s)));
    let named: Vec<(&'static str, &Surface)> = std::iter::once(("body", assembly.body)).chain(parts).collect();
    check_size(&named, set)?;
    let visible = assembly.visibility(set.edge);
    let chosen = best_candidate((assembly, visible.as_ref()), set, request, watch)?;
    let mut solid = quadratic(&chosen.mesh);
    let cavities: Vec<Surface> = assembly.cavities.iter().map(|cavity| turned_surface(cavity)).collect();
    let targets: Vec<&Surface> = assembly.solids().chain(&cavities).collect();
    // corners lie off a crease by the envelope at most; those of the last attempt's, which may be wider, by little more
    let curving = curve_middles(&mut solid, &targets, 2.0 * request.envelope);
    Ok((solid, closed.with_repairs(chosen.report), curving))
}

fn general_settings(set: &Settings) -> tetrahedralize::Settings {
    let usual = tetrahedralize::Settings::new(set.edge);
    let Detail { envelope, smallest, layers } = set.detail;
    tetrahedralize::Settings {
        envelope: envelope.unwrap_or(usual.envelope),
        least: smallest.unwrap_or(usual.least),
        aspect: layers.map_or(usual.aspect, |count| 1.0 / f64::from(count)),
        ..usual
    }
}

/// The first mesh that misses nothing, or the best of all attempts.
fn best_candidate(
    (assembly, visible): (&Assembly, Option<&Visibility>),
    set: &Settings,
    mut request: tetrahedralize::Settings,
    watch: &dyn Fn(&str),
) -> Result<Candidate, MeshError> {
    let (aim, mut best, mut refusal) = (request.envelope, None::<Candidate>, None);
    for attempt in 0..ATTEMPTS {
        if attempt > 0 {
            watch(&format!(
                "once more with edges of {:.3} mm and an envelope of {:.4} mm",
                request.edge * 1e3,
                request.envelope * 1e3
            ));
        }
        match mesh_candidate((assembly, visible), set, &request, watch) {
            Ok(latest) if latest.miss <= 1.0 => return Ok(latest),
            Ok(latest) => {
                request = closer_settings(request, latest.report.hausdorff_m / aim);
                let former_miss = best.as_ref().map_or(f64::INFINITY, |b| b.miss);
                let is_promising = latest.miss < (WORTH * former_miss).max(LITTLE);
                if latest.miss < former_miss {
                    best = Some(latest);
                }
                if !is_promising {
                    break;
                }
            }
            // no other lattice changes what these say
            Err(why @ MeshError::General(_)) => return Err(why),
            Err(why) => {
                refusal.get_or_insert(why);
                request = closer_settings(request, 1.0);
            }
        }
    }
    best.ok_or_else(|| refusal.unwrap_or(MeshError::Nothing))
}

/// The surfaces of an assembly with their gaps and holes closed, and what was done.
struct ClosedParts {
    body: Surface,
    inserts: Vec<Surface>,
    cavities: Vec<Surface>,
    repairs: Repairs,
}

impl ClosedParts {
    /// With gaps up to `tolerance` (m) welded.
    fn of_assembly(assembly: &Assembly, tolerance: Metre) -> Self {
        let mut repairs = Repairs::new();
        let mut closed = |surface: &&Surface| match closed_surface(surface, tolerance) {
            Some((closed, lines)) => {
                repairs.extend(lines);
                closed
            }
            None => (*surface).clone(),
        };
        let body = closed(&assembly.body);
        let inserts = assembly.inserts.iter().map(&mut closed).collect();
        let cavities = assembly.cavities.iter().map(&mut closed).collect();
        Self { body, inserts, cavities, repairs }
    }

    fn assembly(&self) -> Assembly<'_> {
        let (inserts, cavities) = (self.inserts.iter().collect(), self.cavities.iter().collect());
        Assembly { body: &self.body, inserts, cavities }
    }

    /// A report that begins with what was closed.
    fn with_repairs(&self, report: Report) -> Report {
        Report { repairs: self.repairs.iter().cloned().chain(report.repairs).collect(), ..report }
    }
}

/// Settings of another attempt, after one whose distance was so many times the one aimed at.
fn closer_settings(request: tetrahedralize::Settings, distance: f64) -> tetrahedralize::Settings {
    match distance > 1.0 {
        // Closer than in proportion, so that the next attempt does not end on the limit.
        true => tetrahedralize::Settings { envelope: 0.93 * request.envelope / distance, ..request },
        false => tetrahedralize::Settings { edge: OTHER_LATTICE * request.edge, ..request },
    }
}

fn mesh_candidate(
    (assembly, visible): (&Assembly, Option<&Visibility>),
    set: &Settings,
    request: &tetrahedralize::Settings,
    watch: &dyn Fn(&str),
) -> Result<Candidate, MeshError> {
    let tetrahedra = tetrahedralize_watched(&assembly.parts(), request, watch)?;
    let repairs = tetrahedra.repairs.iter().map(ToString::to_string).collect();
    let raw = RawMesh::of_tetrahedra(tetrahedra.nodes, &tetrahedra.tets, &tetrahedra.regions);
    let mesh = match raw.check(1.0, false).map_err(|defect| MeshError::Defect { message: defect.to_string() })?.solid {
        Solid::Linear(mesh) => mesh,
        Solid::Quadratic(mesh) => Solid::Quadratic(mesh).to_linear(),
    };
    let report = Report { repairs, ..candidate_report(&mesh, (assembly, visible), set)? };
    let aim = general_settings(set).envelope;
    let angles = (LEAST_ANGLE / report.min_dihedral_deg).max(USUAL_ANGLE / dihedral_quantile(&mesh, 1e-3));
    let miss = angles.max(report.hausdorff_m / aim);
    Ok(Candidate { mesh, report, miss })
}

/// Compares the mesh with its surfaces; the volumes only where these are closed.
fn candidate_report(
    mesh: &TetMesh,
    (assembly, visible): (&Assembly, Option<&Visibility>),
    set: &Settings,
) -> Result<Report, MeshError> {
    let solid = Solid::Linear(mesh.clone());
    let cavities: Vec<f64> = crate::cavities(&solid).iter().map(|cavity| cavity.volume).collect();
    if let ([], [], Ok((shells, _))) =
        (assembly.inserts.as_slice(), assembly.cavities.as_slice(), assembly.body.shells())
    {
        let expected = shells.iter().filter(|shell| shell.volume < 0.0).count();
        if expected != cavities.len() {
            return Err(MeshError::Chambers { expected, found: cavities.len() });
        }
    }
    // a cavity's surface is one of the body's, seen from the other side
    let cavity_faces: Vec<Surface> = assembly.cavities.iter().map(|cavity| turned_surface(cavity)).collect();
    let body = joined_surface(std::iter::once(assembly.body).chain(&cavity_faces));
    let inserts = joined_surface(assembly.inserts.iter().copied());
    let limits = Limits { volume: f64::INFINITY, distance: set.distance_limit * set.edge };
    let report = validate::validate_mesh(
        mesh,
        &Reference { body: &body, spine: &inserts, cavities: &cavities, visible },
        &limits,
    )?;
    for (region, expected) in assembly.expected_volumes().into_iter().enumerate() {
        check_volume(mesh, (region as u16, expected), set.volume_limit)?;
    }
    Ok(report)
}

/// A surface whose normals look the other way.
fn turned_surface(surface: &Surface) -> Surface {
    let faces = surface.faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    Surface { points: surface.points.clone(), faces }
}

/// Surfaces as one.
fn joined_surface<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> Surface {
    let mut joined = Surface::default();
    for surface in surfaces {
        let first = joined.points.len() as u32;
        joined.points.extend(&surface.points);
        joined.faces.extend(surface.faces.iter().map(|f| f.map(|n| n + first)));
    }
    joined
}

fn check_volume(mesh: &TetMesh, (region, expected): (u16, Option<f64>), limit: f64) -> Result<(), MeshError> {
    let Some(expected) = expected else { return Ok(()) };
    let volume = mesh.region_volume(region);
    let difference = (volume / expected - 1.0).abs();
    if difference <= limit {
        return Ok(());
    }
    let part = if region == 0 { "body".to_owned() } else { format!("insert {region}") };
    Err(MeshError::Invalid(validate::ValidationError::Volume {
        part,
        mesh_mm3: volume * 1e9,
        surface_mm3: expected * 1e9,
        percent: 100.0 * difference,
        limit_percent: 100.0 * limit,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surface;
    use crate::surface::tests::{block, with_cavity};

    #[test]
    fn a_box_with_a_cavity_is_filled_and_its_chamber_is_named() {
        let body = with_cavity(block([0.0; 3], [0.03, 0.02, 0.02]), [0.004; 3], [0.02, 0.016, 0.016]);
        let (solid, report, _) = mesh_general(&Assembly::of_body(&body, None), &Settings::new(4e-3), &|_| ()).unwrap();
        assert_eq!(solid.into_corners().chambers(), 1);
        assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 1e-3);
        assert!(report.min_dihedral_deg > 5.0 && report.hausdorff_m < 2e-4);
    }

    #[test]
    fn a_plate_has_as_many_elements_through_it_as_are_asked_for_and_no_edges_below_the_shortest() {
        let plate = block([0.0; 3], [0.03, 0.02, 0.002]);
        let meshed = |detail: Detail| {
            let set = Settings { detail, ..Settings::new(5e-3) };
            mesh_general(&Assembly::of_body(&plate, None), &set, &|_| ()).unwrap().0.into_corners()
        };
        let inside = |mesh: &TetMesh| mesh.nodes.iter().filter(|p| p[2] > 2e-4 && p[2] < 1.8e-3).count();
        let (usual, two) = (meshed(Detail::default()), meshed(Detail { layers: Some(2), ..Detail::default() }));
        let limited = meshed(Detail { layers: Some(2), smallest: Some(4e-3), ..Detail::default() });
        let counts = [&usual, &two, &limited].map(|mesh| mesh.tets.len());
        assert!(inside(&usual) < 30 && inside(&two) > 300, "{} {}", inside(&usual), inside(&two));
        assert!(counts[1] > 8 * counts[0] && counts[2] < 2 * counts[0], "{counts:?}");
    }

    #[test]
    fn a_body_around_a_sheet_has_two_regions_with_a_common_face() {
        let sheet = [[0.005, 0.008, 0.004], [0.025, 0.012, 0.016]];
        let body = with_cavity(block([0.0; 3], [0.03, 0.02, 0.02]), sheet[0], sheet[1]);
        let spine: Surface = block(sheet[0], sheet[1]);
        let set = Settings::new(4e-3);
        let report = mesh_general(&Assembly::of_body(&body, Some(&spine)), &set, &|_| ()).unwrap().1;
        assert!((report.volume_spine / 9.6e-7 - 1.0).abs() < 1e-3);
        assert!((report.interface_area / 7.36e-4 - 1.0).abs() < 1e-3);
    }
}
