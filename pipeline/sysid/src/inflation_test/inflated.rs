//! An inflated body as a family of equilibria: displacement of its tip by the constants of its material, the offset of its walls and the
//! pressure, with all derivatives.
//!
//! Inertia is left out: what is compared are means over a period of the ring-down. Relaxation acts as the modulus of creep.

use std::sync::{Arc, Mutex, PoisonError};

use fem::{Equilibrium, Parameter, Relaxation, Solver, StaticSettings, System};
use mesh::Skin;
use nalgebra::Vector3;
use si::{Metre, Pascal, Point3, Second};

use super::carried::{Carried, carried_markers, mean_marker_displacement};
use super::page::Page;
use crate::wall_offset::wall_offset;
use diagnostics::{Diagnostic, Result};
use simulate::case::Case;
use simulate::{Body, Loaded};

/// E (Pa), C₂₀/C₁₀, C₃₀/C₁₀, the offset of the walls (m) and the pressure (Pa).
pub(crate) type Point = [f64; 5];
/// Where they stand.
const WALL: usize = 3;
pub(crate) const PRESSURE: usize = 4;

/// The first step of a path, in changes over which a linear prediction holds.
const FAR: f64 = 5.0;
/// The first step from a body without pressure, as a part of the path: its flat walls bend, and stiffen within a twentieth of the pressure.
const FROM_REST: f64 = 0.06;
/// Least step of a path, as a part of it.
const LEAST_STEP: f64 = 0.01;
/// Where a step fails, the path ends at a limit point that lies nearer than this part of it: halving steps down to it were three quarters of
/// the time of a law whose walls balloon.
const NEAR_LIMIT: f64 = 0.06;
/// Newton iterations of a warm start: those that converge need four to eleven.
const ITERATIONS: usize = 14;
/// Bodies that are kept, one an offset of their walls: a fit asks for all pressures at each.
const OFFSETS: usize = 6;
/// Shapes that a fit keeps: a few at each pressure.
const KEPT: usize = 24;

/// A meshed body with one chamber that is inflated.
pub(crate) struct Inflated {
    system: System,
    /// One solver's properties.
    poissons_ratio: f64,
    gravity: Point3,
    carried: Vec<Carried>,
    along: usize,
    chamber: usize,
    chambers: usize,
    /// Motion of the nodes for each metre of offset.
    velocity: Vec<f64>,
    /// By offset, m.
    offset_systems: Mutex<Vec<(Metre, System)>>,
    /// Beyond a limit point, with the refusal: a body that is softer in every respect, or under more pressure, has no equilibrium either.
    beyond_limits: Mutex<Vec<(Point, Diagnostic)>>,
}

/// E (Pa) and the coefficients over C₁₀ of the elastic body that has the shape of a viscoelastic one of these long-term constants a time after
/// a step of pressure: the part of μ alone creeps, and of λ, which hardly matters near incompressibility, it is taken to creep as well.
pub(crate) fn creep_elasticity(
    (youngs_modulus, stiffening): (Pascal, [f64; 2]),
    relaxation: &Relaxation,
    time: Second,
) -> (Pascal, [f64; 2]) {
    let modulus = relaxation.creep_modulus(time);
    (youngs_modulus * modulus, stiffening.map(|ratio| ratio / modulus))
}

/// An equilibrium with its derivatives.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    pub at: Point,
    displacement: Vec<f64>,
    /// du/dθ.
    changes: Vec<Vec<f64>>,
    /// Mean place of the markers relative to rest without pressure and weight, m.
    pub tip: Metre,
    /// Its derivatives.
    pub slopes: Point,
}

impl Inflated {
    /// Of the case, meshed already.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the case and its mesh do not match, or a marker stands on no body.
    pub fn new(page: &Page, case: &Case, loaded: &Loaded) -> Result<Self> {
        let body = Body::new(case, loaded)?;
        let velocity = wall_offset(&loaded.solid, |on, _| matches!(on, Skin::Chamber(_)));
        Ok(Self {
            poissons_ratio: body.system.regions()[0].poissons_ratio,
            gravity: case.gravity,
            carried: carried_markers(page, loaded)?,
            along: page.along as usize,
            chamber: body.numbers[0],
            chambers: body.cavities.len(),
            velocity,
            system: body.system,
            offset_systems: Mutex::default(),
            beyond_limits: Mutex::default(),
        })
    }

