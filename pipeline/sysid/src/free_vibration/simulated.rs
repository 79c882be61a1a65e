//! The finite-element model of a free vibration test: equilibrium under its loads, and the motion after the release.

use std::path::Path;

use fem::{DynamicSettings, Equilibrium, InitialValueProblem, Parameter, Solver, State, StaticSettings};
use optimize::optimisers::gauss_newton::{GaussNewton, Settings};
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals, minimise};
use si::{Metre, Pascal, Second, Series};

use super::page::Page;
use diagnostics::{Diagnostic, Result};
use simulate::case::{Case, read};
use simulate::{Body, Loaded, load};

/// A page's case with its mesh.
pub struct Bench<'a> {
    /// The page.
    pub page: &'a Page,
    case: Case,
    loaded: Loaded,
}

/// An identified modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// Its relative standard deviation, from the scatter of markers and repeats.
    pub sigma: f64,
    /// Number of simulations.
    pub simulations: usize,
    /// Mean static deflection of the compared markers, m.
    pub settled: Metre,
}

impl<'a> Bench<'a> {
    /// The case of a page that lies in `folder`.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the case or its mesh is refused.
    pub fn new(page: &'a Page, folder: &Path) -> Result<Self> {
        let path = folder.join(&page.case);
        let case = read(&path)?;
        let loaded = load(&case, path.parent().unwrap_or(Path::new(".")))?;
        Ok(Self { page, case, loaded })
    }

    fn with(&self, law: &str) -> Case {
        let mut case = self.case.clone();
        case.region[0].material = law.to_owned();
        case
    }

    /// The modulus of the first region that minimises the misfit to the `measured` static deflections (recordings × markers, m).
    ///
    /// # Errors
    /// A [`Diagnostic`] when the law is unknown or an equilibrium is not found.
    pub fn fit(&self, law: &str, measured: &[Vec<Metre>]) -> Result<Found> {
        let case = self.with(law);
        let body = Body::new(&case, &self.loaded)?;
        let mut resting = Resting {
            markers: self.markers(&body)?,
            solver: body.solver(&case)?,
            pressures: body.pressures(&case, |chamber| chamber.pressure.at_level(1.0)),
            poissons_ratio: case.region[0].poissons_ratio,
            shape: None,
        };
        let mut diagnostic = None;
        let history = minimise(&mut self.search()?, &mut |batch: &[Vec<f64>], _: Needs| {
            let answers: Result<Vec<_>> = batch.iter().map(|at| resting.weigh(at, measured, self.page.sigma)).collect();
            answers.map_err(|lost| {
                diagnostic = Some(lost.while_doing(law));
                OptimiseError::Length { what: "the answers", found: 0, expected: batch.len() }
            })
        });
        let history = history.map_err(|e| diagnostic.unwrap_or_else(|| Diagnostic::from(e)))?;
        let Evaluation { at, residuals: Some(residuals), .. } = &history.best else {
            return Err(Diagnostic::new(
                "the fit has no residuals",
                "its best point was evaluated without them",
                "report it with the page",
            ));
        };
        let sigma = residuals.posterior(1)?.sigma(0);
        let (youngs_modulus, simulations) = (at[0].exp(), history.entries.len());
        Ok(Found { youngs_modulus, sigma, simulations, settled: resting.settled(youngs_modulus)? })
    }

    fn search(&self) -> Result<GaussNewton> {
        let [low, high] = self.page.range.map(f64::ln);
        let bounds = Bounds { low: vec![low], high: vec![high] };
        let search = Problem::new(&["E"], vec![0.5 * (low + high)], bounds)?;
        GaussNewton::new(&search, &Settings { step_tolerance: 1e-5, ..Settings::default() }).map_err(Diagnostic::from)
    }

