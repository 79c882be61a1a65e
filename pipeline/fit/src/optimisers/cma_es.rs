//! CMA-ES: a cloud of points that moves, grows and turns towards where its better half fell.
//!
//! It works on the box scaled to a unit cube. A point that falls outside is drawn again; when it keeps falling outside it is
//! laid on the nearest face. The draws of a generation depend on the seed and the generation's number alone, so a saved
//! [`State`] goes on as if it had never stopped.
//!
//! Stands on: the contract, nalgebra. Never knows: another optimiser.

mod cloud;

pub use cloud::State;

use cloud::Constants;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::optimiser::{answers_fit, keep_better};
use crate::{Bounds, Evaluation, Finished, FitError, Needs, Optimiser, Search};

/// Its name.
pub const NAME: &str = "cma_es";

/// How CMA-ES walks.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// λ, points a generation; at least 4.
    pub population: usize,
    /// Standard deviation of the first cloud, as a part of the box's width.
    pub step: f64,
    /// It has converged when the cloud's longest half axis is shorter than this part of the box's width.
    pub step_tolerance: f64,
    /// At most so many generations.
    pub generations: usize,
    /// Where its draws come from.
    pub seed: u64,
}

impl Default for Settings {
    /// Ten points a generation, as in the paper.
    fn default() -> Self {
        Self { population: 10, step: 0.3, step_tolerance: 1e-6, generations: 100, seed: 1 }
    }
}

/// How often a point that fell outside of the box is drawn again.
const DRAWS: usize = 100;

/// CMA-ES on its way.
pub struct CmaEs {
    search: Search,
    set: Settings,
    state: State,
    asked: Vec<Vec<f64>>,
    finished: Option<Finished>,
}

impl CmaEs {
    /// CMA-ES at the start of a search.
    ///
    /// # Errors
    /// [`FitError::Setting`] when a setting leaves no cloud to draw.
    pub fn new(search: &Search, set: &Settings) -> Result<Self, FitError> {
        let n = search.dimension();
        let state = State {
            generation: 0,
            mean: to_cube(search.bounds(), search.start()),
            sigma: set.step,
            covariance: DMatrix::<f64>::identity(n, n).as_slice().to_vec(),
            sigma_path: vec![0.0; n],
            form_path: vec![0.0; n],
            best: None,
        };
        Self::resume(search, set, state)
    }

    /// CMA-ES where another one stood when its state was saved.
    ///
    /// # Errors
    /// [`FitError`] when a setting leaves no cloud to draw, or the state is of another search.
    pub fn resume(search: &Search, set: &Settings, state: State) -> Result<Self, FitError> {
        let refuse = |setting, value, needed| Err(FitError::Setting { optimiser: NAME, setting, value, needed });
        if set.population < 4 {
            return refuse("population", set.population as f64, "at least 4");
        }
        if !(set.step > 0.0 && set.step.is_finite()) {
            return refuse("step", set.step, "above 0");
        }
        if set.generations == 0 {
            return refuse("generations", 0.0, "at least 1");
        }
        let (found, expected) = (state.mean.len(), search.dimension());
        if found != expected || state.covariance.len() != expected * expected {
            return Err(FitError::Length { what: "the saved state", found, expected });
        }
        let mut cma = Self { search: search.clone(), set: set.clone(), state, asked: Vec::new(), finished: None };
        cma.draw();
        Ok(cma)
    }

    /// What must be kept to go on later.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The points of this generation.
    fn draw(&mut self) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.set.seed);
        rng.set_stream(self.state.generation);
        let (turn, lengths) = self.state.axes();
        let mean = DVector::from_column_slice(&self.state.mean);
        let mut point = || -> Vec<f64> {
            let y = &turn * DVector::from_fn(mean.len(), |i, _| lengths[i] * normal(&mut rng));
            (&mean + self.state.sigma * y).as_slice().to_vec()
        };
        let inside = |at: &Vec<f64>| at.iter().all(|v| (0.0..=1.0).contains(v));
        let kept = |_| {
            let mut at = point();
            for _ in 1..DRAWS {
                if inside(&at) {
                    break;
                }
                at = point();
            }
            at
        };
        let drawn: Vec<Vec<f64>> = (0..self.set.population).map(kept).collect();
        self.asked = drawn.iter().map(|at| from_cube(self.search.bounds(), at)).collect();
    }

    /// Moves the cloud towards the better half of what was told.
    fn learn(&mut self, told: &[Evaluation]) {
        let constants = Constants::new(self.state.mean.len(), self.set.population);
        let mut order: Vec<usize> = (0..told.len()).collect();
        order.sort_by(|&a, &b| told[a].loss.total_cmp(&told[b].loss));
        let old = DVector::from_column_slice(&self.state.mean);
        let way =
            |i: &usize| (DVector::from_vec(to_cube(self.search.bounds(), &told[*i].at)) - &old) / self.state.sigma;
        let ways: Vec<DVector<f64>> = order.iter().take(constants.weights.len()).map(way).collect();
        self.state.follow(&constants, &ways);
        self.state.generation += 1;
    }

    fn judge(&mut self) {
        let (_, lengths) = self.state.axes();
        let longest = self.state.sigma * lengths.max();
        if longest < self.set.step_tolerance {
            self.finished = Some(Finished::Converged { because: "the cloud has shrunk to a point" });
        } else if self.state.generation >= self.set.generations as u64 {
            self.finished = Some(Finished::Budget);
        }
    }
}