    /// The body with its walls offset by `wall` (m).
    // Its masses and chambers cost as much as a factorisation: made anew for each equilibrium they were a quarter of a fit.
    fn offset_system(&self, wall: Metre) -> Result<System> {
        let mut systems = self.offset_systems.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, system)) = systems.iter().find(|(offset, _)| *offset == wall) {
            return Ok(system.clone());
        }
        let system = self.system.morphed(&self.velocity, wall)?;
        if systems.len() == OFFSETS {
            systems.remove(0);
        }
        systems.push((wall, system.clone()));
        Ok(system)
    }

    fn solver(&self, point: &Point) -> Result<Solver> {
        let mut solver = self.offset_system(point[WALL])?.solver();
        solver.set_gravity(self.gravity)?;
        solver.set_elastic(0, point[0], self.poissons_ratio)?;
        solver.set_stiffening(0, [point[1], point[2]])?;
        Ok(solver)
    }

    fn pressures(&self, pressure: Pascal) -> Vec<Pascal> {
        (0..self.chambers).map(|k| if k == self.chamber { pressure } else { 0.0 }).collect()
    }

    /// The equilibrium at `point`: one of `known`, or followed from the nearest of them and added.
    ///
    /// # Errors
    /// As [`Inflated::shape`]; at once where a stiffer body under less pressure has no equilibrium.
    pub(crate) fn remembered(&self, point: &Point, known: &mut Vec<Arc<Shape>>) -> Result<Arc<Shape>> {
        if let Some(shape) = known.iter().find(|shape| shape.at == *point) {
            return Ok(Arc::clone(shape));
        }
        let beyond_limits = self.beyond_limits.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, refused)) = beyond_limits.iter().find(|(beyond, _)| is_weaker(point, beyond)) {
            return Err(refused.clone());
        }
        drop(beyond_limits);
        let shape = Arc::new(self.shape(point, known)?);
        known.push(Arc::clone(&shape));
        if known.len() > KEPT {
            known.remove(0);
        }
        Ok(shape)
    }

    /// The equilibrium at `point`, followed from the nearest of `known` in steps that are cut where Newton's method fails; of none, from rest.
    ///
    /// # Errors
    /// A [`Diagnostic`] where the path has no further equilibrium nearby, as where a wall balloons.
    pub fn shape(&self, point: &Point, known: &[Arc<Shape>]) -> Result<Shape> {
        let nearest = known.iter().min_by(|a, b| distance(&a.at, point).total_cmp(&distance(&b.at, point)));
        let mut current = match nearest {
            Some(shape) => Shape::clone(shape),
            None => self.without_pressure(point)?,
        };
        let settings = StaticSettings { max_iterations: ITERATIONS, ..StaticSettings::default() };
        // With the first step, as each offset has a body of its own to be made; in steps where that fails.
        let mut walls_at_once = true;
        let (start, mut part) = (current.at, 0.0);
        let mut step = (FAR / distance(&start, point)).min(1.0);
        if start[PRESSURE] == 0.0 && point[PRESSURE] != 0.0 {
            step = step.min(FROM_REST);
        }
        let mut limit = LimitPoint::default();
        while part < 1.0 {
            let next = (part + step).min(1.0);
            let mut path_point: Point = std::array::from_fn(|k| start[k] + next * (point[k] - start[k]));
            if walls_at_once {
                path_point[WALL] = point[WALL];
            }
            let mut solver = self.solver(&path_point)?;
            let predicted = current.predicted(&path_point);
            let pressures = self.pressures(path_point[PRESSURE]);
            match solver.equilibrium_near(&pressures, &current.displacement, &predicted, &settings) {
                Ok(found) => {
                    step *= if found.iterations < 7 { 2.0 } else { 1.0 };
                    current = self.linearise_shape(&mut solver, &path_point, found)?;
                    part = next;
                    limit.pass(part, current.rate(&start, point));
                }
                Err(error) if limit.is_near(part) => return Err(self.note_limit(point, error.into())),
                Err(error) if step < LEAST_STEP => return Err(error.into()),
                Err(_) => (step, walls_at_once) = (0.4 * step, part > 0.0 && walls_at_once),
            }
        }
        Ok(current)
    }

    // Other failures are not kept: a path that was too bold would hide what another one finds.
    fn note_limit(&self, point: &Point, refused: Diagnostic) -> Diagnostic {
        self.beyond_limits.lock().unwrap_or_else(PoisonError::into_inner).push((*point, refused.clone()));
        refused
    }

    /// Under its weight alone.
    fn without_pressure(&self, point: &Point) -> Result<Shape> {
        let mut ambient = *point;
        ambient[PRESSURE] = 0.0;
        let mut solver = self.solver(&ambient)?;
        let equilibrium = solver.equilibrium(&self.pressures(0.0), None, &StaticSettings::default())?;
        self.linearise_shape(&mut solver, &ambient, equilibrium)
    }

    fn linearise_shape(&self, solver: &mut Solver, point: &Point, found: Equilibrium) -> Result<Shape> {
        let region = 0;
        solver.factorise_at(&found)?;
        let mut changes = Vec::new();
        for parameter in [
            Parameter::YoungsModulus(region),
            Parameter::Stiffening { region, term: 0 },
            Parameter::Stiffening { region, term: 1 },
        ] {
            changes.push(solver.sensitivity(&found, parameter)?);
        }
        changes.push(solver.shape_sensitivity(&found, &self.velocity)?);
        changes.push(solver.sensitivity(&found, Parameter::Pressure(self.chamber))?);
        let tip = self.tip(point[WALL], &found.displacement);
        let mut slopes = [0.0; 5];
        for (k, (slope, change)) in slopes.iter_mut().zip(&changes).enumerate() {
            let largest = change.iter().fold(1e-30, |most: f64, u| most.max(u.abs()));
            // By differences, as markers turn with the nodes around them: to both sides, the farthest node by a
            // micrometre.
            let step = 1e-6 / largest;
            let side = |step: f64| {
                let perturbed: Vec<f64> = found.displacement.iter().zip(change).map(|(u, d)| u + step * d).collect();
                self.tip(point[WALL] + if k == WALL { step } else { 0.0 }, &perturbed)
            };
            *slope = (side(step) - side(-step)) / (2.0 * step);
        }
        Ok(Shape { at: *point, displacement: found.displacement, changes, tip, slopes })
    }

    fn tip(&self, wall: Metre, displacement: &[f64]) -> Metre {
        let mesh = self.system.mesh();
        let offset_nodes: Vec<Point3> = mesh
            .nodes
            .iter()
            .zip(self.velocity.chunks_exact(3))
            .map(|(x, v)| [0, 1, 2].map(|axis| x[axis] + wall * v[axis]))
            .collect();
        let mean: Vector3<f64> = mean_marker_displacement(&self.carried, &offset_nodes, displacement);
        mean[self.along]
    }
}