    /// The mean displacement of the compared markers after the release, with stiffness-proportional damping β (s).
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn release(&self, law: &str, e: Pascal, beta: Second) -> Result<Series> {
        let case = self.with(law);
        let body = Body::new(&case, &self.loaded)?;
        let markers = self.markers(&body)?;
        let mut solver = body.solver(&case)?;
        solver.set_elastic(0, e, case.region[0].poissons_ratio)?;
        let settings = DynamicSettings { step: self.page.step, stiffness_damping: beta, ..DynamicSettings::default() };
        let steps = (self.page.swing[1] / self.page.step).ceil() as usize + 1;
        let mut fall = vec![0.0];
        let mut observe = |_: Second, state: &State| {
            fall.push(markers.iter().map(|mark| mark.of(&state.displacement)).sum::<f64>() / markers.len() as f64);
        };
        let pressures = |time: Second| body.pressures(&case, |chamber| chamber.pressure.at(time));
        let rest = State::rest(body.solid.nodes().len());
        solver.integrate(
            &InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures },
            steps,
            &mut observe,
        )?;
        Series::new(0.0, 1.0 / self.page.step, fall).map_err(Diagnostic::from)
    }

    fn markers(&self, body: &Body) -> Result<Vec<Mark>> {
        let compared = self.page.marker.iter().filter(|marker| marker.compared);
        let on = compared.filter_map(|marker| marker.on);
        Ok(on.map(|at| Mark { weights: body.solid.embed(at).0.weights, axis: self.page.along as usize }).collect())
    }
}

/// Equilibria of a body under its loads for a sequence of moduli.
struct Resting {
    markers: Vec<Mark>,
    solver: Solver,
    pressures: Vec<Pascal>,
    poissons_ratio: f64,
    /// The last equilibrium.
    shape: Option<Equilibrium>,
}

impl Resting {
    /// The shape with Young's modulus `e` (Pa), from the one before.
    fn rest(&mut self, e: Pascal) -> Result<Equilibrium> {
        self.solver.set_elastic(0, e, self.poissons_ratio)?;
        let start = self.shape.as_ref().map(|shape| shape.displacement.as_slice());
        let found = self.solver.equilibrium(&self.pressures, start, &StaticSettings::default());
        let found = found?;
        self.shape = Some(found.clone());
        Ok(found)
    }

    /// Mean displacement of the markers, m.
    fn settled(&mut self, e: Pascal) -> Result<Metre> {
        let shape = self.rest(e)?;
        Ok(self.markers.iter().map(|mark| mark.of(&shape.displacement)).sum::<f64>() / self.markers.len() as f64)
    }

    /// Residuals against what was `measured` (recordings × markers, m) at a logarithm of the modulus, in deviations `sigma` (m).
    fn weigh(&mut self, at: &[f64], measured: &[Vec<Metre>], sigma: Metre) -> Result<Evaluation> {
        let e = at[0].exp();
        let shape = self.rest(e)?;
        let sensitivity = self.solver.sensitivity(&shape, Parameter::YoungsModulus(0))?;
        let falls: Vec<f64> = self.markers.iter().map(|mark| mark.of(&shape.displacement)).collect();
        let sensitivities: Vec<f64> = self.markers.iter().map(|mark| e * mark.of(&sensitivity) / sigma).collect();
        let off = |seen: &Vec<f64>| falls.iter().zip(seen).map(|(s, m)| (s - m) / sigma).collect::<Vec<_>>();
        let values = measured.iter().flat_map(off).collect();
        let residuals = Residuals { values, jacobian: sensitivities.repeat(measured.len()) };
        let (loss, gradient) = (residuals.half_sum_of_squares(), Some(residuals.gradient(1)));
        Ok(Evaluation { at: at.to_vec(), loss, gradient, residuals: Some(residuals) })
    }
}

/// A point of the body along one axis.
struct Mark {
    weights: Vec<(u32, f64)>,
    axis: usize,
}

impl Mark {
    fn of(&self, field: &[f64]) -> f64 {
        self.weights.iter().map(|(node, weight)| weight * field[3 * *node as usize + self.axis]).sum()
    }
}
