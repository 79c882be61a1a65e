//! Grid search: every node of a regular grid within the bounds, as one batch.
//!
//! It needs no derivative and finds the global minimum to half a spacing; its evaluations are the loss landscape. Paper, section IV,
//! exhaustive search.

use crate::optimiser::{check_evaluations, keep_better};
use crate::{Bounds, Evaluation, Finished, Needs, OptimiseError, Optimiser, Problem};

/// Its name.
pub const NAME: &str = "grid";

/// Settings of grid search.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Nodes on each axis, both ends included; at least 2.
    pub points_per_axis: usize,
}

impl Default for Settings {
    /// Five nodes an axis: the paper's 25 evaluations for two parameters.
    fn default() -> Self {
        Self { points_per_axis: 5 }
    }
}

/// A grid search.
pub struct Grid {
    problem: Problem,
    nodes: Vec<Vec<f64>>,
    best: Option<Evaluation>,
    finished: Option<Finished>,
}

impl Grid {
    /// A grid over the bounds of a problem; its initial guess is not used.
    ///
    /// # Errors
    /// [`OptimiseError::Setting`] with fewer than two nodes an axis.
    pub fn new(problem: &Problem, set: &Settings) -> Result<Self, OptimiseError> {
        if set.points_per_axis < 2 {
            let (setting, value) = ("points_per_axis", set.points_per_axis as f64);
            return Err(OptimiseError::Setting { optimiser: NAME, setting, value, needed: "at least 2" });
        }
        let nodes = grid_nodes(problem.bounds(), set.points_per_axis);
        Ok(Self { problem: problem.clone(), nodes, best: None, finished: None })
    }
}

/// The values on one axis of a grid, both ends included.
pub fn axis_values(low: f64, high: f64, points: usize) -> Vec<f64> {
    let fraction = |i: usize| i as f64 / (points - 1) as f64;
    (0..points).map(|i| low * (1.0 - fraction(i)) + high * fraction(i)).collect()
}

/// All nodes of a grid (points^parameters × parameters); the last parameter varies fastest.
pub(crate) fn grid_nodes(bounds: &Bounds, points_per_axis: usize) -> Vec<Vec<f64>> {
    let mut nodes = vec![Vec::new()];
    for (low, high) in bounds.low.iter().zip(&bounds.high) {
        let values = axis_values(*low, *high, points_per_axis);
        let extended = |node: &Vec<f64>| values.iter().map(|v| [&node[..], &[*v]].concat()).collect::<Vec<_>>();
        nodes = nodes.iter().flat_map(extended).collect();
    }
    nodes
}

impl Optimiser for Grid {
    fn name(&self) -> &'static str {
        NAME
    }

    fn needs(&self) -> Needs {
        Needs::Loss
    }

    fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.finished.is_some() { Vec::new() } else { self.nodes.clone() }
    }

    fn tell(&mut self, evaluations: &[Evaluation]) -> Result<(), OptimiseError> {
        check_evaluations(NAME, &self.problem, &self.nodes, evaluations)?;
        evaluations.iter().for_each(|t| keep_better(&mut self.best, t));
        self.finished = Some(Finished::Converged { because: "every node of the grid is evaluated" });
        Ok(())
    }

    fn finished(&self) -> Option<Finished> {
        self.finished
    }

    fn best(&self) -> Option<&Evaluation> {
        self.best.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_holds_every_pair_once_with_the_last_axis_fastest() {
        let bounds = Bounds { low: vec![0.0, 10.0], high: vec![1.0, 14.0] };
        let nodes = grid_nodes(&bounds, 3);
        assert_eq!(nodes.len(), 9);
        assert_eq!(nodes[..4], [vec![0.0, 10.0], vec![0.0, 12.0], vec![0.0, 14.0], vec![0.5, 10.0]]);
    }

    #[test]
    fn the_ends_of_an_axis_are_exact() {
        let axis = axis_values(-0.1, 0.7, 11);
        assert_eq!((axis[0], axis[10]), (-0.1, 0.7));
    }
}
