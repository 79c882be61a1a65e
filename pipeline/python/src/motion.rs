//! Motions: recorded with all states, their gradients and sensitivities.

use std::sync::Mutex;

use fem::{DynamicSettings, InitialValueProblem, LossGradient, MotionGradient, Parameter, Scheme, State};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Reals, array, check_length, slice, vector};
use crate::errors::{raised, refused};
use crate::interrupt::Signals;
use crate::solver::Solver;
use crate::statics::by_region;

/// Settings of an integration in time.
#[derive(FromPyObject)]
pub(crate) struct Settings {
    #[pyo3(item)]
    step: f64,
    #[pyo3(item)]
    scheme: String,
    #[pyo3(item)]
    mass_damping: f64,
    #[pyo3(item)]
    stiffness_damping: f64,
    #[pyo3(item)]
    tolerance: f64,
    /// Bytes that recorded states may take.
    #[pyo3(item)]
    memory: usize,
}

impl Settings {
    pub(crate) fn dynamic(&self) -> PyResult<DynamicSettings> {
        let scheme = match self.scheme.as_str() {
            "bdf2" => Scheme::Bdf2,
            "implicit_euler" => Scheme::ImplicitEuler,
            "quasi_static" => Scheme::QuasiStatic,
            other => {
                let why = "known are bdf2, implicit_euler and quasi_static";
                return Err(refused(format!("there is no scheme `{other}`"), why, "name one of them"));
            }
        };
        let Self { step, mass_damping, stiffness_damping, tolerance, .. } = *self;
        Ok(DynamicSettings { step, scheme, mass_damping, stiffness_damping, tolerance })
    }
}

/// A recorded motion.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Trajectory {
    made: Mutex<fem::Trajectory>,
}

/// States one after the other, and their times.
#[derive(Default)]
struct States {
    times: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

/// The pressures of step n at n − 1, found again by their time.
fn history(step: f64, chambers: usize, all: &[f64]) -> impl Fn(f64) -> Vec<f64> + '_ {
    let steps = all.len().checked_div(chambers).unwrap_or(0);
    move |time: f64| {
        let n = ((time / step).round() as usize).clamp(1, steps.max(1)) - 1;
        all.get(n * chambers..(n + 1) * chambers).unwrap_or_default().to_vec()
    }
}

/// Calls a progress callback, whose exception ends the solve.
fn report(progress: Option<&Py<PyAny>>, signals: &Signals, n: usize, steps: usize) {
    if let Some(progress) = progress {
        Python::attach(|py| progress.call1(py, (n, steps)).map(|_| ())).unwrap_or_else(|error| signals.raise(error));
    }
}

