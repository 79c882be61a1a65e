//! Runs an optimiser over a problem and keeps every evaluation in order.
//!
//! Stands on: [`Optimiser`]. Never knows: which optimiser it runs, or which problem.

use crate::{Evaluation, Finished, FitError, Needs, Optimiser};

/// One evaluation and the iteration it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// Iterations are counted from 0; one iteration is one batch that was asked for.
    pub iteration: usize,
    /// What was found there.
    pub evaluation: Evaluation,
}

/// A whole search: every evaluation, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// The evaluations.
    pub tried: Vec<Tried>,
    /// Why the search ended.
    pub finished: Finished,
    /// The best point, in the measure that the optimiser minimises.
    pub best: Evaluation,
}

impl History {
    /// How many batches were asked for.
    pub fn iterations(&self) -> usize {
        self.tried.last().map_or(0, |t| t.iteration + 1)
    }

    /// The lowest loss among the first `evaluations`.
    pub fn loss_after_evaluations(&self, evaluations: usize) -> f64 {
        self.tried.iter().take(evaluations).map(|t| t.evaluation.loss).fold(f64::INFINITY, f64::min)
    }

    /// The lowest loss among the first `iterations`.
    pub fn loss_after_iterations(&self, iterations: usize) -> f64 {
        let so_far = self.tried.iter().take_while(|t| t.iteration < iterations);
        so_far.map(|t| t.evaluation.loss).fold(f64::INFINITY, f64::min)
    }

    /// The lowest loss so far, one number an evaluation: a curve of convergence.
    pub fn lowest_so_far(&self) -> Vec<f64> {
        let losses = self.tried.iter().map(|t| t.evaluation.loss);
        losses.scan(f64::INFINITY, |low, loss| Some(std::mem::replace(low, low.min(loss)).min(loss))).collect()
    }
}

/// A problem: given a batch of points and what is needed at each, it answers in the same order.
///
/// It may work on the batch in parallel. `E` is its own way to fail.
pub type Problem<'a, E> = dyn FnMut(&[Vec<f64>], Needs) -> Result<Vec<Evaluation>, E> + 'a;

/// Runs an optimiser on a problem until it has finished.
///
/// # Errors
/// Whatever `problem` returns, or a [`FitError`] about its answers.
pub fn minimise<E: From<FitError>>(optimiser: &mut dyn Optimiser, problem: &mut Problem<E>) -> Result<History, E> {
    let mut tried = Vec::new();
    let mut iteration = 0;
    let finished = loop {
        if let Some(finished) = optimiser.finished() {
            break finished;
        }
        let told = problem(&optimiser.ask(), optimiser.needs())?;
        optimiser.tell(&told)?;
        tried.extend(told.into_iter().map(|evaluation| Tried { iteration, evaluation }));
        iteration += 1;
    };
    match optimiser.best().cloned() {
        Some(best) => Ok(History { tried, finished, best }),
        None => Err(FitError::Length { what: "the history", found: 0, expected: 1 }.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(losses: &[(usize, f64)]) -> History {
        let tried = losses
            .iter()
            .map(|&(iteration, loss)| Tried { iteration, evaluation: Evaluation::of_loss(vec![0.0], loss) });
        let best = Evaluation::of_loss(vec![0.0], 0.0);
        History { tried: tried.collect(), finished: Finished::Budget, best }
    }

    #[test]
    fn the_lowest_loss_so_far_never_rises() {
        let history = history(&[(0, 3.0), (0, 5.0), (1, 2.0), (2, 4.0)]);
        assert_eq!(history.lowest_so_far(), vec![3.0, 3.0, 2.0, 2.0]);
    }

    #[test]
    fn a_batch_is_one_iteration() {
        let history = history(&[(0, 3.0), (0, 1.0), (1, 2.0)]);
        assert_eq!(history.iterations(), 2);
        assert_eq!((history.loss_after_iterations(1), history.loss_after_evaluations(1)), (1.0, 3.0));
    }
}
