//! Joint identification of the solids' moduli and of the stiffening of the softest one, Yeoh's C₂₀/C₁₀ and C₃₀/C₁₀.
//!
//! The levels of moderate strain determine the moduli, the highest ones the stiffening. Where no level reaches a strain at which the
//! silicone stiffens, a normal prior about the card's nominal ratios holds them, and their standard deviations stay those of the
//! prior; the uncertainty of the moduli includes that of the stiffening in either case.

use optimize::optimisers::{self, gauss_newton};
use optimize::{Bounds, Evaluation, Needs, Problem, Residuals};
use si::Point2;

use crate::levels::{Derivatives, LevelSolver};
use crate::misfit::Misfit;
use crate::model::{Elastic, Model};
use crate::search::Interrupted;
use diagnostics::{Diagnostic, Result};

/// Names of both ratios.
const RATIOS: [&str; 2] = ["C20/C10", "C30/C10"];
/// The farthest that a logarithm of a modulus and a ratio may move in one step: beyond it an inflated thin wall is another shape.
// Films of one highest pressure determine both poorly: without this the first step asked for a sheet twice as stiff and
// three times the stiffening, equilibria far from all that are known.
const LONGEST_MODULI: f64 = 0.2;
const LONGEST_RATIOS: [f64; 2] = [0.05, 0.05];
/// Bounds of both ratios: at the lower ones a bar's tension rises with its stretch up to 1.6.
const BOUNDS: [[f64; 2]; 2] = [[-0.1, 1.0], [-0.02, 2.0]];

/// The problem of moduli and stiffening.
pub struct StiffeningProblem<'a> {
    /// The model.
    pub model: &'a Model,
    /// The measured levels.
    pub misfit: &'a Misfit,
    /// The logarithms of the moduli over the nominal ones: their names, initial guess and bounds.
    pub moduli: &'a Problem,
    /// Standard deviations of the prior about the nominal ratios, no unit.
    pub prior_sigma: [f64; 2],
    /// The method.
    pub method: gauss_newton::Settings,
}

/// Moduli and stiffening with their residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct Stiffened {
    /// Logarithms of the moduli over the nominal ones, then both ratios.
    pub at: Vec<f64>,
    /// C₂₀/C₁₀ and C₃₀/C₁₀.
    pub ratios: [f64; 2],
    /// Whitened residuals of the levels and of the prior, by all parameters of `at`.
    pub residuals: Residuals,
}

impl StiffeningProblem<'_> {
    /// The moduli and ratios of the least misfit, found with `solver`. `progress` is called with the number of simulations.
    ///
    /// # Errors
    /// A [`Diagnostic`] when no equilibrium exists at the initial guess.
    pub fn identify(&self, solver: &mut LevelSolver, progress: &dyn Fn(usize)) -> Result<Stiffened> {
        let member = optimisers::by_name(gauss_newton::NAME)
            .ok_or_else(|| Diagnostic::new("there is no gauss_newton", "`optimize` does not list it", "restore it"))?;
        let mut settings = optimisers::Settings::default();
        let longest_step =
            [vec![LONGEST_MODULI; self.model.nominal.youngs_moduli.len()], LONGEST_RATIOS.to_vec()].concat();
        settings.gauss_newton = gauss_newton::Settings { longest_step, ..self.method.clone() };
        let mut optimiser = (member.build)(&self.joint_problem()?, &settings)?;
        let mut count = 0;
        let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            let mut evaluate = |point: &Vec<f64>| {
                count += 1;
                progress(count);
                self.evaluate_point(solver, point, count > 1).map_err(Interrupted)
            };
            batch.iter().map(&mut evaluate).collect()
        };
        let best = optimize::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?.best;
        let (residuals, ratios) = (residuals_of(&best)?.clone(), self.elastic_constants(&best.at).stiffening);
        Ok(Stiffened { at: best.at, ratios, residuals })
    }

    fn joint_problem(&self) -> Result<Problem> {
        let names: Vec<&str> = self.moduli.names().iter().map(String::as_str).chain(RATIOS).collect();
        let Bounds { low, high } = self.moduli.bounds();
        let end = |moduli: &[f64], k: usize| [moduli, &BOUNDS.map(|bound| bound[k])].concat();
        let bounds = Bounds { low: end(low, 0), high: end(high, 1) };
        let start = bounds.clamp(&[self.moduli.start(), &self.model.nominal.stiffening].concat());
        Ok(Problem::new(&names, start, bounds)?)
    }

    /// The constants at a point of the search.
    fn elastic_constants(&self, point: &[f64]) -> Elastic {
        let mut elastic = self.model.nominal.clone();
        let (moduli, ratios) = point.split_at(elastic.youngs_moduli.len());
        elastic.youngs_moduli.iter_mut().zip(moduli).for_each(|(modulus, log_ratio)| *modulus *= log_ratio.exp());
        elastic.stiffening.copy_from_slice(ratios);
        elastic
    }

    /// Residuals at a point; an infinite loss where `may_fail` and there is no equilibrium.
    fn evaluate_point(&self, solver: &mut LevelSolver, point: &[f64], may_fail: bool) -> Result<Evaluation> {
        let elastic = self.elastic_constants(point);
        let levels = match solver.solve(&elastic, Derivatives::StiffeningSensitivities) {
            Err(_) if may_fail => return Ok(Evaluation::of_loss(point.to_vec(), f64::INFINITY)),
            levels => levels?,
        };
        let markers: Vec<Vec<Point2>> = levels.iter().map(|level| level.markers.clone()).collect();
        let turns = [&elastic.youngs_moduli[..], &[1.0; 2]].concat();
        let mut residuals = self.misfit.residuals(&levels, &turns)?;
        self.add_prior(&elastic, &mut residuals);
        Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(point.to_vec(), self.misfit.loss(&markers)) })
    }

    fn add_prior(&self, elastic: &Elastic, residuals: &mut Residuals) {
        let moduli = elastic.youngs_moduli.len();
        for (k, sigma) in self.prior_sigma.into_iter().enumerate() {
            residuals.values.push((elastic.stiffening[k] - self.model.nominal.stiffening[k]) / sigma);
            let derivative = |parameter: usize| if parameter == moduli + k { 1.0 / sigma } else { 0.0 };
            residuals.jacobian.extend((0..moduli + 2).map(derivative));
        }
    }
}

/// The residuals of the `best` point of a search.
///
/// # Errors
/// A [`Diagnostic`] when it was evaluated without them.
pub fn residuals_of(best: &Evaluation) -> Result<&Residuals> {
    best.residuals.as_ref().ok_or_else(|| {
        let reason = "it was evaluated without them";
        Diagnostic::new("the best point has no residuals", reason, "report it with the recordings")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_rises_with_stretch_at_the_lower_bounds() {
        let [c20, c30] = BOUNDS.map(|bound| bound[0]);
        // P over 2 C₁₀ of an incompressible bar
        let tension = |stretch: f64| {
            let x = stretch * stretch + 2.0 / stretch - 3.0;
            (stretch - stretch.powi(-2)) * (1.0 + 2.0 * c20 * x + 3.0 * c30 * x * x)
        };
        let stretches: Vec<f64> = (0..=60).map(|i| 1.0 + 0.01 * f64::from(i)).collect();
        assert!(stretches.windows(2).all(|pair| tension(pair[1]) > tension(pair[0])));
        assert!(tension(1.8) < tension(1.75), "softer ratios would snap earlier");
    }
}
