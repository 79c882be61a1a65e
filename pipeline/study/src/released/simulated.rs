//! Simulated: the same body by the finite elements, at rest under its loads and on its way there.
//!
//! Stands on: `case`, `simulate` (its body), fem, fit. Never knows: a recording's file.

use std::path::Path;

use fem::{Equilibrium, March, Parameter, Solver, State, StaticSettings};
use fit::optimisers::gauss_newton::{GaussNewton, Settings};
use fit::{Bounds, Evaluation, FitError, Needs, Residuals, Search, minimise};
use si::{Metre, Pascal, Second, Series};

use super::page::Page;
use crate::case::{Case, read};
use crate::fault::{Fault, Outcome};
use crate::simulate::{Body, Loaded, load};

/// A page's case with its mesh.
pub struct Bench<'a> {
    page: &'a Page,
    case: Case,
    loaded: Loaded,
}

/// A modulus that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// Relative standard deviation of it, by the scatter of the marks and repeats.
    pub sigma: f64,
    /// Simulations that it took.
    pub simulations: usize,
    /// Mean fall of the compared marks at rest, m.
    pub settled: Metre,
}

impl<'a> Bench<'a> {
    /// The case of a page that lies in `folder`.
    ///
    /// # Errors
    /// A [`Fault`] when the case or its mesh is refused.
    pub fn new(page: &'a Page, folder: &Path) -> Outcome<Self> {
        let path = folder.join(&page.case);
        let case = read(&path).map_err(Fault::from_tool)?;
        let loaded = load(&case, path.parent().unwrap_or(Path::new(".")))?;
        Ok(Self { page, case, loaded })
    }

    fn with(&self, law: &str) -> Case {
        let mut case = self.case.clone();
        case.region[0].material = law.to_owned();
        case
    }

    /// The modulus of the first region with which the marks settle where they were `measured` (recordings × marks, m).
    ///
    /// # Errors
    /// A [`Fault`] when the law is unknown or an equilibrium is not found.
    pub fn fit(&self, law: &str, measured: &[Vec<Metre>]) -> Outcome<Found> {
        let case = self.with(law);
        let body = Body::new(&case, &self.loaded)?;
        let mut resting = Resting {
            marks: self.marks(&body)?,
            solver: body.solver(&case)?,
            pressures: body.pressures(&case, |chamber| chamber.pressure.at_level(1.0)),
            poissons_ratio: case.region[0].poissons_ratio,
            shape: None,
        };
        let mut fault = None;
        let history = minimise(&mut self.search()?, &mut |batch: &[Vec<f64>], _: Needs| {
            let answers: Outcome<Vec<_>> =
                batch.iter().map(|at| resting.weigh(at, measured, self.page.sigma)).collect();
            answers.map_err(|lost| {
                fault = Some(Fault::from_tool(format!("{law}: {lost}")));
                FitError::Length { what: "the answers", found: 0, expected: batch.len() }
            })
        });
        let history = history.map_err(|e| fault.unwrap_or_else(|| Fault::from_tool(e)))?;
        let Evaluation { at, residuals: Some(residuals), .. } = &history.best else {
            return Err(Fault::from_tool("the fit kept no residuals"));
        };
        let sigma = residuals.posterior(1).map_err(Fault::from_tool)?.sigma(0);
        let (youngs_modulus, simulations) = (at[0].exp(), history.tried.len());
        Ok(Found { youngs_modulus, sigma, simulations, settled: resting.settled(youngs_modulus)? })
    }

    fn search(&self) -> Outcome<GaussNewton> {
        let [low, high] = self.page.range.map(f64::ln);
        let bounds = Bounds { low: vec![low], high: vec![high] };
        let search = Search::new(&["E"], vec![0.5 * (low + high)], bounds).map_err(Fault::from_tool)?;
        GaussNewton::new(&search, &Settings { step_tolerance: 1e-5, ..Settings::default() }).map_err(Fault::from_tool)
    }

