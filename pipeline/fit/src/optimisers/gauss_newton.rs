//! Gauss-Newton with the damping of Levenberg and Marquardt, inside of bounds.
//!
//! Each iteration solves (JᵀJ + λ diag JᵀJ) δ = −Jᵀr and tries θ + δ. A step that lowers ½ ‖r‖² is taken and λ falls
//! with the quality of the linear model; any other is dropped and λ rises.      [marquardt1963], [madsen2004] equation 2.21
//! A parameter on its bound with a gradient that points outwards is held there for the step.
//!
//! Stands on: the contract and `least_squares`. Never knows: another optimiser.

use crate::optimiser::{answers_fit, sound_gradient};
use crate::{Evaluation, Finished, FitError, Needs, Optimiser, Residuals, Search};

/// Its name.
pub const NAME: &str = "gauss_newton";

/// How Gauss-Newton walks.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// λ at the start; small where the start is good.
    pub damping: f64,
    /// It has converged when no parameter moves by more than this, in units of the parameters.
    pub step_tolerance: f64,
    /// At most so many evaluations, dropped steps included.
    pub iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { damping: 1e-3, step_tolerance: 1e-6, iterations: 50 }
    }
}

/// Beyond this damping the step is shorter than any tolerance of use: the loss and its derivative disagree.
const DAMPING_LIMIT: f64 = 1e12;

/// Gauss-Newton on its way.
pub struct GaussNewton {
    search: Search,
    set: Settings,
    asked: Vec<f64>,
    best: Option<Evaluation>,
    damping: f64,
    rise: f64,
    evaluations: usize,
    finished: Option<Finished>,
}

impl GaussNewton {
    /// Gauss-Newton at the start of a search.
    ///
    /// # Errors
    /// [`FitError::Setting`] when a setting leaves no step to make.
    pub fn new(search: &Search, set: &Settings) -> Result<Self, FitError> {
        let refuse = |setting, value, needed| Err(FitError::Setting { optimiser: NAME, setting, value, needed });
        if !(set.damping > 0.0 && set.damping.is_finite()) {
            return refuse("damping", set.damping, "above 0");
        }
        if set.iterations == 0 {
            return refuse("iterations", 0.0, "at least 1");
        }
        Ok(Self {
            asked: search.start().to_vec(),
            search: search.clone(),
            set: set.clone(),
            best: None,
            damping: set.damping,
            rise: 2.0,
            evaluations: 0,
            finished: None,
        })
    }

    /// Takes the trial and lowers the damping, or drops it and raises the damping.
    fn judge(&mut self, trial: &Evaluation) {
        let (Some(base), Some(new)) = (&self.best, &trial.residuals) else {
            self.best = Some(trial.clone());
            return;
        };
        let Some(old) = &base.residuals else { return };
        let step: Vec<f64> = trial.at.iter().zip(&base.at).map(|(a, b)| a - b).collect();
        let fall = old.half_square() - new.half_square();
        let quality = fall / old.foreseen_fall(&step);
        if fall > 0.0 && quality > 0.0 {
            self.damping *= (1.0 - (2.0 * quality - 1.0).powi(3)).max(1.0 / 3.0);
            self.rise = 2.0;
            self.best = Some(trial.clone());
        } else {
            self.drop_step();
        }
    }

    fn drop_step(&mut self) {
        self.damping *= self.rise;
        self.rise *= 2.0;
    }

    /// The next trial from the best point; finishes when it would lie where the best one does.
    fn plan(&mut self) -> Result<(), FitError> {
        let Some(Evaluation { at, residuals: Some(residuals), .. }) = &self.best else { return Ok(()) };
        let free = self.free_axes(at, residuals);
        if free.iter().all(|f| !f) {
            self.finished = Some(Finished::Converged { because: "every parameter is held by its bound" });
            return Ok(());
        }
        let Some(step) = residuals.damped_step(self.damping, &free) else {
            let why = "JᵀJ is singular: some change of the parameters leaves every residual as it is".to_owned();
            return Err(FitError::Undetermined { parameters: self.search.dimension(), why });
        };
        let wish: Vec<f64> = at.iter().zip(&step).map(|(x, s)| x + s).collect();
        let next = self.search.bounds().clamp(&wish);
        let longest = next.iter().zip(at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        self.asked = next;
        if longest < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "no parameter moves any more" });
        } else if self.damping > DAMPING_LIMIT || self.evaluations == self.set.iterations {
            self.finished = Some(Finished::Budget);
        }
        Ok(())
    }

    fn free_axes(&self, at: &[f64], residuals: &Residuals) -> Vec<bool> {
        let bounds = self.search.bounds();
        let gradient = residuals.gradient(at.len());
        let held =
            |i: usize| (at[i] <= bounds.low[i] && gradient[i] > 0.0) || (at[i] >= bounds.high[i] && gradient[i] < 0.0);
        (0..at.len()).map(|i| !held(i)).collect()
    }

    /// Refuses residuals of a wrong shape, or a Jacobian that no step can be made from.
    fn sound(&self, told: &Evaluation) -> Result<(), FitError> {
        let at = || self.search.describe(&told.at);
        let Some(residuals) = &told.residuals else {
            return Err(FitError::Missing { optimiser: NAME, missing: "residuals and Jacobian", at: at() });
        };
        let expected = residuals.values.len() * self.search.dimension();
        if residuals.jacobian.len() != expected {
            return Err(FitError::Length { what: "the Jacobian", found: residuals.jacobian.len(), expected });
        }
        let square = residuals.half_square();
        if !square.is_finite() {
            return Err(FitError::Loss { loss: square, at: at() });
        }
        let columns = column_sizes(residuals, self.search.dimension());
        let sizes = Evaluation { gradient: Some(columns), ..Evaluation::of_loss(told.at.clone(), told.loss) };
        sound_gradient(NAME, &self.search, &sizes, true).map(drop)
    }
}

/// The length of each column of the Jacobian (parameters): zero where no residual feels the parameter.
fn column_sizes(residuals: &Residuals, parameters: usize) -> Vec<f64> {
    let square = |j: usize| residuals.jacobian.iter().skip(j).step_by(parameters).map(|v| v * v).sum::<f64>();
    (0..parameters).map(|j| square(j).sqrt()).collect()
}

impl Optimiser for GaussNewton {
    fn name(&self) -> &'static str {
        NAME
    }

    fn needs(&self) -> Needs {
        Needs::Residuals
    }

    fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.finished.is_some() { Vec::new() } else { vec![self.asked.clone()] }
    }

    fn tell(&mut self, told: &[Evaluation]) -> Result<(), FitError> {
        answers_fit(NAME, &self.search, std::slice::from_ref(&self.asked), told)?;
        self.evaluations += 1;
        if told[0].loss == f64::INFINITY && self.best.is_some() {
            self.drop_step();
        } else {
            self.sound(&told[0])?;
            self.judge(&told[0]);
        }
        self.plan()
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.best.as_ref()
    }
}
