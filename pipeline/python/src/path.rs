//! Paths of equilibria of a case: from rest to its last level, through limit points and bifurcations.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use simulate::{CriticalKind, DofMap, Exceeded, FollowedPath, PathEvent};

use crate::arrays::numpy_array;
use crate::case::case_exception;
use crate::errors::{Kind, input_error, typed_exception};
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
        let record = PyDict::new(py);
        record.set_item("levels", numpy_array(py, self.levels))?;
        record.set_item("displacement", numpy_array(py, self.displacement))?;
        record.set_item("negative_eigenvalues", PyArray1::from_vec(py, self.negative_eigenvalues))?;
        record.set_item("eigenvalues", numpy_array(py, self.eigenvalues))?;
        record.set_item("iterations", PyArray1::from_vec(py, self.iterations))?;
        let critical = PyList::empty(py);
        for (limit, level, [displacement, mode]) in self.critical {
            critical.append((limit, level, numpy_array(py, displacement), numpy_array(py, mode)))?;
        }
        record.set_item("critical", critical)?;
        Ok(record)
    }
}

fn exceeded_exception(limit: Exceeded, levels: &[f64]) -> PyErr {
    let reached = levels.last().copied().unwrap_or_default();
    let reason = format!("{limit}; the last point lies at level {reached:.6}");
    typed_exception(
        Kind::Budget,
        ["the path does not reach its last level", &reason, "raise the limit, or end at a lower level"],
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
        let followed_points = self.run_held(py, move |_, signals| {
            let none =
                || input_error("the case follows no path", "it has no [static] with arc_length", "add arc_length");
            let OfCase { case, loads, .. } = shared.case.as_ref().ok_or_else(none)?;
            let statics = case.statics.as_ref().filter(|set| set.arc_length.is_some()).ok_or_else(none)?;
            let watch = budget.watch(Some(signals.interrupt()));
            let followed = FollowedPath { statics, loads, heavy: inputs.is_heavy(), watch: watch.clone() };
            let mut followed_points = Found::default();
            let solver = || shared.further_solver(&inputs);
            let outcome =
                followed.follow(&shared.system, &solver, &mut |event, dofs| followed_points.observe(&event, dofs));
            match (outcome, watch.exceeded()) {
                (Ok(()), _) => Ok(followed_points),
                (Err(_), Some(limit)) => Err(exceeded_exception(limit, &followed_points.levels)),
                (Err(diagnostic), None) => Err(case_exception(&diagnostic)),
            }
        })?;
        followed_points.into_dict(py)
    }
}