fn to_cube(bounds: &Bounds, at: &[f64]) -> Vec<f64> {
    (0..at.len()).map(|i| (at[i] - bounds.low[i]) / (bounds.high[i] - bounds.low[i])).collect()
}

fn from_cube(bounds: &Bounds, at: &[f64]) -> Vec<f64> {
    let wish: Vec<f64> = (0..at.len()).map(|i| bounds.low[i] + at[i] * (bounds.high[i] - bounds.low[i])).collect();
    bounds.clamp(&wish)
}

/// A draw of the standard normal distribution, by Box and Muller.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let mut open = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let (radius, angle) = ((-2.0 * open().ln()).sqrt(), std::f64::consts::TAU * open());
    radius * angle.cos()
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

    fn tell(&mut self, told: &[Evaluation]) -> Result<(), FitError> {
        answers_fit(NAME, &self.search, &self.asked, told)?;
        told.iter().for_each(|t| keep_better(&mut self.state.best, t));
        self.learn(told);
        self.judge();
        self.draw();
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

    fn search(n: usize) -> Search {
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Search::new(&names, vec![0.0; n], Bounds { low: vec![-2.0; n], high: vec![2.0; n] }).unwrap()
    }

    fn rosenbrock(at: &[f64]) -> f64 {
        at.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
    }

    fn answer(cma: &mut CmaEs, loss: fn(&[f64]) -> f64) -> f64 {
        let told: Vec<Evaluation> =
            cma.ask().into_iter().map(|at| (loss(&at), at)).map(|(l, at)| Evaluation::of_loss(at, l)).collect();
        cma.tell(&told).unwrap();
        cma.best().unwrap().loss
    }

    /// Evaluations until Rosenbrock's function falls below 1e-8: the median of five seeds.
    fn evaluations(n: usize) -> usize {
        let run = |seed: u64| {
            let set = Settings { step: 0.125, generations: 1000, step_tolerance: 0.0, seed, ..Settings::default() };
            let mut cma = CmaEs::new(&search(n), &set).unwrap();
            let mut count = 0;
            while count < 9000 {
                count += 10;
                if answer(&mut cma, rosenbrock) < 1e-8 {
                    break;
                }
            }
            count
        };
        let mut all: Vec<usize> = (1..=5).map(run).collect();
        all.sort_unstable();
        println!("{n} parameters: {all:?} evaluations");
        all[2]
    }

    /// The peer's 488 and 1254 evaluations are of its own population and start; a factor of two is a slip in a constant.
    #[test]
    fn rosenbrocks_valley_costs_as_many_evaluations_as_the_peer_needs() {
        let (two, four) = (evaluations(2), evaluations(4));
        assert!((244..976).contains(&two), "{two}");
        assert!((627..2508).contains(&four), "{four}");
    }

    #[test]
    fn a_saved_state_goes_on_bit_for_bit() {
        let set = Settings { seed: 7, ..Settings::default() };
        let mut whole = CmaEs::new(&search(3), &set).unwrap();
        for _ in 0..5 {
            answer(&mut whole, rosenbrock);
        }
        let mut rest = CmaEs::resume(&search(3), &set, whole.state().clone()).unwrap();
        for _ in 0..5 {
            assert_eq!(whole.ask(), rest.ask());
            assert_eq!(answer(&mut whole, rosenbrock), answer(&mut rest, rosenbrock));
        }
        assert_eq!(whole.state(), rest.state());
    }

    #[test]
    fn another_seed_draws_another_cloud() {
        let cloud = |seed| CmaEs::new(&search(2), &Settings { seed, ..Settings::default() }).unwrap().ask();
        assert_eq!(cloud(1), cloud(1));
        assert_ne!(cloud(1), cloud(2));
    }

    #[test]
    fn points_without_a_solution_rank_last() {
        let hole = |at: &[f64]| if at[0] < 0.0 { f64::INFINITY } else { (at[0] - 0.1).powi(2) + at[1].powi(2) };
        let mut cma = CmaEs::new(&search(2), &Settings::default()).unwrap();
        while cma.finished().is_none() {
            answer(&mut cma, hole);
        }
        assert!((cma.best().unwrap().at[0] - 0.1).abs() < 1e-5, "{:?}", cma.best());
    }

    #[test]
    fn a_population_of_three_is_refused() {
        assert!(CmaEs::new(&search(2), &Settings { population: 3, ..Settings::default() }).is_err());
    }
}
