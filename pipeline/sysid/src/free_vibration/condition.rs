//! One loading condition of the body as a reduced model: released from its straight shape, it moves under its dead loads.
//!
//! A fit simulates each recording some hundred times with other moduli, dampings and spectra. The shapes hardly depend on these, so
//! that one reduced model of a dozen coordinates serves all of them.

use std::path::Path;

use fem::{
    Actuation, DynamicSettings, ExternalForce, InitialValueProblem, Interrupt, ReducedModel, ReducedMotion,
    ReductionSettings, Relaxation, State, StaticSettings, StepState, System,
};
use nalgebra::DVector;
use si::{Hertz, Metre, Pascal, Second};

use super::page::Page;
use diagnostics::{Diagnostic, Result};
use simulate::case::{Case, read};
use simulate::{Body, load};

/// Fractions of the dead loads at which static shapes are taken.
// Released from 0, a linear body swings up to twice its static deflection and back: those, with a margin below 0.
const FRACTIONS: [f64; 6] = [-0.3, 0.3, 0.7, 1.0, 1.5, 2.0];
/// Steps of the motion of the whole body from which shapes are taken, their length relative to the simulated step, and which are taken.
const WHOLE_STEPS: usize = 60;
const WHOLE_STEP: f64 = 2.0;
const EVERY: usize = 4;
/// Coordinates of the reduced model, and its tolerance of displacements.
const REDUCTION: ReductionSettings = ReductionSettings { coordinates: 12, least_share: 1e-10, tolerance: 2e-4 };
/// After the vibration, each step is longer than the one before by this factor, up to the longest, s.
const GROWTH: f64 = 1.05;
const LONGEST: Second = 0.02;

/// The numbers that a law gives to the body.
#[derive(Debug, Clone)]
pub(crate) struct Properties {
    /// Long-term E, Pa.
    pub youngs_modulus: Pascal,
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    pub stiffening: [f64; 2],
    pub relaxation: Relaxation,
    /// α, 1/s.
    pub mass_damping: Hertz,
    /// β, s.
    pub stiffness_damping: Second,
}

/// A body under one set of dead loads.
pub(crate) struct Condition {
    reduced: ReducedModel,
    /// E of the case, Pa.
    youngs_modulus: Pascal,
    /// Vᵀ f of the dead loads.
    load: DVector<f64>,
    /// Mean displacement of the compared markers by each coordinate, m.
    marker: DVector<f64>,
    interrupt: Option<Interrupt>,
}

/// Where the shapes and the points of a reduced model come from.
pub(crate) enum Basis<'a> {
    /// They are found, unless it is interrupted.
    Trained(Option<Interrupt>),
    /// They are those of another law: shapes of a body under its weight hardly depend on it.
    Of(&'a Condition),
}

impl Condition {
    /// Of the case in the file `path`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the case or its mesh is refused, a shape or motion of the whole body is not found, or it was
    /// interrupted.
    pub fn new(page: &Page, path: &Path, interrupt: Option<Interrupt>) -> Result<Self> {
        // Yeoh's law without its further terms is the neo-Hookean one.
        Self::of_material(page, path, "yeoh", Basis::Trained(interrupt))
    }

    /// The same with another law of `materials`.
    ///
    /// # Errors
    /// As [`Condition::new`].
    pub(crate) fn of_material(page: &Page, path: &Path, material: &str, basis: Basis) -> Result<Self> {
        let interrupt = match &basis {
            Basis::Trained(interrupt) => interrupt.clone(),
            Basis::Of(known) => known.interrupt.clone(),
        };
        let mut case = read(path)?;
        check_case(&case, path)?;
        case.region[0].material = material.to_owned();
        let loaded = load(&case, path.parent().unwrap_or(Path::new(".")))?;
        let body = Body::new(&case, &loaded)?.interruptible(interrupt.clone());
        let reduced = match basis {
            Basis::Of(known) => body.system.restore(&known.reduced.data())?,
            Basis::Trained(_) => {
                let shapes = training_shapes(page, &case, &body)?;
                let shapes: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
                body.system.reduce(&shapes, &REDUCTION)?
            }
        };
        let project = |nodal: &[f64]| {
            let mode = |k: usize| reduced.displacement(&unit_vector(reduced.coordinates(), k));
            DVector::from_fn(reduced.coordinates(), |k, _| mode(k).iter().zip(nodal).map(|(u, f)| u * f).sum::<f64>())
        };
        let (load, marker) = (project(&dead_loads(&case, &body)), project(&marker_weights(page, &body)));
        Ok(Self { youngs_modulus: body.system.regions()[0].youngs_modulus, load, marker, reduced, interrupt })
    }

    /// Mean displacement of the compared markers at `times` (s after the release, rising from 0), m: the loads rise smoothly within the
    /// `ramp` (s) in which the hand lets go.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion, or the fit was interrupted.
    pub fn fall(&self, properties: &Properties, ramp: Second, times: &[Second]) -> Result<Vec<Metre>> {
        if self.interrupt.as_ref().is_some_and(|asked| asked()) {
            return Err(Diagnostic::interrupted());
        }
        let settings = DynamicSettings {
            mass_damping: properties.mass_damping,
            stiffness_damping: properties.stiffness_damping,
            ..DynamicSettings::default()
        };
        let motion = ReducedMotion {
            settings: &DynamicSettings { step: times[1] - times[0], ..settings },
            modulus_scale: &[properties.youngs_modulus / self.youngs_modulus],
            relaxation: std::slice::from_ref(&properties.relaxation),
            stiffening: &[properties.stiffening],
            actuation: &|_| Actuation { pressures: Vec::new() },
        };
        let mut loads = DeadLoads { load: &self.load, ramp };
        let mut fall = vec![0.0];
        let mut observe = |_: Second, q: &DVector<f64>, _: &DVector<f64>| fall.push(self.marker.dot(q));
        self.reduced.integrate_at(&motion, &mut loads, &times[1..], &mut observe)?;
        Ok(fall)
    }
}

