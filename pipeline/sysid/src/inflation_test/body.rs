//! The inflated body: its mesh, with the sections of its chambers scaled, and the motion of its tip after a step of pressure.

use std::path::Path;

use fem::{DynamicSettings, InitialValueProblem, State, StaticSettings, StepControl};
use mesh::Surface;
use nalgebra::Vector3;
use si::{Metre, Point3, Second};

use super::page::{Page, Recording, Supply};
use crate::{IdentifiedMaterial, rigid};
use diagnostics::{Diagnostic, Result, input};
use simulate::case::{self, Case};
use simulate::{Body, Loaded, load};

/// Nodes within this distance of the point that carries a marker turn it: about a quarter of the arm's diameter, so that their rotation
/// is not that of one element.
const PATCH: Metre = 0.010;

/// A marker on its arm, with the nodes around the point that carries it: their number, and −1 for a mirror image at z < 0.
pub(crate) struct Carried {
    at: Vector3<f64>,
    patch: Vec<(usize, f64)>,
}

/// A meshed body.
pub(super) struct Meshed {
    case: Case,
    loaded: Loaded,
    carried: Vec<Carried>,
    along: usize,
    /// Least distance between a chamber and the outside across the body, m; none for a body that comes as a mesh.
    pub wall: Option<Metre>,
}

/// What an inflation does to the tip.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// Time since the step (s), and mean displacement of the compared markers along the page's axis (m).
    pub tip: Vec<(Second, Metre)>,
    /// Why it ended before its time: the wall balloons without bound.
    pub burst: Option<String>,
}

impl Meshed {
    /// The body of `case`, which lies in `folder` with its surface, with the sections of its chambers scaled by `section`; a surface that is
    /// changed is written into `out`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when case, surface or mesh are refused, or a marker's carrier is not on the body.
    pub fn new(page: &Page, case: &Case, folder: &Path, section: (f64, &Path)) -> Result<Self> {
        let mut case = check_case(case.clone())?;
        let (ratio, out) = section;
        let mut wall = None;
        let loaded = match &case.mesh.body {
            None => load(&case, folder)?,
            Some(name) => {
                let bytes = input::read(&folder.join(name), input::MESH).map_err(|e| {
                    Diagnostic::io(&folder.join(name), e, "put the surface into one of the page's folders")
                })?;
                let surface = scale_chambers(&mesh::stl::read(&bytes, case.mesh.unit.metres())?, ratio)?;
                wall = least_wall(&surface)?;
                let changed = format!("{}_section_{ratio}.stl", page.name);
                let bytes = mesh::stl::write(&surface, case.mesh.unit.metres(), &page.name);
                std::fs::write(out.join(&changed), bytes)
                    .map_err(|e| Diagnostic::io(&out.join(&changed), e, "name another folder with --out"))?;
                case.mesh.body = Some(changed);
                load(&case, out)?
            }
        };
        let carried = carried_markers(page, &loaded)?;
        Ok(Self { case, loaded, carried, along: page.along as usize, wall })
    }

    /// Motion of the tip from its place at ambient pressure, under the pressure that `supply` makes of `recording`, until the time `end`
    /// (s) after its hold's begin.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the constants are refused, or the body has no equilibrium before the step.
    pub fn inflate(
        &self,
        material: &IdentifiedMaterial,
        (recording, supply): (&Recording, &Supply),
        end: Second,
    ) -> Result<Course> {
        let case = self.of_material(material);
        let body = Body::new(&case, &self.loaded)?;
        let mut solver = body.solver(&case)?;
        let pressures = |time: Second| body.pressures(&case, |_| recording.pressure_at(time, supply));
        let ambient = body.pressures(&case, |_| 0.0);
        let mut start = solver.equilibrium(&ambient, None, &StaticSettings::default())?.displacement;
        let ambient_tip = self.tip_displacement(&start);
        // A history may begin inflated: the motion then starts from rest under its first pressure.
        if pressures(0.0) != ambient {
            start = solver.equilibrium(&pressures(0.0), Some(&start), &StaticSettings::default())?.displacement;
        }
        let initial = State { velocity: vec![0.0; start.len()], displacement: start };
        let (settings, control) = dynamic_settings(&case, material)?;
        let problem = InitialValueProblem { settings: &settings, initial: &initial, pressures: &pressures };
        let mut tip = vec![(0.0, self.tip_displacement(&initial.displacement) - ambient_tip)];
        let mut observe =
            |time: Second, state: &State| tip.push((time, self.tip_displacement(&state.displacement) - ambient_tip));
        // A motion and no static path: the wall has a limit point, and load stepping found no equilibrium of the arm
        // above 140 mbar within minutes.
        let burst =
            solver.integrate_adaptive(&problem, &control, end, &mut observe).err().map(|error| error.to_string());
        Ok(Course { tip, burst })
    }

