//! CMA-ES on Rosenbrock's valley: the optimiser asks for points and receives their losses, so that they may be simulated anywhere and in any order.

use optimize::optimisers::cma_es::{CmaEs, Settings};
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, minimise};

fn rosenbrock(at: &[f64]) -> f64 {
    100.0 * (at[1] - at[0].powi(2)).powi(2) + (1.0 - at[0]).powi(2)
}

/// # Errors
/// When the optimiser refuses its problem.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bounds = Bounds { low: vec![-2.0; 2], high: vec![2.0; 2] };
    let problem = Problem::new(&["x", "y"], vec![-1.5, 1.5], bounds)?;
    let mut optimiser = CmaEs::new(&problem, &Settings { generations: 300, ..Settings::default() })?;
    let mut objective = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, OptimiseError> {
        Ok(batch.iter().map(|at| Evaluation::of_loss(at.clone(), rosenbrock(at))).collect())
    };
    let log = minimise(&mut optimiser, &mut objective)?;
    let best = &log.best;
    println!("{} evaluations, best {:.2e} at {:.6?}", log.entries.len(), best.loss, best.at);
    assert!(best.at.iter().all(|x| (x - 1.0).abs() < 1e-3), "{best:?}");
    Ok(())
}
