//! The Levenberg–Marquardt method \[marquardt1963\] for problems that are cheap to evaluate, run to the end in one call.
//!
//! Each trial solves (JᵀJ + λ D) δ = b with b = −Jᵀr and D = diag JᵀJ, and tries the point that δ leads to. A trial that lowers
//! ‖r‖² is accepted and λ falls by a factor, any other is rejected and λ rises by a factor. A problem gives its normal equations
//! itself, so that a sparse or blockwise Jacobian is never formed; [`fit`] takes plain residuals and central differences.
//!
//! Where one evaluation is a simulation, [`crate::optimisers::gauss_newton`] asks for points one by one, inside of bounds, with the
//! same damped solve.

use nalgebra::{DMatrix, DVector};

/// A sum of squares to minimise over points of any type.
pub trait LeastSquaresProblem {
    /// A point of the problem space.
    type Point;
    /// The normal equations at a point, `None` where the residuals are not defined.
    fn linearise(&self, at: &Self::Point) -> Option<NormalEquations>;
    /// ‖r‖² at a point, `None` where the residuals are not defined.
    fn sum_of_squares(&self, at: &Self::Point) -> Option<f64>;
    /// The point that a step leads to.
    fn after_step(&self, at: &Self::Point, step: &DVector<f64>) -> Self::Point;
    /// δ of (A + λ D) δ = b, `None` when the matrix is not positive definite; a problem whose matrix has a structure may solve by it.
    fn damped_step(&self, normal: &NormalEquations, damping: f64, scaling: Scaling) -> Option<DVector<f64>> {
        damped_step(normal.matrix.clone(), &normal.right, damping, scaling)
    }
}

/// JᵀJ, −Jᵀr and ‖r‖² of residuals r at one point.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    /// JᵀJ.
    pub matrix: DMatrix<f64>,
    /// −Jᵀr, the direction of steepest descent.
    pub right: DVector<f64>,
    /// ‖r‖².
    pub squares: f64,
}

/// How D is added to JᵀJ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scaling {
    /// The diagonal is multiplied by 1 + λ.
    Relative,
    /// λ times the diagonal is added, at least λ times this floor: a parameter that no residual depends on is then kept where it is
    /// instead of making the matrix singular.
    Floored(f64),
}

impl Scaling {
    /// An entry of the diagonal of A + λ D.
    pub fn damped_entry(self, entry: f64, damping: f64) -> f64 {
        match self {
            Self::Relative => entry * (1.0 + damping),
            Self::Floored(floor) => entry + damping * entry.max(floor),
        }
    }
}

/// Options of the iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// λ of the first trial.
    pub damping: f64,
    /// The least λ.
    pub min_damping: f64,
    /// The largest λ that is still entries.
    pub max_damping: f64,
    /// How D is added.
    pub scaling: Scaling,
    /// Whether a trial with an unchanged ‖r‖² is accepted; it ends the iteration.
    pub accept_equal: bool,
    /// The iteration ends with an accepted step that lowers ‖r‖² by no more than this share.
    pub gain_tolerance: f64,
    /// At most so many accepted steps.
    pub max_steps: usize,
    /// At most so many trials, accepted or not.
    pub max_trials: usize,
}

/// λ falls and rises by this factor: Marquardt's.
const FACTOR: f64 = 10.0;