#[pymethods]
impl Solver {
    /// Integrates a motion from `initial` (displacement, velocity) under `pressures` (steps × chambers) and records it:
    /// `times`, `displacement`, `velocity` (steps × 3 entries per node) and `trajectory`.
    fn record<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        problem: ((Reals<'py>, Reals<'py>), Reals<'py>, usize),
        options: (Settings, Option<Py<PyAny>>),
    ) -> PyResult<Bound<'py, PyDict>> {
        let (initial, pressures, steps) = problem;
        let (settings, progress) = options;
        let (inputs, dynamic) = (self.inputs(inputs)?, settings.dynamic()?);
        let [_, nodes, _, chambers] = self.counts();
        check_length("pressures", slice("pressures", &pressures)?.len(), steps * chambers)?;
        let pressures = vector("pressures", &pressures)?;
        let (displacement, velocity) =
            (vector("initial displacement", &initial.0)?, vector("initial velocity", &initial.1)?);
        let initial = State { displacement, velocity };
        let memory = settings.memory;
        let (trajectory, states) = self.run(py, inputs, |solver, signals| {
            let at = history(dynamic.step, chambers, &pressures);
            let problem = InitialValueProblem { settings: &dynamic, initial: &initial, pressures: &at };
            let mut states = States::default();
            let mut keep = |time: f64, state: &State| {
                states.times.push(time);
                states.displacement.extend(&state.displacement);
                states.velocity.extend(&state.velocity);
                report(progress.as_ref(), signals, states.times.len(), steps);
            };
            let trajectory = solver.record_observed(&problem, steps, memory, &mut keep).map_err(raised)?;
            Ok((trajectory, states))
        })?;
        debug_assert_eq!(states.displacement.len(), 3 * nodes * steps);
        let made = PyDict::new(py);
        made.set_item("times", array(py, states.times))?;
        made.set_item("displacement", array(py, states.displacement))?;
        made.set_item("velocity", array(py, states.velocity))?;
        made.set_item("trajectory", Trajectory { made: Mutex::new(trajectory) })?;
        Ok(made)
    }

    /// The gradient of a loss of a recorded motion from its derivatives by displacement and velocity after each step
    /// (steps × 3 entries per node; the latter may be empty).
    fn trajectory_gradient<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        trajectory: &Trajectory,
        slopes: (Reals<'py>, Reals<'py>),
    ) -> PyResult<Bound<'py, PyDict>> {
        let (by_displacement, by_velocity) = slopes;
        let inputs = self.inputs(inputs)?;
        let (by_u, by_v) = (vector("dloss_du", &by_displacement)?, vector("dloss_dv", &by_velocity)?);
        let full = 3 * self.counts()[1];
        let gradient = self.run(py, inputs, |solver, _| {
            let made = trajectory
                .made
                .lock()
                .map_err(|_| refused("the motion is lost", "a solve on it failed", "record it again"))?;
            check_length("dloss_du", by_u.len(), full * made.steps())?;
            let part = |all: &[f64], n: usize| all.get(full * (n - 1)..full * n).unwrap_or_default().to_vec();
            let mut loss = |n: usize, _: &State| match n {
                0 => LossGradient::default(),
                _ => LossGradient { displacement: part(&by_u, n), velocity: part(&by_v, n) },
            };
            solver.trajectory_adjoint(&made, &mut loss).map_err(raised)
        })?;
        of_motion(py, gradient)
    }

    /// The derivative of the displacement after each step along a direction of E, ν and ρ of the regions and of gains of
    /// the pressures: steps × 3 entries per node.
    fn trajectory_sensitivity<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        trajectory: &Trajectory,
        direction: (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>),
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let inputs = self.inputs(inputs)?;
        let (moduli, ratios, densities, gains) = direction;
        let mut along: Vec<(Parameter, f64)> = Vec::new();
        let kinds = [Parameter::YoungsModulus, Parameter::PoissonsRatio, Parameter::Density, Parameter::PressureGain];
        for (parts, parameter) in [moduli, ratios, densities, gains].iter().zip(kinds) {
            along.extend(
                parts.iter().enumerate().filter(|(_, part)| **part != 0.0).map(|(at, part)| (parameter(at), *part)),
            );
        }
        let full = 3 * self.counts()[1];
        let changed = self.run(py, inputs, |solver, _| {
            let made = trajectory
                .made
                .lock()
                .map_err(|_| refused("the motion is lost", "a solve on it failed", "record it again"))?;
            let mut all = vec![0.0; full * made.steps()];
            let parameters: Vec<Parameter> = along.iter().map(|(parameter, _)| *parameter).collect();
            let mut observe = |n: usize, states: &[&State]| {
                for (state, (_, part)) in states.iter().zip(&along).filter(|_| n > 0) {
                    let sums = all[full * (n - 1)..full * n].iter_mut();
                    sums.zip(&state.displacement).for_each(|(sum, u)| *sum += part * u);
                }
            };
            solver.trajectory_sensitivity(&made, &parameters, &mut observe).map_err(raised)?;
            Ok(all)
        })?;
        Ok(array(py, changed))
    }
}

impl Solver {
    /// Numbers of degrees of freedom, nodes, elements and chambers.
    pub(crate) fn counts(&self) -> [usize; 4] {
        let mesh = self.system.mesh();
        [self.system.dofs(), mesh.nodes.len(), mesh.elements.len(), mesh.chambers.len()]
    }
}

fn of_motion<'py>(py: Python<'py>, gradient: MotionGradient) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(py);
    by_region(&made, &gradient.regions)?;
    made.set_item("factors", array(py, gradient.elements))?;
    made.set_item("pressures", array(py, gradient.pressures.into_iter().flatten().collect()))?;
    made.set_item("forces", array(py, gradient.forces))?;
    made.set_item("mass_damping", gradient.mass_damping)?;
    made.set_item("stiffness_damping", gradient.stiffness_damping)?;
    made.set_item("initial_displacement", array(py, gradient.initial.displacement))?;
    made.set_item("initial_velocity", array(py, gradient.initial.velocity))?;
    Ok(made)
}
