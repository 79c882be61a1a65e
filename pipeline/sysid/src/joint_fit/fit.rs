//! One law fitted to some conditions of all tests together, with its posterior and what it predicts of every condition.
//!
//! Residuals are relative errors over the deviations by which a good model misses them. A test that is missed by more, by all of its
//! quantities together, has its deviations multiplied until it is not: an unsuited law has wide intervals, and no test drowns the others.

use nalgebra::{DMatrix, DVector};
use optimize::optimisers::gauss_newton::{GaussNewton, Settings};
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals, minimise};

use super::laws::Law;
use super::parameters::Parameter;
use super::test::{Memory, Place, Predicted, Test};
use diagnostics::Result;

/// Rounds in which the deviations of tests are found.
const ROUNDS: usize = 2;
/// Evaluations of a round, and the step that ends it, of the width of a parameter's range.
const EVALUATIONS: usize = 12;
const STEP: f64 = 2e-3;
// A fall of ½ χ² by so much is a step of a fifth of a standard deviation.
const FALL: f64 = 2e-2;
/// Steps of ln E with which a first point is found at which every test can be evaluated.
// The neo-Hookean arm has no equilibrium at 200 mbar where other laws begin; five steps reach 3.5 times the modulus.
const STIFFENING: f64 = 0.25;
const STIFFENINGS: usize = 6;
/// The farthest that a parameter moves in a step, as a part of its range.
const LONGEST: f64 = 0.15;

/// A condition: the number of its test, and its own.
pub(super) type Which = (usize, usize);

/// A law with the tests.
#[derive(Clone, Copy)]
pub(super) struct Fit<'a> {
    pub law: &'static Law,
    pub tests: &'a [Box<dyn Test>],
}

/// Where a fit begins.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub point: Vec<f64>,
    /// Factor of the deviations of each test.
    pub scales: Vec<f64>,
    pub memory: Memory,
    /// Searches, after each of which the scales are found again.
    pub rounds: usize,
}

/// The end of a fit.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub point: Vec<f64>,
    pub covariance: DMatrix<f64>,
    pub scales: Vec<f64>,
    /// ½ ‖r‖² with the priors.
    pub loss: f64,
    pub evaluations: usize,
    pub memory: Memory,
}

