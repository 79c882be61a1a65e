//! CMA-ES \[hansen2016\]: evolution strategy with covariance matrix adaptation, inside of bounds.
//!
//! The bounds are scaled to the unit cube, so one step size serves all parameters. The covariance is active: worse points remove
//! variance, by negative weights. Measured to 1e-8 on Rosenbrock's function in two and four parameters, ten points a generation, it
//! needs 510 and 1290 evaluations (medians of 2039 seeds), pycma 4.5 520 and 1310 (of 401), and without negative weights 590 and 1510.
//! A saved [`State`] continues bit for bit.

mod distribution;
mod sampling;

pub use distribution::State;

use distribution::Constants;
use nalgebra::{DMatrix, DVector};
use sampling::{from_cube, to_cube};

use crate::optimiser::{check_evaluations, keep_better};
use crate::{Evaluation, Finished, Needs, OptimiseError, Optimiser, Problem};

/// Its name.
pub const NAME: &str = "cma_es";

/// Settings of CMA-ES.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// λ, points a generation; at least 4.
    pub population: usize,
    /// Initial step size σ, as a share of the bounds' width.
    pub step: f64,
    /// It has converged when the longest half axis of the distribution is shorter than this share of the bounds' width.
    pub step_tolerance: f64,
    /// At most so many generations.
    pub generations: usize,
    /// Seed of its samples.
    pub seed: u64,
}

impl Default for Settings {
    /// Ten points a generation, as in the paper.
    fn default() -> Self {
        Self { population: 10, step: 0.3, step_tolerance: 1e-6, generations: 100, seed: 1 }
    }
}

/// CMA-ES between two generations.
pub struct CmaEs {
    problem: Problem,
    set: Settings,
    state: State,
    asked: Vec<Vec<f64>>,
    finished: Option<Finished>,
}

impl CmaEs {
    /// CMA-ES at the initial guess of a problem.
    ///
    /// # Errors
    /// [`OptimiseError::Setting`] when a setting permits no sample.
    pub fn new(problem: &Problem, set: &Settings) -> Result<Self, OptimiseError> {
        let n = problem.dimension();
        let state = State {
            generation: 0,
            mean: to_cube(problem.bounds(), problem.start()),
            sigma: set.step,
            covariance: DMatrix::<f64>::identity(n, n).as_slice().to_vec(),
            sigma_path: vec![0.0; n],
            covariance_path: vec![0.0; n],
            best: None,
        };
        Self::resume_from(problem, set, state)
    }

    /// CMA-ES from a saved state.
    ///
    /// # Errors
    /// [`OptimiseError`] when a setting permits no sample, or the state is of another problem.
    pub(crate) fn resume_from(problem: &Problem, set: &Settings, state: State) -> Result<Self, OptimiseError> {
        let setting_error =
            |setting, value, needed| Err(OptimiseError::Setting { optimiser: NAME, setting, value, needed });
        if set.population < 4 {
            return setting_error("population", set.population as f64, "at least 4");
        }
        if !(set.step > 0.0 && set.step.is_finite()) {
            return setting_error("step", set.step, "above 0");
        }
        if set.generations == 0 {
            return setting_error("generations", 0.0, "at least 1");
        }
        let (found, expected) = (state.mean.len(), problem.dimension());
        if found != expected || state.covariance.len() != expected * expected {
            return Err(OptimiseError::Length { what: "the saved state", found, expected });
        }
        let mut cma = Self { problem: problem.clone(), set: set.clone(), state, asked: Vec::new(), finished: None };
        cma.sample_population();
        Ok(cma)
    }

    /// The state that must be saved to continue later.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Samples the points of this generation.
    fn sample_population(&mut self) {
        let samples = sampling::sampled_population(&self.state, self.set.seed, self.set.population);
        self.asked = samples.iter().map(|sample| from_cube(self.problem.bounds(), sample)).collect();
    }

    /// Updates the distribution from the ranked evaluations.
    fn update_distribution(&mut self, evaluations: &[Evaluation]) {
        let constants = Constants::new(self.state.mean.len(), self.set.population);
        let mut ranking: Vec<usize> = (0..evaluations.len()).collect();
        // Points without a solution have an infinite loss and rank last; only ranks enter, so they need no replacement value.
        ranking.sort_by(|&a, &b| evaluations[a].loss.total_cmp(&evaluations[b].loss));
        let old_mean = DVector::from_column_slice(&self.state.mean);
        let step = |i: &usize| {
            (DVector::from_vec(to_cube(self.problem.bounds(), &evaluations[*i].at)) - &old_mean) / self.state.sigma
        };
        let steps: Vec<DVector<f64>> = ranking.iter().map(step).collect();
        self.state.adapt_distribution(&constants, &steps);
        self.state.generation += 1;
    }

