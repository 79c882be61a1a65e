//! Validation: quality of a mesh, its volumes and its distance from the surfaces, each against a limit.

use crate::distance::Nearest;
use crate::quality::dihedral_range;
use crate::tetrahedra::FACES;
use crate::visibility::{Visibility, face_samples};
use crate::{BODY, SPINE, Skin, Surface, TetMesh, quadratic};
use si::vec3::{cross, dot, norm, sub};
use si::{CubicMetre, Metre, Point3, SquareMetre};

/// A cavity, whole even when only its half is meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct Chamber {
    /// Centroid, m.
    pub centroid: Point3,
    /// Volume, m³.
    pub volume: CubicMetre,
}

/// Quality and volumes of a mesh. Volumes and areas are those of the whole body, even when only the half is meshed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Corner nodes.
    pub nodes: usize,
    /// Elements.
    pub tets: usize,
    /// Nodes of the quadratic mesh.
    pub quadratic_nodes: usize,
    /// Smallest angle between two faces of an element, degrees.
    pub min_dihedral_deg: f64,
    /// Largest angle between two faces of an element, degrees.
    pub max_dihedral_deg: f64,
    /// Largest distance between the surfaces and the mesh's boundaries, sampled both ways, m.
    pub hausdorff_m: Metre,
    /// Volume of the body's elements, m³.
    pub volume_body: CubicMetre,
    /// Volume of the spine's elements, m³.
    pub volume_spine: CubicMetre,
    /// Volume of the body's surface, m³.
    pub volume_body_stl: CubicMetre,
    /// Volume of the spine's surface, m³.
    pub volume_spine_stl: CubicMetre,
    /// Area where body and spine touch, m².
    pub interface_area: SquareMetre,
    /// The cavities, in the order of [`Skin::Chamber`].
    pub chambers: Vec<Chamber>,
    /// Whether only z ≥ 0 is meshed.
    pub half: bool,
    /// What the general method changed of the surfaces, a sentence each.
    pub repairs: Vec<String>,
}

/// A mesh that fails the validation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ValidationError {
    /// An element without volume.
    #[error(
        "element {tet} of the mesh has a volume of {volume_mm3:.3e} mm³\n  why: it must be positive\n  do:  take another edge length; the mesh cannot be used"
    )]
    InvertedElement {
        /// Which element.
        tet: usize,
        /// Its volume, mm³.
        volume_mm3: f64,
    },
    /// A volume that differs from the surface's.
    #[error(
        "the mesh's {part} has {mesh_mm3:.1} mm³ where the surface encloses {surface_mm3:.1} mm³\n  why: it differs by {percent:.2} %; the limit is {limit_percent:.2} % of the surface's\n  do:  take a shorter edge, or the method general; or look for a part thinner than the tolerance"
    )]
    Volume {
        /// Which part.
        part: String,
        /// Volume in the mesh, mm³.
        mesh_mm3: f64,
        /// Volume in the surface, mm³.
        surface_mm3: f64,
        /// Difference, per cent.
        percent: f64,
        /// Limit, per cent.
        limit_percent: f64,
    },
    /// A boundary too far from the surfaces.
    #[error("the mesh's boundary is {:.3} mm from the surfaces near {}\n  why: the limit is {:.3} mm, a part of the edge\n  do:  take a shorter edge, or the method general; close the surface if it is open there", .distance * 1e3, crate::surface::place_text(.at), .limit * 1e3)]
    Distance {
        /// How far, m.
        distance: Metre,
        /// Where, m.
        at: Point3,
        /// Limit, m.
        limit: Metre,
    },
    /// Body and spine that do not touch.
    #[error(
        "body and spine have no common face\n  why: the sheet must be inside of the body\n  do:  check that both files have the same unit and the same origin"
    )]
    NoContact,
}

/// The surfaces that a mesh is compared with.
pub(crate) struct Reference<'a> {
    pub body: &'a Surface,
    pub spine: &'a Surface,
    /// Inner volumes by chamber, m³.
    pub cavities: &'a [CubicMetre],
    /// What of the surfaces the mesh is to show, where it is not all.
    pub visible: Option<&'a Visibility>,
}

/// Limits of the validation.
pub(crate) struct Limits {
    /// Difference of volumes, as a fraction.
    pub volume: f64,
    /// Distance between boundaries, m.
    pub distance: Metre,
}

