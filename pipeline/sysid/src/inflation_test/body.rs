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
struct Carried {
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
        let mut case = checked(case.clone())?;
        let (ratio, out) = section;
        let mut wall = None;
        let loaded = match &case.mesh.body {
            None => load(&case, folder)?,
            Some(name) => {
                let bytes = input::read(&folder.join(name), input::MESH).map_err(|e| {
                    Diagnostic::io(&folder.join(name), e, "put the surface into one of the page's folders")
                })?;
                let surface = scaled(&mesh::stl::read(&bytes, case.mesh.unit.metres())?, ratio)?;
                wall = least_wall(&surface)?;
                let changed = format!("{}_section_{ratio}.stl", page.name);
                let bytes = mesh::stl::write(&surface, case.mesh.unit.metres(), &page.name);
                std::fs::write(out.join(&changed), bytes)
                    .map_err(|e| Diagnostic::io(&out.join(&changed), e, "name another folder with --out"))?;
                case.mesh.body = Some(changed);
                load(&case, out)?
            }
        };
        let carried = carried(page, &loaded)?;
        Ok(Self { case, loaded, carried, along: page.along as usize, wall })
    }

    /// Motion of the tip from its place at ambient pressure, under the pressure that `supply` makes of `recording`, until the time `until`
    /// (s) after its hold's begin.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the constants are refused, or the body has no equilibrium before the step.
    pub fn inflate(
        &self,
        is: &IdentifiedMaterial,
        (recording, supply): (&Recording, &Supply),
        until: Second,
    ) -> Result<Course> {
        let case = self.of_material(is);
        let body = Body::new(&case, &self.loaded)?;
        let mut solver = body.solver(&case)?;
        let pressures = |time: Second| body.pressures(&case, |_| recording.pressure_at(time, supply));
        let ambient = body.pressures(&case, |_| 0.0);
        let mut start = solver.equilibrium(&ambient, None, &StaticSettings::default())?.displacement;
        let rest = self.tip(&start);
        if pressures(0.0) != ambient {
            start = solver.equilibrium(&pressures(0.0), Some(&start), &StaticSettings::default())?.displacement;
        }
        let initial = State { velocity: vec![0.0; start.len()], displacement: start };
        let (settings, control) = settings(&case, is)?;
        let problem = InitialValueProblem { settings: &settings, initial: &initial, pressures: &pressures };
        let mut tip = vec![(0.0, self.tip(&initial.displacement) - rest)];
        let mut see = |time: Second, state: &State| tip.push((time, self.tip(&state.displacement) - rest));
        let burst = solver.integrate_adaptive(&problem, &control, until, &mut see).err().map(|lost| lost.to_string());
        Ok(Course { tip, burst })
    }

    fn of_material(&self, is: &IdentifiedMaterial) -> Case {
        let mut case = self.case.clone();
        let branch = is.branch.iter().map(|&[strength, time]| case::Branch { strength, time }).collect();
        let region = &mut case.region[0];
        (region.youngs_modulus, region.stiffening, region.branch) = (is.youngs_modulus, is.stiffening, branch);
        case
    }

    /// Mean displacement of the compared markers, which turn with the nodes that carry them, m.
    fn tip(&self, displacement: &[f64]) -> Metre {
        let of = |marker: &Carried| {
            let rest: Vec<_> = marker.patch.iter().map(|node| at(self.loaded.solid.nodes(), *node)).collect();
            let moved = |node: &(usize, f64)| {
                let u = &displacement[3 * node.0..3 * node.0 + 3];
                Vector3::new(u[0], u[1], node.1 * u[2])
            };
            let now: Vec<_> = rest.iter().zip(&marker.patch).map(|(x, node)| x + moved(node)).collect();
            let turned = rigid::rotation(&rest, &now) * (marker.at - rigid::mean(&rest)) + rigid::mean(&now);
            (turned - marker.at)[self.along]
        };
        self.carried.iter().map(of).sum::<f64>() / self.carried.len() as f64
    }
}

fn at(nodes: &[Point3], (node, side): (usize, f64)) -> Vector3<f64> {
    let [x, y, z] = nodes[node];
    Vector3::new(x, y, side * z)
}