    fn check_convergence(&mut self) {
        let (_, lengths) = self.state.principal_axes();
        let longest_axis = self.state.sigma * lengths.max();
        if longest_axis < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "the distribution has contracted to a point" });
        } else if self.state.generation >= self.set.generations as u64 {
            self.finished = Some(Finished::Budget);
        }
    }
}

impl Optimiser for CmaEs {
    fn name(&self) -> &'static str {
        NAME
    }

    fn needs(&self) -> Needs {
        Needs::Loss
    }

    fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.finished.is_some() { Vec::new() } else { self.asked.clone() }
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), OptimiseError> {
        check_evaluations(NAME, &self.problem, &self.asked, evaluations)?;
        evaluations.iter().for_each(|t| keep_better(&mut self.state.best, t));
        self.update_distribution(evaluations);
        self.check_convergence();
        self.sample_population();
        Ok(())
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.state.best.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounds;

    fn problem(n: usize) -> Problem {
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Problem::new(&names, vec![0.0; n], Bounds { low: vec![-2.0; n], high: vec![2.0; n] }).unwrap()
    }

    fn rosenbrock(at: &[f64]) -> f64 {
        at.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
    }

    fn answer(cma: &mut CmaEs, loss: fn(&[f64]) -> f64) -> f64 {
        let evaluations: Vec<Evaluation> =
            cma.ask().into_iter().map(|at| (loss(&at), at)).map(|(l, at)| Evaluation::of_loss(at, l)).collect();
        cma.tell(&evaluations).unwrap();
        cma.best().unwrap().loss
    }

    /// Evaluations until Rosenbrock's function falls below 1e-8: quartiles of 51 seeds.
    fn evaluations(n: usize) -> [usize; 3] {
        let run = |seed: u64| {
            let set = Settings { step: 0.125, generations: 1000, step_tolerance: 0.0, seed, ..Settings::default() };
            let mut cma = CmaEs::new(&problem(n), &set).unwrap();
            let generations = (1..1000).find(|_| answer(&mut cma, rosenbrock) < 1e-8);
            set.population * generations.expect("it converges")
        };
        let mut all: Vec<usize> = (1..=51).map(run).collect();
        all.sort_unstable();
        [12, 25, 38].map(|rank| all[rank])
    }

    /// pycma 4.5 with ten points a generation: 520 (quartiles 480, 570) and 1310 (1200, 1420), of 401 seeds. The median of 51 scatters
    /// by 2 %; without negative weights it is 590 and 1510.
    #[test]
    fn rosenbrocks_function_takes_no_more_evaluations_than_in_pycma() {
        let (two, four) = (evaluations(2), evaluations(4));
        assert!((440..=525).contains(&two[1]), "{two:?}");
        assert!((1100..=1310).contains(&four[1]), "{four:?}");
    }

    #[test]
    fn a_saved_state_continues_bit_for_bit() {
        let set = Settings { seed: 7, ..Settings::default() };
        let mut whole = CmaEs::new(&problem(3), &set).unwrap();
        for _ in 0..5 {
            answer(&mut whole, rosenbrock);
        }
        let mut rest = CmaEs::resume_from(&problem(3), &set, whole.state().clone()).unwrap();
        for _ in 0..5 {
            assert_eq!(whole.ask(), rest.ask());
            assert_eq!(answer(&mut whole, rosenbrock), answer(&mut rest, rosenbrock));
        }
        assert_eq!(whole.state(), rest.state());
    }

    #[test]
    fn another_seed_gives_another_sample() {
        let sample = |seed| CmaEs::new(&problem(2), &Settings { seed, ..Settings::default() }).unwrap().ask();
        assert_eq!(sample(1), sample(1));
        assert_ne!(sample(1), sample(2));
    }

    #[test]
    fn points_without_a_solution_rank_last() {
        let hole = |at: &[f64]| if at[0] < 0.0 { f64::INFINITY } else { (at[0] - 0.1).powi(2) + at[1].powi(2) };
        let mut cma = CmaEs::new(&problem(2), &Settings::default()).unwrap();
        while cma.finished().is_none() {
            answer(&mut cma, hole);
        }
        assert!((cma.best().unwrap().at[0] - 0.1).abs() < 1e-5, "{:?}", cma.best());
    }

    #[test]
    fn a_population_of_three_is_refused() {
        assert!(CmaEs::new(&problem(2), &Settings { population: 3, ..Settings::default() }).is_err());
    }
}