/// Between two points, in changes over which a linear prediction holds.
fn distance(from: &Point, to: &Point) -> f64 {
    let scale = [0.1 * to[0], 0.3, 0.3, 1e-4, 2e3];
    (0..from.len()).map(|k| ((from[k] - to[k]) / scale[k]).powi(2)).sum::<f64>().sqrt()
}

/// Whether a body is as soft as another in every respect, under at least its pressure.
fn is_weaker(point: &Point, than: &Point) -> bool {
    point[..PRESSURE].iter().zip(than).all(|(of, other)| of <= other) && point[PRESSURE] >= than[PRESSURE]
}

/// The limit point towards which a path runs: there the shape changes as the inverse of the root of what is left of the path, so that
/// the inverse square of its rate falls to zero on a line.
#[derive(Debug, Default)]
struct LimitPoint {
    /// The last two parts of the path, with the inverse square of the rate at each.
    passed: Vec<[f64; 2]>,
}

impl LimitPoint {
    fn pass(&mut self, part: f64, rate: f64) {
        if self.passed.len() == 2 {
            self.passed.remove(0);
        }
        self.passed.push([part, rate.powi(-2)]);
    }

    /// Whether it lies close beyond `part`, before the end of the path.
    fn is_near(&self, part: f64) -> bool {
        let [[former, far], [last, near]] = self.passed[..] else { return false };
        let expected = last + near * (last - former) / (far - near);
        far > near && expected < 1.0 && expected - part < NEAR_LIMIT
    }
}

impl Shape {
    /// ‖du‖ for each unit of the way from one point to another, m.
    fn rate(&self, from: &Point, to: &Point) -> f64 {
        let mut motion = vec![0.0; self.displacement.len()];
        self.add_changes(&mut motion, from, to);
        motion.iter().map(|u| u * u).sum::<f64>().sqrt()
    }

    fn add_changes(&self, displacement: &mut [f64], from: &Point, to: &Point) {
        for (k, change) in self.changes.iter().enumerate() {
            let increment = to[k] - from[k];
            displacement.iter_mut().zip(change).for_each(|(u, d)| *u += increment * d);
        }
    }

