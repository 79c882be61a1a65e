//! Meshing of bodies of any shape, by the crate `tetrahedralize`: no plan, no order of layers.

use crate::foreign::RawMesh;
use crate::validate::{self, Limits, Reference};
use crate::{MeshError, Report, Settings, Solid, Surface, TetMesh};
use tetrahedralize::{Fill, Part, tetrahedralize};

/// Meshes a body, and the sheet in it if it has one, whatever its shape. Only whole bodies are meshed.
///
/// Chambers are numbered along x, y, z of their centroids, as those of mesh files are.
///
/// # Errors
/// [`MeshError`], which names the part and the place; before anything is made, when that would take too much memory.
pub(crate) fn mesh_general(
    body: &Surface,
    spine: Option<&Surface>,
    set: &Settings,
) -> Result<(TetMesh, Report), MeshError> {
    let parts: Vec<Part> = [Some(body), spine].into_iter().flatten().zip(0..).map(|(s, r)| part(s, r)).collect();
    let tetrahedra = tetrahedralize(&parts, &tetrahedralize::Settings::new(set.edge))?;
    let repairs = tetrahedra.repairs.iter().map(ToString::to_string).collect();
    let raw = RawMesh::of_tetrahedra(tetrahedra.nodes, &tetrahedra.tets, &tetrahedra.regions);
    let mesh = match raw.check(1.0, false).map_err(|defect| MeshError::Defect { message: defect.to_string() })?.solid {
        Solid::Linear(mesh) => mesh,
        Solid::Quadratic(mesh) => Solid::Quadratic(mesh).to_linear(),
    };
    let report = report(&mesh, (body, spine), set)?;
    Ok((mesh, Report { repairs, ..report }))
}

fn part(surface: &Surface, region: u16) -> Part {
    Part { points: surface.points.clone(), faces: surface.faces.clone(), fill: Fill::Region(region) }
}

/// Compares the mesh with its surfaces; the volumes only where these are closed.
fn report(mesh: &TetMesh, (body, spine): (&Surface, Option<&Surface>), set: &Settings) -> Result<Report, MeshError> {
    let none = Surface::default();
    let solid = Solid::Linear(mesh.clone());
    let cavities: Vec<f64> = crate::cavities(&solid).iter().map(|cavity| cavity.volume).collect();
    let closed = body.shells().ok().filter(|_| spine.is_none_or(|s| s.shells().is_ok()));
    if let (Some((shells, _)), None) = (&closed, spine) {
        let expected = shells.iter().filter(|shell| shell.volume < 0.0).count();
        if expected != cavities.len() {
            return Err(MeshError::Chambers { expected, found: cavities.len() });
        }
    }
    let volume = if closed.is_some() { set.volume_limit } else { f64::INFINITY };
    let limits = Limits { volume, distance: set.distance_limit * set.edge };
    let reference = Reference { body, spine: spine.unwrap_or(&none), cavities: &cavities };
    Ok(validate::validate(mesh, &reference, &limits)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};

    #[test]
    fn a_box_with_a_cavity_is_filled_and_its_chamber_is_named() {
        let body = with_cavity(block([0.0; 3], [0.03, 0.02, 0.02]), [0.004; 3], [0.02, 0.016, 0.016]);
        let (mesh, report) = mesh_general(&body, None, &Settings::new(4e-3)).unwrap();
        assert_eq!(mesh.chambers(), 1);
        assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 1e-3);
        assert!(report.min_dihedral_deg > 5.0 && report.hausdorff_m < 2e-4);
    }

    #[test]
    fn a_body_around_a_sheet_has_two_regions_with_a_common_face() {
        let sheet = [[0.005, 0.008, 0.004], [0.025, 0.012, 0.016]];
        let body = with_cavity(block([0.0; 3], [0.03, 0.02, 0.02]), sheet[0], sheet[1]);
        let (_, report) = mesh_general(&body, Some(&block(sheet[0], sheet[1])), &Settings::new(4e-3)).unwrap();
        assert!((report.volume_spine / 9.6e-7 - 1.0).abs() < 1e-3);
        assert!((report.interface_area / 7.36e-4 - 1.0).abs() < 1e-3);
    }
}
