//! The inflated body: its mesh, with the sections of its chambers scaled, and what its tip does under the pressure of a recording.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use fem::{DynamicSettings, InitialValueProblem, State, StaticSettings, StepControl};
use mesh::Surface;
use si::{Metre, Point3, Second};

use super::carried::{Carried, carried_markers, mean_marker_displacement};
use super::hold::{Course, Hold};
use super::inflated::{Inflated, Shape};
use super::page::{Page, Recording, Supply};
use crate::IdentifiedMaterial;
use diagnostics::{Diagnostic, Result, input};
use simulate::case::{self, Case, History};
use simulate::{Body, Loaded, load};

/// A meshed body.
pub(super) struct Meshed {
    case: Case,
    loaded: Loaded,
    carried: Vec<Carried>,
    page: Page,
    /// The equilibria of each law that was asked for.
    families: Mutex<Vec<(String, Arc<Inflated>)>>,
    /// Least distance between a chamber and the outside across the body, m; none for a body that comes as a mesh.
    pub wall: Option<Metre>,
}

impl Meshed {
    /// The body of `case`, which lies in `folder` with its surface, with the sections of its chambers scaled by `section`; a surface that is
    /// changed is written into `out`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when case, surface or mesh are refused, or a marker's carrier is not on the body.
    pub fn new(page: &Page, case: &Case, folder: &Path, section: (f64, &Path)) -> Result<Self> {
        let mut case = check_case(page, case.clone())?;
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
        Ok(Self { case, loaded, carried, page: page.clone(), families: Mutex::default(), wall })
    }

    /// What the tip does from its place at ambient pressure, under the pressure that `supply` makes of `recording`, until the time `end`
    /// (s) after its hold's begin: equilibria of a step that is held, begun at those that are `known`, and a motion under a history.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the constants are refused, or the body has no equilibrium before the step.
    pub fn inflate(
        &self,
        material: &IdentifiedMaterial,
        (recording, supply): (&Recording, &Supply),
        end: Second,
        known: &mut Vec<Arc<Shape>>,
    ) -> Result<Course> {
        match recording.pressure {
            History::Constant(pressure) => {
                let body = self.family(&material.material)?;
                let [early, late] = self.page.feature_times(recording);
                let solved = if end < late { vec![early] } else { vec![early, late] };
                Hold { body: &body, material, supply, pressure }.course(end, &solved, known)
            }
            _ => self.motion(material, (recording, supply), end),
        }
    }

    /// The equilibria of the law `name`.
    fn family(&self, name: &str) -> Result<Arc<Inflated>> {
        let mut families = self.families.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, family)) = families.iter().find(|(known, _)| known == name) {
            return Ok(Arc::clone(family));
        }
        let mut case = self.case.clone();
        name.clone_into(&mut case.region[0].material);
        let family = Arc::new(Inflated::new(&self.page, &case, &self.loaded)?);
        families.push((name.to_owned(), Arc::clone(&family)));
        Ok(family)
    }

    /// The motion with inertia.
    pub(super) fn motion(
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
        mean_marker_displacement(&self.carried, self.loaded.solid.nodes(), displacement)[self.page.along as usize]
    }
}

fn check_case(page: &Page, mut case: Case) -> Result<Case> {
    let fits = case.region.len() == 1 && case.chamber.len() == 1;
    let adaptive = case.dynamic.as_ref().is_some_and(|set| set.adaptive.is_some());
    let has_history = page.recording.iter().any(|recording| !matches!(recording.pressure, History::Constant(_)));
    if !fits || (has_history && !adaptive) {
        let reason =
            "one material and one inflated chamber are compared, under a history with adaptive steps of [dynamic]";
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
        return Err(Diagnostic::new(
            "the case has no adaptive steps",
            "a history of pressure needs them",
            "correct the case",
        ));
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