    fn of_material(&self, material: &IdentifiedMaterial) -> Case {
        let mut case = self.case.clone();
        let branch = material.branch.iter().map(|&[strength, time]| case::Branch { strength, time }).collect();
        let region = &mut case.region[0];
        region.material.clone_from(&material.material);
        (region.youngs_modulus, region.stiffening, region.branch) =
            (material.youngs_modulus, material.stiffening, branch);
        case
    }

    /// Mean displacement of the compared markers, m.
    fn tip_displacement(&self, displacement: &[f64]) -> Metre {
        mean_marker_displacement(&self.carried, self.loaded.solid.nodes(), displacement)[self.along]
    }
}

/// Mean displacement of markers, which turn with the nodes that carry them, m.
pub(crate) fn mean_marker_displacement(markers: &[Carried], nodes: &[Point3], displacement: &[f64]) -> Vector3<f64> {
    let marker_displacement = |marker: &Carried| {
        let initial: Vec<_> = marker.patch.iter().map(|node| node_position(nodes, *node)).collect();
        let node_displacement = |node: &(usize, f64)| {
            let u = &displacement[3 * node.0..3 * node.0 + 3];
            Vector3::new(u[0], u[1], node.1 * u[2])
        };
        let deformed: Vec<_> = initial.iter().zip(&marker.patch).map(|(x, node)| x + node_displacement(node)).collect();
        let deformed_marker = rigid::best_rotation(&initial, &deformed) * (marker.at - rigid::mean_point(&initial))
            + rigid::mean_point(&deformed);
        deformed_marker - marker.at
    };
    markers.iter().map(marker_displacement).sum::<Vector3<f64>>() / markers.len() as f64
}

fn node_position(nodes: &[Point3], (node, side): (usize, f64)) -> Vector3<f64> {
    let [x, y, z] = nodes[node];
    Vector3::new(x, y, side * z)
}

pub(crate) fn carried_markers(page: &Page, loaded: &Loaded) -> Result<Vec<Carried>> {
    let nodes = loaded.solid.nodes();
    // The mirror image as well: the nodes of one half turn out of the plane of symmetry, those of both do not.
    let sides: &[f64] = if loaded.solid.half() { &[1.0, -1.0] } else { &[1.0] };
    let mut markers = Vec::new();
    for marker in page.marker.iter().filter(|marker| marker.compared) {
        let Some(carrier) = marker.on.map(Vector3::from) else { continue };
        let candidates = (0..nodes.len()).flat_map(|node| sides.iter().map(move |side| (node, *side)));
        let patch: Vec<_> = candidates.filter(|node| (node_position(nodes, *node) - carrier).norm() < PATCH).collect();
        if patch.len() < 4 {
            let message = format!("the marker {} stands on no body: {carrier:?} m", marker.names.join(", "));
            let reason = format!("{} nodes lie within {PATCH} m of it", patch.len());
            return Err(Diagnostic::new(message, reason, "correct `on` of the [[marker]] on the page"));
        }
        markers.push(Carried { at: Vector3::from(marker.at), patch });
    }
    Ok(markers)
}