    /// The mean place of the markers at a point nearby, to first order, m.
    pub(super) fn linear_tip(&self, point: &Point) -> Metre {
        self.tip + (0..point.len()).map(|k| self.slopes[k] * (point[k] - self.at[k])).sum::<f64>()
    }

    fn predicted(&self, point: &Point) -> Vec<f64> {
        let mut guess = self.displacement.clone();
        self.add_changes(&mut guess, &self.at, point);
        guess
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inflation_test::tests::{CASE, PAGE, hollow};
    use std::path::Path;

    /// The hollow box of the inflation test, of a law with both coefficients.
    fn hollow_box() -> Inflated {
        let folder =
            std::env::temp_dir().join(format!("inflated-{}-{:?}", std::process::id(), std::thread::current().id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("box.stl"), mesh::stl::write(&hollow(), 1e-3, "box")).unwrap();
        std::fs::write(folder.join("case.toml"), CASE.replace("yeoh", "lopez_pamies_m5")).unwrap();
        let case = simulate::case::read(&folder.join("case.toml")).unwrap();
        let loaded = simulate::load(&case, &folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        Inflated::new(&Page::parse(PAGE, Path::new("page.toml")).unwrap(), &case, &loaded).unwrap()
    }

    #[test]
    fn a_limit_point_is_expected_where_the_rate_diverges() {
        let mut limit = LimitPoint::default();
        // u = 1 − √(0.8 − part)
        [0.5, 0.76].into_iter().for_each(|part: f64| limit.pass(part, 0.5 / (0.8 - part).sqrt()));
        assert!(limit.is_near(0.76) && !limit.is_near(0.7));
        let mut stiffening = LimitPoint::default();
        [0.5, 0.76].into_iter().for_each(|part: f64| stiffening.pass(part, 1.0 / part));
        assert!(!stiffening.is_near(0.76));
    }

    const AT: Point = [1.2e5, 2.0, -0.3, 1e-4, 8e3];

    #[test]
    fn slopes_are_differences_of_equilibria() {
        let body = hollow_box();
        let shape = Arc::new(body.shape(&AT, &[]).unwrap());
        assert!(shape.tip.abs() > 2e-4, "the box bends: {}", shape.tip);
        for (k, step) in [12.0, 1e-3, 1e-3, 1e-6, 1.0].into_iter().enumerate() {
            let side = |step: f64| {
                let mut point = AT;
                point[k] += step;
                body.shape(&point, &[Arc::clone(&shape)]).unwrap().tip
            };
            let difference = (side(step) - side(-step)) / (2.0 * step);
            assert!((shape.slopes[k] / difference - 1.0).abs() < 1e-3, "{k}: {} {difference}", shape.slopes[k]);
        }
    }

    /// Two pressures separate the offset of the walls from the modulus.
    #[test]
    fn a_planted_offset_of_the_walls_comes_back_with_the_modulus() {
        let body = hollow_box();
        let tips = |point: &Point| {
            let shape_at =
                |pressure: f64| body.shape(&[point[0], point[1], point[2], point[3], pressure], &[]).unwrap();
            [shape_at(8e3), shape_at(1.6e4)]
        };
        let planted = tips(&AT).map(|shape| shape.tip);
        let mut point = [1.1e5, AT[1], AT[2], 0.0, 0.0];
        for _ in 0..12 {
            let shapes = tips(&point);
            let [a, b] = [0, 1].map(|k| planted[k] - shapes[k].tip);
            let slope = |k: usize, p: usize| shapes[k].slopes[p];
            let determinant = slope(0, 0) * slope(1, WALL) - slope(1, 0) * slope(0, WALL);
            point[0] += ((a * slope(1, WALL) - b * slope(0, WALL)) / determinant).clamp(-1e4, 1e4);
            point[WALL] += ((b * slope(0, 0) - a * slope(1, 0)) / determinant).clamp(-3e-5, 3e-5);
        }
        assert!((point[WALL] - AT[WALL]).abs() < 2e-6, "{point:?}");
        assert!((point[0] / AT[0] - 1.0).abs() < 1e-3, "{point:?}");
    }

    #[test]
    fn a_path_from_rest_ends_where_a_nearby_equilibrium_leads() {
        let body = hollow_box();
        let nearby_shape = Arc::new(body.shape(&[1.2e5, 2.0, -0.3, 0.0, 7e3], &[]).unwrap());
        let (far, close) = (body.shape(&AT, &[]).unwrap(), body.shape(&AT, &[nearby_shape]).unwrap());
        assert!((far.tip / close.tip - 1.0).abs() < 1e-6);
    }
}
