//! Runs an optimiser on an objective until it has finished and logs every evaluation.

use crate::{Evaluation, Finished, Needs, OptimiseError, Optimiser};

/// One evaluation and the iteration it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct LogEntry {
    /// Iterations are counted from 0; one iteration is one batch that was asked for.
    pub iteration: usize,
    /// What was evaluated.
    pub evaluation: Evaluation,
}

/// All evaluations of one run, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationLog {
    /// The evaluations.
    pub entries: Vec<LogEntry>,
    /// Why the run ended.
    pub finished: Finished,
    /// The best point, in the measure that the optimiser minimises.
    pub best: Evaluation,
}

impl EvaluationLog {
    /// How many batches were asked for.
    pub fn iteration_count(&self) -> usize {
        self.entries.last().map_or(0, |t| t.iteration + 1)
    }
}

/// An objective: evaluates a batch of points, with what the optimiser needs at each, and returns the evaluations in the same order.
///
/// It may evaluate the batch in parallel. `E` is its own error type.
pub type Objective<'a, E> = dyn FnMut(&[Vec<f64>], Needs) -> Result<Vec<Evaluation>, E> + 'a;

/// Runs an optimiser on an objective until it has finished.
///
/// # Errors
/// The error of `objective`, or an [`OptimiseError`] about its evaluations.
pub fn minimise<E: From<OptimiseError>>(
    optimiser: &mut dyn Optimiser,
    objective: &mut Objective<E>,
) -> Result<EvaluationLog, E> {
    let mut entries = Vec::new();
    let mut iteration = 0;
    let finished = loop {
        if let Some(finished) = optimiser.finished() {
            break finished;
        }
        let evaluations = objective(&optimiser.ask(), optimiser.needs())?;
        optimiser.tell(&evaluations)?;
        entries.extend(evaluations.into_iter().map(|evaluation| LogEntry { iteration, evaluation }));
        iteration += 1;
    };
    match optimiser.best().cloned() {
        Some(best) => Ok(EvaluationLog { entries, finished, best }),
        None => Err(OptimiseError::Length { what: "the evaluation log", found: 0, expected: 1 }.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(losses: &[(usize, f64)]) -> EvaluationLog {
        let entries = losses
            .iter()
            .map(|&(iteration, loss)| LogEntry { iteration, evaluation: Evaluation::of_loss(vec![0.0], loss) });
        let best = Evaluation::of_loss(vec![0.0], 0.0);
        EvaluationLog { entries: entries.collect(), finished: Finished::Budget, best }
    }

    #[test]
    fn a_batch_is_one_iteration() {
        let history = history(&[(0, 3.0), (0, 1.0), (1, 2.0)]);
        assert_eq!(history.iteration_count(), 2);
    }
}