impl Fit<'_> {
    /// Shared parameters, then those of each test.
    pub fn parameters(&self) -> Vec<Parameter> {
        let test_parameters = self.tests.iter().flat_map(|test| {
            let with_test_name = |parameter: Parameter| Parameter {
                name: format!("{} of {}", parameter.name, test.name()),
                ..parameter
            };
            test.parameters().into_iter().map(with_test_name).collect::<Vec<_>>()
        });
        self.law.parameters().into_iter().chain(test_parameters).collect()
    }

    /// The first of a test's own parameters, and their number.
    fn own_parameters(&self, test: usize) -> (usize, usize) {
        let count = |test: &dyn Test| test.parameters().len();
        let preceding: usize = self.tests[..test].iter().map(|test| count(test.as_ref())).sum();
        (self.law.parameters().len() + preceding, count(self.tests[test].as_ref()))
    }

    /// The start without anything known.
    pub fn start(&self) -> Start {
        let point = self.parameters().iter().map(|parameter| parameter.start).collect();
        Start { point, scales: vec![1.0; self.tests.len()], memory: Memory::new(), rounds: ROUNDS }
    }

    /// Predictions of a condition, with their derivatives by all parameters.
    ///
    /// # Errors
    /// A diagnostic where no shape or motion is found.
    pub(crate) fn predict_condition(
        &self,
        point: &[f64],
        (test, condition): Which,
        memory: &mut Memory,
    ) -> Result<Vec<Predicted>> {
        let shared = self.law.parameters().len();
        let (first, count) = self.own_parameters(test);
        let test_point = Place { law: self.law, shared: &point[..shared], own: &point[first..first + count] };
        let spread = |predicted: Predicted| {
            let mut gradient = vec![0.0; point.len()];
            gradient[..shared].copy_from_slice(&predicted.gradient[..shared]);
            gradient[first..first + count].copy_from_slice(&predicted.gradient[shared..]);
            Predicted { value: predicted.value, gradient }
        };
        Ok(self.tests[test].predict_condition(&test_point, condition, memory)?.into_iter().map(spread).collect())
    }

    /// Residuals of the conditions `used` and of the priors; those of a test are divided by its scale.
    fn residuals(
        &self,
        (point, scales): (&[f64], &[f64]),
        used: &[Which],
        memory: &mut Memory,
    ) -> Result<(Residuals, Vec<usize>)> {
        let (mut residuals, mut owners) = (Residuals { values: Vec::new(), jacobian: Vec::new() }, Vec::new());
        for &(test, condition) in used {
            let quantities = &self.tests[test].conditions()[condition].quantities;
            for (quantity, predicted) in
                quantities.iter().zip(self.predict_condition(point, (test, condition), memory)?)
            {
                let Some(measured) = quantity.measured else { continue };
                let weight = 1.0 / (measured * quantity.sigma * scales[test]);
                residuals.values.push(weight * (predicted.value - measured));
                residuals.jacobian.extend(predicted.gradient.iter().map(|slope| weight * slope));
                owners.push(test);
            }
        }
        for (p, parameter) in self.parameters().iter().enumerate() {
            let [mean, sigma] = parameter.knowledge();
            residuals.values.push((point[p] - mean) / sigma);
            residuals.jacobian.extend((0..point.len()).map(|k| if k == p { 1.0 / sigma } else { 0.0 }));
        }
        Ok((residuals, owners))
    }

    /// Fits the law to the conditions `used`.
    ///
    /// # Errors
    /// A diagnostic when nothing can be evaluated at the start.
    pub fn run(&self, start: Start, used: &[Which]) -> Result<Fitted> {
        let Start { mut point, mut scales, mut memory, rounds } = start;
        let mut evaluations = self.stiffen_until_solvable((&mut point, &scales), used, &mut memory)?;
        for _ in 0..rounds {
            let (next, count) = self.minimise((&point, &scales), used, &mut memory)?;
            (point, evaluations) = (next, evaluations + count);
            let (residuals, owners) = self.residuals((&point, &scales), used, &mut memory)?;
            scales = self.rescale_tests(&scales, &residuals.values, &owners);
        }
        let (residuals, _) = self.residuals((&point, &scales), used, &mut memory)?;
        let covariance = self.covariance(&residuals, point.len());
        Ok(Fitted { covariance, loss: residuals.half_sum_of_squares(), point, scales, evaluations, memory })
    }

    /// Raises E until everything can be evaluated: walls of a law that is too soft balloon. Returns the evaluations that it took.
    ///
    /// # Errors
    /// The diagnostic of the stiffest body that was tried.
    fn stiffen_until_solvable(
        &self,
        (point, scales): (&mut [f64], &[f64]),
        used: &[Which],
        memory: &mut Memory,
    ) -> Result<usize> {
        for count in 0..STIFFENINGS {
            match self.residuals((point, scales), used, memory) {
                Ok(_) => return Ok(count),
                Err(error) if count + 1 == STIFFENINGS => return Err(error),
                Err(_) => point[0] += STIFFENING,
            }
        }
        Ok(STIFFENINGS)
    }

    /// The minimum from a point on, and the evaluations that it took.
    fn minimise(
        &self,
        (from, scales): (&[f64], &[f64]),
        used: &[Which],
        memory: &mut Memory,
    ) -> Result<(Vec<f64>, usize)> {
        let parameters = self.parameters();
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        let end = |k: usize| parameters.iter().map(|parameter| parameter.range[k]).collect();
        let problem = Problem::new(&names, from.to_vec(), Bounds { low: end(0), high: end(1) })?;
        let longest_step = parameters.iter().map(|p| LONGEST * (p.range[1] - p.range[0])).collect();
        let settings = Settings {
            damping: 1e-2,
            step_tolerance: STEP,
            fall_tolerance: FALL,
            iterations: EVALUATIONS,
            longest_step,
        };
        let mut optimiser = GaussNewton::new(&problem, &settings)?;
        let mut count = 0;
        let mut evaluate = |batch: &[Vec<f64>], _: Needs| -> std::result::Result<Vec<Evaluation>, OptimiseError> {
            count += batch.len();
            Ok(batch.iter().map(|point| self.evaluate_point((point, scales), used, memory)).collect())
        };
        let best = minimise(&mut optimiser, &mut evaluate)?.best;
        Ok((best.at, count))
    }

    /// A point of the search; of infinite loss where no shape or motion is found.
    fn evaluate_point(&self, (point, scales): (&[f64], &[f64]), used: &[Which], memory: &mut Memory) -> Evaluation {
        match self.residuals((point, scales), used, memory) {
            Ok((residuals, _)) if residuals.values.iter().all(|r| r.is_finite()) => {
                let (loss, gradient) = (residuals.half_sum_of_squares(), Some(residuals.gradient(point.len())));
                Evaluation { at: point.to_vec(), loss, gradient, residuals: Some(residuals) }
            }
            _ => Evaluation::of_loss(point.to_vec(), f64::INFINITY),
        }
    }

    /// The scale of each test with which its residuals are one standard deviation on the mean, or 1 where they are less; a test of which nothing
    /// is fitted takes the largest.
    fn rescale_tests(&self, scales: &[f64], residuals: &[f64], owners: &[usize]) -> Vec<f64> {
        let rms = |test: usize| {
            let squares: Vec<f64> =
                owners.iter().zip(residuals).filter(|(owner, _)| **owner == test).map(|(_, r)| r * r).collect();
            (!squares.is_empty()).then(|| scales[test] * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
        };
        let rms_scales: Vec<Option<f64>> = (0..scales.len()).map(rms).collect();
        let largest = rms_scales.iter().flatten().copied().fold(1.0, f64::max);
        // Never below one: a test of few quantities that is met by chance would count for more than it was measured to.
        rms_scales.into_iter().map(|scale| scale.unwrap_or(largest).max(1.0)).collect()
    }

    fn covariance(&self, residuals: &Residuals, count: usize) -> DMatrix<f64> {
        let jacobian = DMatrix::from_row_slice(residuals.values.len(), count, &residuals.jacobian);
        let information = jacobian.tr_mul(&jacobian);
        information.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count))
    }
}

impl Fitted {
    /// Half width of the 95 % interval of a prediction: of the parameters, and of what a good model misses by.
    pub fn half_width(&self, predicted: &Predicted, (test, sigma): (usize, f64)) -> f64 {
        let slope = DVector::from_column_slice(&predicted.gradient);
        let parameters = (slope.transpose() * &self.covariance * &slope)[(0, 0)];
        let missed = self.scales[test] * sigma * predicted.value;
        1.959_964 * (parameters.max(0.0) + missed * missed).sqrt()
    }
}