fn carried(page: &Page, loaded: &Loaded) -> Result<Vec<Carried>> {
    let nodes = loaded.solid.nodes();
    let sides: &[f64] = if loaded.solid.half() { &[1.0, -1.0] } else { &[1.0] };
    let mut all = Vec::new();
    for marker in page.marker.iter().filter(|marker| marker.compared) {
        let Some(on) = marker.on.map(Vector3::from) else { continue };
        let both = (0..nodes.len()).flat_map(|node| sides.iter().map(move |side| (node, *side)));
        let patch: Vec<_> = both.filter(|node| (at(nodes, *node) - on).norm() < PATCH).collect();
        if patch.len() < 4 {
            let what = format!("the marker {} stands on no body: {on:?} m", marker.names.join(", "));
            let why = format!("{} nodes lie within {PATCH} m of it", patch.len());
            return Err(Diagnostic::new(what, why, "correct `on` of the [[marker]] on the page"));
        }
        all.push(Carried { at: Vector3::from(marker.at), patch });
    }
    Ok(all)
}

fn checked(mut case: Case) -> Result<Case> {
    let fits = case.region.len() == 1 && case.chamber.len() == 1;
    let adaptive = case.dynamic.as_ref().is_some_and(|set| set.adaptive.is_some());
    if !fits || !adaptive {
        let why = "one material and one inflated chamber are compared, with adaptive steps of [dynamic]";
        return Err(Diagnostic::new("the case is not that of an inflation test", why, "correct the case of the page"));
    }
    let region = &mut case.region[0];
    // Yeoh's law without its further terms is the neo-Hookean one; the constants of the page replace those of the case.
    region.material = "yeoh".to_owned();
    (region.springpot, region.modulus_time) = (None, None);
    Ok(case)
}

fn settings(case: &Case, is: &IdentifiedMaterial) -> Result<(DynamicSettings, StepControl)> {
    let set = case.dynamic.as_ref().and_then(|set| Some((set.scheme, set.adaptive?)));
    let Some((scheme, steps)) = set else {
        return Err(Diagnostic::new("the case has no adaptive steps", "an inflation needs them", "correct the case"));
    };
    let (mass_damping, stiffness_damping) = (is.mass_damping, is.stiffness_damping);
    let settings =
        DynamicSettings { scheme: scheme.into(), mass_damping, stiffness_damping, ..DynamicSettings::default() };
    Ok((settings, StepControl { tolerance: steps.tolerance, shortest: steps.shortest, longest: steps.longest }))
}

/// The axis along which the surface is longest.
fn longest(surface: &Surface) -> usize {
    let (low, high) = surface.bounds();
    (0..3).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or_default()
}

/// The surface with its chambers scaled about their centroids across its longest axis. A constant offset of the walls would invert the
/// short edges of a chamber's corners; for convex chambers the walls grow by much the same everywhere.
fn scaled(surface: &Surface, ratio: f64) -> Result<Surface> {
    let (shells, of) = surface.shells()?;
    let (mut scaled, keep) = (surface.clone(), longest(surface));
    for (face, shell) in surface.faces.iter().zip(of) {
        let shell = &shells[shell as usize];
        for point in face.iter().filter(|_| shell.volume < 0.0) {
            let from = surface.points[*point as usize];
            let to =
                |k: usize| if k == keep { from[k] } else { shell.centroid[k] + ratio * (from[k] - shell.centroid[k]) };
            scaled.points[*point as usize] = [0, 1, 2].map(to);
        }
    }
    Ok(scaled)
}

/// Least distance between chambers and the outside across a convex body, m.
fn least_wall(surface: &Surface) -> Result<Option<Metre>> {
    let (shells, of) = surface.shells()?;
    let (outside, inside): (Vec<_>, Vec<_>) =
        (0..surface.faces.len()).partition(|face| shells[of[*face] as usize].volume > 0.0);
    let length = longest(surface);
    let depth = |from: Point3| {
        let to = |face: &usize| {
            let normal = surface.normal(*face);
            let unit = si::vec3::norm(normal);
            let across = normal[length].abs() < 0.5 * unit;
            across.then(|| si::vec3::dot(si::vec3::sub(surface.corners(*face)[0], from), normal) / unit)
        };
        outside.iter().filter_map(to).fold(f64::INFINITY, f64::min)
    };
    let least = inside.iter().flat_map(|face| surface.corners(*face)).map(depth).fold(f64::INFINITY, f64::min);
    Ok(least.is_finite().then_some(least))
}

#[cfg(test)]
mod tests {
    use super::super::tests::hollow;
    use super::*;

    #[test]
    fn a_smaller_section_has_thicker_walls_and_the_same_length() {
        let surface = hollow();
        assert!((least_wall(&surface).unwrap().unwrap() - 0.003).abs() < 1e-12);
        let smaller = scaled(&surface, 0.5).unwrap();
        assert!((least_wall(&smaller).unwrap().unwrap() - 0.0045).abs() < 1e-12);
        assert!((smaller.points[8][0] - 0.01).abs() < 1e-15 && smaller.points[..8] == surface.points[..8]);
    }
}