/// Compares a mesh with the surfaces from which it was made.
///
/// # Errors
/// [`ValidationError`] when a limit is passed.
pub(crate) fn validate_mesh(mesh: &TetMesh, reference: &Reference, limits: &Limits) -> Result<Report, ValidationError> {
    let Reference { body, spine, cavities, .. } = *reference;
    if let Some(tet) = (0..mesh.tets.len()).find(|&t| mesh.volume(t) <= 0.0) {
        return Err(ValidationError::InvertedElement { tet, volume_mm3: mesh.volume(tet) * 1e9 });
    }
    let symmetry_factor = if mesh.half { 2.0 } else { 1.0 };
    let interface = interface_faces(mesh);
    let (min_dihedral_deg, max_dihedral_deg) = dihedral_range(mesh);
    let directed_distances = hausdorff_distances(mesh, &interface, &[body, spine], reference.visible);
    let (hausdorff_m, at) =
        if directed_distances[0].0 > directed_distances[1].0 { directed_distances[0] } else { directed_distances[1] };
    let report = Report {
        nodes: mesh.nodes.len(),
        tets: mesh.tets.len(),
        quadratic_nodes: quadratic(mesh).nodes.len(),
        min_dihedral_deg,
        max_dihedral_deg,
        hausdorff_m,
        volume_body: symmetry_factor * mesh.region_volume(BODY),
        volume_spine: symmetry_factor * mesh.region_volume(SPINE),
        volume_body_stl: body.volume(),
        volume_spine_stl: spine.volume(),
        interface_area: symmetry_factor * interface.iter().map(|f| face_area(mesh, f)).sum::<f64>(),
        chambers: (0..cavities.len()).map(|k| measure_chamber(mesh, k as u16)).collect(),
        half: mesh.half,
        repairs: Vec::new(),
    };
    check_volumes(&report, cavities, limits.volume)?;
    if interface.is_empty() && !spine.faces.is_empty() {
        return Err(ValidationError::NoContact);
    }
    if hausdorff_m > limits.distance {
        return Err(ValidationError::Distance { distance: hausdorff_m, at, limit: limits.distance });
    }
    Ok(report)
}

fn check_volumes(report: &Report, cavities: &[f64], limit: f64) -> Result<(), ValidationError> {
    let solids = [
        ("body".to_owned(), report.volume_body, report.volume_body_stl),
        ("spine".to_owned(), report.volume_spine, report.volume_spine_stl),
    ];
    let hollows = report.chambers.iter().zip(cavities).enumerate();
    let hollows = hollows.map(|(k, (c, &v))| (format!("chamber {k}"), c.volume, v));
    for (part, mesh, surface) in solids.into_iter().chain(hollows) {
        let relative_error = (mesh / surface - 1.0).abs();
        if relative_error > limit {
            let (mesh_mm3, surface_mm3) = (mesh * 1e9, surface * 1e9);
            return Err(ValidationError::Volume {
                part,
                mesh_mm3,
                surface_mm3,
                percent: 100.0 * relative_error,
                limit_percent: 100.0 * limit,
            });
        }
    }
    Ok(())
}

pub(crate) fn face_area(mesh: &TetMesh, face: &[u32; 3]) -> SquareMetre {
    let [a, b, c] = face.map(|n| mesh.nodes[n as usize]);
    norm(cross(sub(b, a), sub(c, a))) / 2.0
}

/// Volume and centroid of a cavity from the tetrahedra that its faces span with the origin; the missing faces of a half
/// cavity lie in z = 0 and contribute nothing.
fn measure_chamber(mesh: &TetMesh, chamber: u16) -> Chamber {
    let (mut volume, mut moment, mut cut) = (0.0, [0.0; 3], false);
    for face in mesh.skin.iter().filter(|f| f.on == Skin::Chamber(chamber)) {
        let [a, b, c] = face.nodes.map(|n| mesh.nodes[n as usize]);
        cut |= mesh.half && [a, b, c].iter().any(|corner| corner[2] == 0.0);
        let cone = -dot(a, cross(b, c)) / 6.0;
        volume += cone;
        (0..3).for_each(|k| moment[k] += cone * (a[k] + b[k] + c[k]) / 4.0);
    }
    let mut centroid = moment.map(|m| m / volume);
    if cut {
        centroid[2] = 0.0;
        volume *= 2.0;
    }
    Chamber { centroid, volume }
}

/// Faces between body and spine.
fn interface_faces(mesh: &TetMesh) -> Vec<[u32; 3]> {
    faces_between_regions(mesh).into_iter().map(|(face, _)| face).collect()
}