fn check_case(mut case: Case) -> Result<Case> {
    let fits = case.region.len() == 1 && case.chamber.len() == 1;
    let adaptive = case.dynamic.as_ref().is_some_and(|set| set.adaptive.is_some());
    if !fits || !adaptive {
        let reason = "one material and one inflated chamber are compared, with adaptive steps of [dynamic]";
        return Err(Diagnostic::new(
            "the case is not that of an inflation test",
            reason,
            "correct the case of the page",
        ));
    }
    let region = &mut case.region[0];
    // Yeoh's law without its further terms is the neo-Hookean one; the constants of the page replace those of the case.
    region.material = "yeoh".to_owned();
    (region.springpot, region.modulus_time) = (None, None);
    Ok(case)
}

fn dynamic_settings(case: &Case, material: &IdentifiedMaterial) -> Result<(DynamicSettings, StepControl)> {
    let set = case.dynamic.as_ref().and_then(|set| Some((set.scheme, set.adaptive?)));
    let Some((scheme, steps)) = set else {
        return Err(Diagnostic::new("the case has no adaptive steps", "an inflation needs them", "correct the case"));
    };
    let (mass_damping, stiffness_damping) = (material.mass_damping, material.stiffness_damping);
    let settings =
        DynamicSettings { scheme: scheme.into(), mass_damping, stiffness_damping, ..DynamicSettings::default() };
    Ok((settings, StepControl { tolerance: steps.tolerance, shortest: steps.shortest, longest: steps.longest }))
}

/// The axis along which the surface is longest.
fn longest_axis(surface: &Surface) -> usize {
    let (low, high) = surface.bounds();
    (0..3).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or_default()
}

/// The surface with its chambers scaled about their centroids across its longest axis. A constant offset of the walls would invert the
/// short edges of a chamber's corners; for convex chambers the walls grow by much the same everywhere.
pub(crate) fn scale_chambers(surface: &Surface, ratio: f64) -> Result<Surface> {
    let (shells, face_shells) = surface.shells()?;
    let (mut scaled, keep) = (surface.clone(), longest_axis(surface));
    for (face, shell) in surface.faces.iter().zip(face_shells) {
        let shell = &shells[shell as usize];
        for point in face.iter().filter(|_| shell.volume < 0.0) {
            let original = surface.points[*point as usize];
            let scaled_coordinate = |k: usize| {
                if k == keep { original[k] } else { shell.centroid[k] + ratio * (original[k] - shell.centroid[k]) }
            };
            scaled.points[*point as usize] = [0, 1, 2].map(scaled_coordinate);
        }
    }
    Ok(scaled)
}

/// Least distance between chambers and the outside across a convex body, m.
fn least_wall(surface: &Surface) -> Result<Option<Metre>> {
    let (shells, face_shells) = surface.shells()?;
    let (outside, inside): (Vec<_>, Vec<_>) =
        (0..surface.faces.len()).partition(|face| shells[face_shells[*face] as usize].volume > 0.0);
    let length = longest_axis(surface);
    let depth = |point: Point3| {
        let wall_distance = |face: &usize| {
            let normal = surface.normal(*face);
            let unit = si::vec3::norm(normal);
            let lateral = normal[length].abs() < 0.5 * unit;
            lateral.then(|| si::vec3::dot(si::vec3::sub(surface.corners(*face)[0], point), normal) / unit)
        };
        outside.iter().filter_map(wall_distance).fold(f64::INFINITY, f64::min)
    };
    let thinnest = inside.iter().flat_map(|face| surface.corners(*face)).map(depth).fold(f64::INFINITY, f64::min);
    Ok(thinnest.is_finite().then_some(thinnest))
}

#[cfg(test)]
mod tests {
    use super::super::tests::hollow;
    use super::*;

    #[test]
    fn a_smaller_section_has_thicker_walls_and_the_same_length() {
        let surface = hollow();
        assert!((least_wall(&surface).unwrap().unwrap() - 0.003).abs() < 1e-12);
        let smaller = scale_chambers(&surface, 0.5).unwrap();
        assert!((least_wall(&smaller).unwrap().unwrap() - 0.0045).abs() < 1e-12);
        assert!((smaller.points[8][0] - 0.01).abs() < 1e-15 && smaller.points[..8] == surface.points[..8]);
    }
}