/// The point with the least ‖r‖² that the iteration reaches from `start`, and its normal equations.
///
/// `None` when the residuals are not defined at the start or at an accepted point.
pub fn minimise<P: LeastSquaresProblem>(
    problem: &P,
    start: P::Point,
    options: &Options,
) -> Option<(P::Point, NormalEquations)> {
    let (mut point, mut damping, mut steps) = (start, options.damping, 0);
    let mut normal = problem.linearise(&point)?;
    for _ in 0..options.max_trials {
        if damping > options.max_damping || steps == options.max_steps {
            break;
        }
        let step = problem.damped_step(&normal, damping, options.scaling);
        let next_point = step.map(|step| problem.after_step(&point, &step));
        let squares = next_point.as_ref().and_then(|next_point| problem.sum_of_squares(next_point)).unwrap_or(f64::NAN);
        let is_accepted = squares < normal.squares || (options.accept_equal && squares == normal.squares);
        let Some(next_point) = next_point.filter(|_| is_accepted) else {
            // An undefined point and a singular matrix are rejections like any other: with more damping the step is shorter and the
            // matrix better conditioned.
            damping *= FACTOR;
            continue;
        };
        let converged = normal.squares - squares <= options.gain_tolerance * normal.squares;
        (point, steps, damping) = (next_point, steps + 1, (damping * (1.0 / FACTOR)).max(options.min_damping));
        normal = problem.linearise(&point)?;
        if converged {
            break;
        }
    }
    Some((point, normal))
}

/// δ of (A + λ D) δ = b, `None` when the matrix is not positive definite.
#[allow(non_snake_case)]
pub fn damped_step(mut A: DMatrix<f64>, b: &DVector<f64>, damping: f64, scaling: Scaling) -> Option<DVector<f64>> {
    for i in 0..A.nrows() {
        A[(i, i)] = scaling.damped_entry(A[(i, i)], damping);
    }
    Some(A.cholesky()?.solve(b))
}

/// Residuals as a function of the parameters, `None` where they are not defined.
pub type ResidualFunction<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + 'a;

/// Residuals whose Jacobian is taken by central differences.
pub struct Regression<'a> {
    /// The residuals.
    pub residuals: &'a ResidualFunction<'a>,
    /// Half the width of each parameter's difference.
    pub differences: &'a [f64],
    /// How many parameters are eliminated inside of `residuals`; they count in the degrees of freedom.
    pub eliminated: usize,
}

/// Parameters with their standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameters.
    pub at: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Vec<f64>,
    /// Standard deviation of the residuals.
    pub noise: f64,
}

impl LeastSquaresProblem for Regression<'_> {
    type Point = Vec<f64>;

    fn linearise(&self, point: &Vec<f64>) -> Option<NormalEquations> {
        let values = (self.residuals)(point)?;
        let jacobian = self.difference_jacobian(point)?;
        let right_side = -jacobian.tr_mul(&DVector::from_column_slice(&values));
        Some(NormalEquations {
            matrix: jacobian.tr_mul(&jacobian),
            right: right_side,
            squares: sum_of_squares(&values),
        })
    }

    fn sum_of_squares(&self, point: &Vec<f64>) -> Option<f64> {
        (self.residuals)(point).map(|values| sum_of_squares(&values))
    }

    fn after_step(&self, point: &Vec<f64>, step: &DVector<f64>) -> Vec<f64> {
        point.iter().zip(step.iter()).map(|(coordinate, change)| coordinate + change).collect()
    }
}

impl Regression<'_> {
    fn difference_jacobian(&self, point: &[f64]) -> Option<DMatrix<f64>> {
        let mut columns = Vec::new();
        for (i, difference) in self.differences.iter().enumerate() {
            let residuals_at = |change: f64| {
                let mut perturbed = point.to_vec();
                perturbed[i] += change;
                (self.residuals)(&perturbed)
            };
            let (upper, lower) = (residuals_at(*difference)?, residuals_at(-difference)?);
            let slopes = upper.iter().zip(&lower).map(|(u, d)| (u - d) / (2.0 * difference));
            columns.push(DVector::from_iterator(upper.len(), slopes));
        }
        Some(DMatrix::from_columns(&columns))
    }
}

/// From a peak of a spectrum a fit needs six steps; 60 are never reached. An unchanged ‖r‖² is accepted and ends the iteration: at the
/// minimum, round-off decides whether a trial is slightly better or slightly worse.
const REGRESSION: Options = Options {
    damping: 1e-3,
    min_damping: 1e-12,
    max_damping: 1e9_f64.next_down(),
    scaling: Scaling::Relative,
    accept_equal: true,
    gain_tolerance: 1e-13,
    max_steps: 60,
    max_trials: usize::MAX,
};