/// Faces between unlike regions, with the regions in rising order.
pub(crate) fn faces_between_regions(mesh: &TetMesh) -> Vec<([u32; 3], [u16; 2])> {
    let mut sides = Vec::with_capacity(4 * mesh.tets.len());
    for (tet, &region) in mesh.tets.iter().zip(&mesh.regions) {
        for face in FACES {
            let mut key = face.map(|i| tet[i]);
            key.sort_unstable();
            sides.push((key, region));
        }
    }
    sides.sort_unstable();
    let interface_sides = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2 && pair[0].1 != pair[1].1);
    interface_sides.map(|pair| (pair[0].0, [pair[0].1, pair[1].1])).collect()
}

/// Largest distances of the surfaces from the mesh and of the mesh from the surfaces, sampled at corners, middles of edges and of faces, and where
/// they are; of the surfaces what is visible alone, where that is given.
pub(crate) fn hausdorff_distances(
    mesh: &TetMesh,
    interface: &[[u32; 3]],
    surfaces: &[&Surface],
    visible: Option<&Visibility>,
) -> [(Metre, Point3); 2] {
    let skin = mesh.skin.iter().filter(|f| f.on != Skin::Symmetry).map(|f| f.nodes);
    let mesh_faces: Vec<[Point3; 3]> =
        skin.chain(interface.iter().copied()).map(|f| f.map(|n| mesh.nodes[n as usize])).collect();
    let surface_faces = surfaces.iter().flat_map(|s| (0..s.faces.len()).map(|f| s.corners(f)));
    // a half mesh is compared with the upper half; the lower one is its image
    let surface_faces: Vec<[Point3; 3]> =
        surface_faces.filter(|c| !mesh.half || c.iter().any(|p| p[2] >= 0.0)).collect();
    let (to_own, to_given) = (Nearest::new(mesh_faces.clone()), Nearest::new(surface_faces.clone()));
    let fold = |p: Point3| if mesh.half { [p[0], p[1], p[2].abs()] } else { p };
    let distance = |nearest: &Nearest, point: Point3| nearest.find(point).map_or(f64::INFINITY, |hit| hit.distance);
    let farthest = |nearest: &Nearest, faces: &[[Point3; 3]], fold: &dyn Fn(Point3) -> Point3| {
        let samples = faces.iter().flat_map(|face| face_samples(*face)).map(fold);
        samples
            .map(|s| (distance(nearest, s), s))
            .fold((0.0, [0.0; 3]), |worst, d| if d.0 > worst.0 { d } else { worst })
    };
    let to_mesh = match visible {
        Some(visibility) => {
            visibility.farthest(&surface_faces, &|p| distance(&to_own, fold(p))).unwrap_or((0.0, [0.0; 3]))
        }
        None => farthest(&to_own, &surface_faces, &fold),
    };
    [to_mesh, farthest(&to_given, &mesh_faces, &|p| p)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_volume_is_told_in_the_words_of_a_user() {
        let (part, limit_percent) = ("body".to_owned(), 2.0);
        let error = ValidationError::Volume { part, mesh_mm3: 970.0, surface_mm3: 1000.0, percent: 3.0, limit_percent };
        let said = error.to_string();
        assert!(said.contains("the limit is 2.00 % of the surface's") && !said.contains("::"), "{said}");
    }

    #[test]
    fn the_first_part_whose_volume_is_off_is_named_with_both_volumes() {
        let report = Report {
            volume_body: 1.01e-6,
            volume_body_stl: 1e-6,
            volume_spine: 2e-7,
            volume_spine_stl: 2e-7,
            ..Report::default()
        };
        check_volumes(&report, &[], 0.02).unwrap();
        let ValidationError::Volume { part, mesh_mm3, surface_mm3, percent, limit_percent } =
            check_volumes(&report, &[], 0.005).unwrap_err()
        else {
            panic!("no error of a volume")
        };
        assert_eq!(part, "body");
        let off = [mesh_mm3 - 1010.0, surface_mm3 - 1000.0, percent - 1.0, limit_percent - 0.5];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{off:?}");
        let spine = Report { volume_spine: 1.9e-7, ..report };
        let refused = check_volumes(&spine, &[], 0.02).unwrap_err();
        assert!(matches!(refused, ValidationError::Volume { ref part, .. } if part == "spine"), "{refused}");
    }
}