/// Times of the simulated states until `end`: equal steps during the vibration, then longer ones.
pub(crate) fn times(page: &Page, end: Second) -> Vec<Second> {
    let mut times = vec![0.0];
    let mut step = page.step;
    while times[times.len() - 1] < end {
        let last = times[times.len() - 1];
        if last > page.swing[1] {
            step = (step * GROWTH).min(LONGEST);
        }
        times.push(last + step);
    }
    times
}

/// Smooth rise from 0 to 1 over a relative time of 0 to 1.
fn smooth_rise(part: f64) -> f64 {
    let part = part.clamp(0.0, 1.0);
    // A linear rise would jump in its rate at both ends, and excite the higher modes.
    part * part * (3.0 - 2.0 * part)
}

/// Dead loads that rise within the `ramp` (s).
struct DeadLoads<'a> {
    load: &'a DVector<f64>,
    ramp: Second,
}

impl ExternalForce for DeadLoads<'_> {
    fn force(&self, state: &StepState) -> DVector<f64> {
        self.load * smooth_rise(state.time / self.ramp)
    }

    fn accept(&mut self, _: &StepState) {}
}

fn check_case(case: &Case, path: &Path) -> Result<()> {
    let refused = |message: &str, reason: &str, action: &str| Err(Diagnostic::file(path, message, reason, action));
    match &case.region[..] {
        [region] if region.mean_dilatation => refused(
            "its region uses mean_dilatation",
            "a reduced model cannot",
            "leave it out, with quadratic elements and poissons_ratio 0.49 at most",
        ),
        [region] if region.material == "neo_hookean" || region.material == "yeoh" => Ok(()),
        [region] => refused(
            &format!("its material is `{}`", region.material),
            "the laws that are compared extend the neo-Hookean one",
            "set material = \"neo_hookean\"",
        ),
        regions => {
            refused(&format!("it has {} regions", regions.len()), "one body is identified", "fit a body of one region")
        }
    }
}

/// 3 entries per node, N: all loads and the weight.
fn dead_loads(case: &Case, body: &Body) -> Vec<f64> {
    let mut loads = body.forces.clone();
    for (force, mass) in loads.chunks_exact_mut(3).zip(body.system.node_masses()) {
        (0..3).for_each(|axis| force[axis] += mass * case.gravity[axis]);
    }
    loads
}

/// Weights of all nodes in the mean displacement of the compared markers along the page's axis, 3 entries per node.
fn marker_weights(page: &Page, body: &Body) -> Vec<f64> {
    let compared: Vec<_> = page.marker.iter().filter(|marker| marker.compared).filter_map(|marker| marker.on).collect();
    let mut weights = vec![0.0; 3 * body.solid.nodes().len()];
    for point in &compared {
        for (node, weight) in body.solid.embed(*point).0.weights {
            weights[3 * node as usize + page.along as usize] += weight / compared.len() as f64;
        }
    }
    weights
}

fn unit_vector(count: usize, k: usize) -> DVector<f64> {
    DVector::from_fn(count, |row, _| f64::from(u8::from(row == k)))
}

/// Shapes of the whole body: at rest under fractions of its loads, and in the motion after a sudden release.
fn training_shapes(page: &Page, case: &Case, body: &Body) -> Result<Vec<Vec<f64>>> {
    let mut shapes = Vec::new();
    for part in FRACTIONS {
        let mut solver = body.solver(case)?;
        solver.set_gravity(case.gravity.map(|g| part * g))?;
        solver.set_forces(&body.forces.iter().map(|force| part * force).collect::<Vec<_>>())?;
        let pressures = vec![0.0; body.cavities.len()];
        shapes.push(solver.equilibrium(&pressures, None, &StaticSettings::default())?.displacement);
    }
    shapes.extend(release_shapes(page, case, &body.system, body)?);
    Ok(shapes)
}

fn release_shapes(page: &Page, case: &Case, system: &System, body: &Body) -> Result<Vec<Vec<f64>>> {
    let settings = DynamicSettings { step: WHOLE_STEP * page.step, ..DynamicSettings::default() };
    let initial = State::rest(system.mesh().nodes.len());
    let pressures = |_: Second| vec![0.0; body.cavities.len()];
    let problem = InitialValueProblem { settings: &settings, initial: &initial, pressures: &pressures };
    let (mut shapes, mut count) = (Vec::new(), 0);
    let mut keep = |_: Second, state: &State| {
        count += 1;
        if count % EVERY == 0 {
            shapes.push(state.displacement.clone());
        }
    };
    body.solver(case)?.integrate(&problem, WHOLE_STEPS, &mut keep)?;
    Ok(shapes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loads_rise_smoothly_from_none_to_all() {
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 7.0].map(smooth_rise), [0.0, 0.0, 0.5, 1.0, 1.0]);
    }
}