    /// The mean fall of the compared marks after the release, with stiffness-proportional damping β (s).
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn release(&self, law: &str, e: Pascal, beta: Second) -> Outcome<Series> {
        let case = self.with(law);
        let body = Body::new(&case, &self.loaded)?;
        let marks = self.marks(&body)?;
        let mut solver = body.solver(&case)?;
        solver.set_elastic(0, e, case.region[0].poissons_ratio).map_err(Fault::from_tool)?;
        let march = March { step: self.page.step, stiffness_damping: beta, ..March::default() };
        let steps = (self.page.swing[1] / self.page.step).ceil() as usize + 1;
        let mut fall = vec![0.0];
        let mut observe = |_: Second, state: &State| {
            fall.push(marks.iter().map(|mark| mark.of(&state.displacement)).sum::<f64>() / marks.len() as f64);
        };
        let pressures = |time: Second| body.pressures(&case, |chamber| chamber.pressure.at(time));
        let rest = State::rest(body.solid.nodes().len());
        solver.march(&march, &rest, &pressures, steps, &mut observe).map_err(Fault::from_tool)?;
        Series::new(0.0, 1.0 / self.page.step, fall).map_err(Fault::from_tool)
    }

    fn marks(&self, body: &Body) -> Outcome<Vec<Mark>> {
        let compared = self.page.marker.iter().filter(|marker| marker.compared);
        let on = compared.filter_map(|marker| marker.on);
        Ok(on.map(|at| Mark { weights: body.solid.embed(at).0.weights, axis: self.page.along as usize }).collect())
    }
}

/// A body that comes to rest under its loads, with one modulus after the other.
struct Resting {
    marks: Vec<Mark>,
    solver: Solver,
    pressures: Vec<Pascal>,
    poissons_ratio: f64,
    /// The last one found.
    shape: Option<Equilibrium>,
}

impl Resting {
    /// The shape with Young's modulus `e` (Pa), from the one before.
    fn rest(&mut self, e: Pascal) -> Outcome<Equilibrium> {
        self.solver.set_elastic(0, e, self.poissons_ratio).map_err(Fault::from_tool)?;
        let start = self.shape.as_ref().map(|shape| shape.displacement.as_slice());
        let found = self.solver.equilibrium(&self.pressures, start, &StaticSettings::default());
        let found = found.map_err(Fault::from_tool)?;
        self.shape = Some(found.clone());
        Ok(found)
    }

    /// Mean fall of the marks, m.
    fn settled(&mut self, e: Pascal) -> Outcome<Metre> {
        let shape = self.rest(e)?;
        Ok(self.marks.iter().map(|mark| mark.of(&shape.displacement)).sum::<f64>() / self.marks.len() as f64)
    }

    /// Residuals against what was `measured` (recordings × marks, m) at a logarithm of the modulus, in deviations `sigma` (m).
    fn weigh(&mut self, at: &[f64], measured: &[Vec<Metre>], sigma: Metre) -> Outcome<Evaluation> {
        let e = at[0].exp();
        let shape = self.rest(e)?;
        let slope = self.solver.sensitivity(&shape, Parameter::YoungsModulus(0)).map_err(Fault::from_tool)?;
        let falls: Vec<f64> = self.marks.iter().map(|mark| mark.of(&shape.displacement)).collect();
        let slopes: Vec<f64> = self.marks.iter().map(|mark| e * mark.of(&slope) / sigma).collect();
        let off = |seen: &Vec<f64>| falls.iter().zip(seen).map(|(s, m)| (s - m) / sigma).collect::<Vec<_>>();
        let values = measured.iter().flat_map(off).collect();
        let residuals = Residuals { values, jacobian: slopes.repeat(measured.len()) };
        let (loss, gradient) = (residuals.half_square(), Some(residuals.gradient(1)));
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