/// The parameters of a regression from `start`, with Σ = σ² (JᵀJ)⁻¹ and σ² = ‖r‖² / (degrees of freedom) [seber2003, chapter 2].
///
/// `None` when the residuals are not defined, there are no degrees of freedom left, or JᵀJ is singular.
pub fn fit(regression: &Regression, start: &[f64]) -> Option<Estimate> {
    let (point, normal) = minimise(regression, start.to_vec(), &REGRESSION)?;
    let residuals = (regression.residuals)(&point)?.len();
    let degrees_of_freedom = residuals.checked_sub(point.len() + regression.eliminated).filter(|&n| n > 0)?;
    let variance = normal.squares / degrees_of_freedom as f64;
    let covariance = normal.matrix.cholesky()?.inverse() * variance;
    Some(Estimate {
        sigma: (0..point.len()).map(|i| covariance[(i, i)].sqrt()).collect(),
        at: point,
        noise: variance.sqrt(),
    })
}

fn sum_of_squares(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decay_is_found_with_the_standard_deviations_that_its_noise_gives() {
        // noise of known size with a period that no decay can follow
        let noise = |i: usize| if i.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let data: Vec<f64> = (0..200).map(|i| 2.0 * (-0.02 * i as f64).exp() + noise(i)).collect();
        let residuals = |p: &[f64]| {
            Some(data.iter().enumerate().map(|(i, d)| p[0] * (-p[1] * i as f64).exp() - d).collect::<Vec<f64>>())
        };
        let regression = Regression { residuals: &residuals, differences: &[1e-5, 1e-7], eliminated: 0 };
        let found = fit(&regression, &[1.0, 0.05]).unwrap();
        assert!((found.at[0] - 2.0).abs() < 4.0 * found.sigma[0] && (found.at[1] - 0.02).abs() < 4.0 * found.sigma[1]);
        assert!((found.noise - 1e-3).abs() < 1e-4);
    }

    #[test]
    fn a_floor_keeps_a_parameter_that_no_residual_depends_on() {
        let normal = DMatrix::from_row_slice(2, 2, &[4.0, 0.0, 0.0, 0.0]);
        let right = DVector::from_row_slice(&[2.0, 0.0]);
        assert!(damped_step(normal.clone(), &right, 1e-3, Scaling::Relative).is_none());
        assert_eq!(damped_step(normal, &right, 1e-3, Scaling::Floored(1e-12)).unwrap()[1], 0.0);
    }

    /// The mean of a list with a scatter of one, and how often its residuals were evaluated.
    fn mean(eliminated: usize) -> (Estimate, usize) {
        let calls = std::cell::Cell::new(0);
        let residuals = |p: &[f64]| {
            calls.set(calls.get() + 1);
            Some((0..10).map(|i| p[0] - 5.0 - if i % 2 == 0 { 1.0 } else { -1.0 }).collect::<Vec<f64>>())
        };
        let found = fit(&Regression { residuals: &residuals, differences: &[1e-3], eliminated }, &[0.0]).unwrap();
        (found, calls.get())
    }

    #[test]
    fn eliminated_parameters_take_degrees_of_freedom() {
        // ten squares of one: σ² is 10 over the degrees of freedom
        assert!((mean(0).0.noise.powi(2) - 10.0 / 9.0).abs() < 1e-9);
        assert!((mean(3).0.noise.powi(2) - 10.0 / 6.0).abs() < 1e-9);
    }

    #[test]
    fn the_iteration_ends_with_the_step_that_lowers_nothing() {
        // a step costs four evaluations; a linear problem with a damping of 1e-3 is solved in five or six
        assert!(mean(0).1 < 32, "{} evaluations", mean(0).1);
    }
}
