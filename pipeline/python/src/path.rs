//! Paths of equilibria of a case: from rest to its last level, through limit points and bifurcations.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use simulate::{CriticalKind, DofMap, Exceeded, FollowedPath, PathEvent};

use crate::arrays::array;
use crate::case::refusal;
use crate::errors::{Kind, exception, refused};
use crate::solver::{OfCase, Solver};

/// A path as it is found.
#[derive(Default)]
struct Found {
    levels: Vec<f64>,
    /// Points × 3 entries per node, m.
    displacement: Vec<f64>,
    negative_eigenvalues: Vec<i64>,
    eigenvalues: Vec<f64>,
    iterations: Vec<i64>,
    /// Whether it is a limit point; level, displacement and mode.
    critical: Vec<(bool, f64, [Vec<f64>; 2])>,
}

impl Found {
    fn observe(&mut self, event: &PathEvent, dofs: &DofMap) {
        match event {
            PathEvent::Point(point) => {
                self.levels.push(point.load_factor);
                self.displacement.extend(dofs.full(&point.displacement));
                self.negative_eigenvalues.push(point.negative_eigenvalues as i64);
                self.eigenvalues.push(point.eigenvalue);
                self.iterations.push(point.iterations as i64);
            }
            PathEvent::Critical(point) => {
                let shapes = [dofs.full(&point.displacement), dofs.full(&point.mode)];
                self.critical.push((point.kind == CriticalKind::LimitPoint, point.load_factor, shapes));
            }
        }
    }

    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let made = PyDict::new(py);
        made.set_item("levels", array(py, self.levels))?;
        made.set_item("displacement", array(py, self.displacement))?;
        made.set_item("negative_eigenvalues", PyArray1::from_vec(py, self.negative_eigenvalues))?;
        made.set_item("eigenvalues", array(py, self.eigenvalues))?;
        made.set_item("iterations", PyArray1::from_vec(py, self.iterations))?;
        let critical = PyList::empty(py);
        for (limit, level, [displacement, mode]) in self.critical {
            critical.append((limit, level, array(py, displacement), array(py, mode)))?;
        }
        made.set_item("critical", critical)?;
        Ok(made)
    }
}

fn ended(limit: Exceeded, levels: &[f64]) -> PyErr {
    let reached = levels.last().copied().unwrap_or_default();
    let why = format!("{limit}; the last point lies at level {reached:.6}");
    exception(
        Kind::Budget,
        ["the path does not reach its last level", &why, "raise the limit, or end at a lower level"],
    )
}

#[pymethods]
impl Solver {
    /// The path of the case with these inputs: `levels`, `displacement` (points × 3 entries per node), `negative_eigenvalues`, `eigenvalues`,
    /// `iterations`, and `critical` points: whether it is a limit point, level, displacement, mode. `budget`: iterations of a point, seconds.
    fn path<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        budget: (Option<usize>, Option<f64>),
    ) -> PyResult<Bound<'py, PyDict>> {
        let (inputs, shared) = (self.inputs(inputs)?, self.shared.clone());
        let (max_iterations, timeout) = budget;
        let budget = simulate::Budget { max_iterations, timeout, max_cutbacks: None };
        let found = self.run_held(py, move |_, signals| {
            let none = || refused("the case follows no path", "it has no [static] with arc_length", "add arc_length");
            let OfCase { case, loads, .. } = shared.case.as_ref().ok_or_else(none)?;
            let statics = case.statics.as_ref().filter(|set| set.arc_length.is_some()).ok_or_else(none)?;
            let watch = budget.watch(Some(signals.interrupt()));
            let followed = FollowedPath { statics, loads, heavy: inputs.is_heavy(), watch: watch.clone() };
            let mut found = Found::default();
            let solver = || shared.another(&inputs);
            let outcome = followed.follow(&shared.system, &solver, &mut |event, dofs| found.observe(&event, dofs));
            match (outcome, watch.exceeded()) {
                (Ok(()), _) => Ok(found),
                (Err(_), Some(limit)) => Err(ended(limit, &found.levels)),
                (Err(diagnostic), None) => Err(refusal(&diagnostic)),
            }
        })?;
        found.into_dict(py)
    }
}
