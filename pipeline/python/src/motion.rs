//! Motions: recorded with all states, their gradients and sensitivities.

use std::sync::Arc;

use fem::{
    DynamicSettings, InitialValueProblem, LossGradient, MotionGradient, Parameter, Scheme, SolveError, State,
    StepControl,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use simulate::{Budget, Watch};

use crate::arrays::{Reals, check_length, number_vector, numpy_array, scale_of};
use crate::errors::{Kind, input_error, of_diagnostic, solve_exception};
use crate::interrupt::Signals;
use crate::memory;
use crate::solver::Solver;
use crate::statics::{by_region, scaled_array};

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
    #[pyo3(item)]
    max_iterations: Option<usize>,
    #[pyo3(item)]
    timeout: Option<f64>,
}

impl Settings {
    fn budget(&self) -> Budget {
        Budget { max_iterations: self.max_iterations, max_cutbacks: None, timeout: self.timeout }
    }

    pub(crate) fn dynamic_settings(&self) -> PyResult<DynamicSettings> {
        let scheme = match self.scheme.as_str() {
            "bdf2" => Scheme::Bdf2,
            "implicit_euler" => Scheme::ImplicitEuler,
            "quasi_static" => Scheme::QuasiStatic,
            other => {
                let schemes = "known are bdf2, implicit_euler and quasi_static";
                return Err(input_error(format!("there is no scheme `{other}`"), schemes, "name one of them"));
            }
        };
        let Self { step, mass_damping, stiffness_damping, tolerance, .. } = *self;
        Ok(DynamicSettings { step, scheme, mass_damping, stiffness_damping, tolerance })
    }
}

/// A recorded motion.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Trajectory {
    recorded: Arc<fem::Trajectory>,
}

/// States one after the other, and their times.
#[derive(Default)]
struct States {
    times: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    /// Steps that are planned; 0 where that is not known.
    planned: usize,
    progress: Option<Py<PyAny>>,
}

impl States {
    fn keep_state(&mut self, time: f64, state: &State, signals: &Signals) {
        if signals.is_raised() {
            return;
        }
        if let Err(refusal) = self.require_memory(state) {
            signals.end_with(refusal);
            return;
        }
        self.times.push(time);
        self.displacement.extend(&state.displacement);
        self.velocity.extend(&state.velocity);
        // An exception of the callback ends the solve.
        if let Some(progress) = &self.progress {
            let done = (self.times.len(), self.planned);
            Python::attach(|py| progress.call1(py, done).map(|_| ())).unwrap_or_else(|error| signals.end_with(error));
        }
    }

    /// Holds that the lists can take a further state: of adaptive steps the number is not known before.
    fn require_memory(&self, state: &State) -> PyResult<()> {
        let grows = self.displacement.len() + state.displacement.len() > self.displacement.capacity();
        if !grows || self.times.is_empty() {
            return Ok(());
        }
        // both lists double, beside those that they replace
        let bytes = 2.0 * 2.0 * 8.0 * self.displacement.capacity() as f64;
        memory::require_free(&format!("a motion of more than {} steps", self.times.len()), bytes)
    }

    /// The exception of a motion that ended here, which holds time and state.
    fn lost_motion(mut self, cause: SolveError, clock: &Watch) -> PyErr {
        let time = self.times.last().copied().unwrap_or_default();
        let error = of_diagnostic(&simulate::lost_step(cause, time, clock), Kind::Input);
        let full = self.displacement.len().checked_div(self.times.len()).unwrap_or_default();
        let last = self.displacement.split_off(self.displacement.len() - full);
        let attached = Python::attach(|py| -> PyResult<()> {
            error.value(py).setattr("time", time)?;
            error.value(py).setattr("_displacement", numpy_array(py, last))
        });
        attached.err().unwrap_or(error)
    }

    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let record = PyDict::new(py);
        record.set_item("times", numpy_array(py, self.times))?;
        record.set_item("displacement", numpy_array(py, self.displacement))?;
        record.set_item("velocity", numpy_array(py, self.velocity))?;
        Ok(record)
    }
}

/// The pressures of the step that ends at a time of `times`, which rise; `all` holds steps × chambers.
fn pressure_history<'a>(times: &'a [f64], chambers: usize, all: &'a [f64]) -> impl Fn(f64) -> Vec<f64> + 'a {
    move |time: f64| {
        let n = times.partition_point(|end| *end < time).min(times.len().saturating_sub(1));
        all.get(n * chambers..(n + 1) * chambers).unwrap_or_default().to_vec()
    }
}

fn initial_state((displacement, velocity): &(Reals<'_>, Reals<'_>)) -> PyResult<State> {
    let displacement = number_vector("initial displacement", displacement)?;
    Ok(State { displacement, velocity: number_vector("initial velocity", velocity)? })
}

/// Bytes of a motion's displacement and velocity, and of the states that its gradient may keep.
fn motion_bytes(steps: usize, nodes: usize, most: usize) -> f64 {
    let states = 2.0 * 3.0 * 8.0 * nodes as f64 * steps as f64;
    states + states.min(most as f64)
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
        let (initial, pressures, planned) = problem;
        let (settings, progress) = options;
        let (inputs, dynamic) = (self.inputs(inputs)?, settings.dynamic_settings()?);
        let [_, nodes, _, chambers] = self.shared.size_counts();
        let (initial, pressures) = (initial_state(&initial)?, number_vector("pressures", &pressures)?);
        check_length("pressures", pressures.len(), planned * chambers)?;
        memory::require_free(&format!("a motion of {planned} steps"), motion_bytes(planned, nodes, settings.memory))?;
        let (trajectory, states) = self.run(py, inputs, move |solver, signals| {
            let clock = settings.budget().watch(Some(signals.interrupt()));
            solver.set_interrupt(Some(clock.interrupt()));
            let times: Vec<f64> = (1..=planned).map(|n| n as f64 * dynamic.step).collect();
            let pressures_at = pressure_history(&times, chambers, &pressures);
            let problem = InitialValueProblem { settings: &dynamic, initial: &initial, pressures: &pressures_at };
            let mut states = States { planned, progress, ..States::default() };
            let mut keep = |time: f64, state: &State| {
                clock.restart();
                states.keep_state(time, state, signals);
            };
            match solver.record_observed(&problem, planned, settings.memory, &mut keep) {
                Ok(trajectory) => Ok((trajectory, states)),
                Err(cause) => Err(states.lost_motion(cause, &clock)),
            }
        })?;
        let recorded = states.into_dict(py)?;
        recorded.set_item("trajectory", Trajectory { recorded: Arc::new(trajectory) })?;
        Ok(recorded)
    }

    /// Integrates a motion with adaptive steps (duration, tolerance in m, shortest, longest) under the pressures of the case, or under those
    /// of `constant` (one per chamber; none: the case's): as [`Solver::record`], with `pressures` and without `trajectory`.
    fn integrate_adaptive<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        problem: ((Reals<'py>, Reals<'py>), Vec<Option<f64>>, [f64; 4]),
        options: (Settings, Option<Py<PyAny>>),
    ) -> PyResult<Bound<'py, PyDict>> {
        let (initial, constant, [duration, tolerance, shortest, longest]) = problem;
        let (settings, progress) = options;
        let (inputs, dynamic, initial) = (self.inputs(inputs)?, settings.dynamic_settings()?, initial_state(&initial)?);
        check_length("pressures", constant.len(), self.shared.size_counts()[3])?;
        let shared = self.shared.clone();
        let pressures_at = move |time: f64| -> Vec<f64> {
            let case = shared.case.as_ref().map(|of| of.loads.pressures_at(time)).unwrap_or_default();
            let given = |(n, constant): (usize, &Option<f64>)| constant.or(case.get(n).copied()).unwrap_or_default();
            constant.iter().enumerate().map(given).collect()
        };
        let (pressures, states) = self.run(py, inputs, move |solver, signals| {
            let clock = settings.budget().watch(Some(signals.interrupt()));
            solver.set_interrupt(Some(clock.interrupt()));
            let problem = InitialValueProblem { settings: &dynamic, initial: &initial, pressures: &pressures_at };
            let control = StepControl { tolerance, shortest, longest };
            let mut states = States { progress, ..States::default() };
            let mut keep = |time: f64, state: &State| {
                clock.restart();
                states.keep_state(time, state, signals);
            };
            match solver.integrate_adaptive(&problem, &control, duration, &mut keep) {
                Ok(_) => Ok((states.times.iter().flat_map(|&time| pressures_at(time)).collect::<Vec<f64>>(), states)),
                Err(cause) => Err(states.lost_motion(cause, &clock)),
            }
        })?;
        let record = states.into_dict(py)?;
        record.set_item("pressures", numpy_array(py, pressures))?;
        Ok(record)
    }

    /// The trajectory of a motion at given `times` (s, of each step's end), as its gradient needs it.
    fn record_at(
        &self,
        py: Python<'_>,
        inputs: &Bound<'_, PyDict>,
        problem: ((Reals<'_>, Reals<'_>), Reals<'_>, Vec<f64>),
        settings: Settings,
    ) -> PyResult<Trajectory> {
        let (initial, pressures, times) = problem;
        let (inputs, dynamic, initial) = (self.inputs(inputs)?, settings.dynamic_settings()?, initial_state(&initial)?);
        let (pressures, chambers) = (number_vector("pressures", &pressures)?, self.shared.size_counts()[3]);
        let trajectory = self.run(py, inputs, move |solver, _| {
            let pressures_at = pressure_history(&times, chambers, &pressures);
            let problem = InitialValueProblem { settings: &dynamic, initial: &initial, pressures: &pressures_at };
            let from_rest = std::iter::once(0.0).chain(times.iter().copied()).collect();
            solver.record_at(&problem, from_rest, settings.memory).map_err(solve_exception)
        })?;
        Ok(Trajectory { recorded: Arc::new(trajectory) })
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
        let (mut by_u, mut by_v) =
            (number_vector("dloss_du", &by_displacement)?, number_vector("dloss_dv", &by_velocity)?);
        let scale = scale_of(by_u.iter().chain(&by_v));
        by_u.iter_mut().chain(&mut by_v).for_each(|entry| *entry /= scale);
        let full = 3 * self.shared.size_counts()[1];
        let recorded = trajectory.recorded.clone();
        let gradient = self.run(py, inputs, move |solver, _| {
            check_length("dloss_du", by_u.len(), full * recorded.steps())?;
            let part = |all: &[f64], n: usize| all.get(full * (n - 1)..full * n).unwrap_or_default().to_vec();
            let mut loss = |n: usize, _: &State| match n {
                0 => LossGradient::default(),
                _ => LossGradient { displacement: part(&by_u, n), velocity: part(&by_v, n) },
            };
            solver.trajectory_adjoint(&recorded, &mut loss).map_err(solve_exception)
        })?;
        of_motion(py, gradient, scale)
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
        let mut parts_of_direction: Vec<(Parameter, f64)> = Vec::new();
        let kinds = [Parameter::YoungsModulus, Parameter::PoissonsRatio, Parameter::Density, Parameter::PressureGain];
        for (parts, parameter) in [moduli, ratios, densities, gains].iter().zip(kinds) {
            parts_of_direction.extend(
                parts.iter().enumerate().filter(|(_, part)| **part != 0.0).map(|(at, part)| (parameter(at), *part)),
            );
        }
        let full = 3 * self.shared.size_counts()[1];
        let recorded = trajectory.recorded.clone();
        let changed = self.run(py, inputs, move |solver, _| {
            let mut sums_of_steps = vec![0.0; full * recorded.steps()];
            let parameters: Vec<Parameter> = parts_of_direction.iter().map(|(parameter, _)| *parameter).collect();
            let mut observe = |n: usize, states: &[&State]| {
                for (state, (_, part)) in states.iter().zip(&parts_of_direction).filter(|_| n > 0) {
                    let sums = sums_of_steps[full * (n - 1)..full * n].iter_mut();
                    sums.zip(&state.displacement).for_each(|(sum, u)| *sum += part * u);
                }
            };
            solver.trajectory_sensitivity(&recorded, &parameters, &mut observe).map_err(solve_exception)?;
            Ok(sums_of_steps)
        })?;
        Ok(numpy_array(py, changed))
    }
}

/// So many times a gradient.
fn of_motion<'py>(py: Python<'py>, gradient: MotionGradient, scale: f64) -> PyResult<Bound<'py, PyDict>> {
    let record = PyDict::new(py);
    by_region(&record, &gradient.regions, scale)?;
    record.set_item("factors", scaled_array(py, gradient.elements, scale))?;
    record.set_item("pressures", scaled_array(py, gradient.pressures.into_iter().flatten().collect(), scale))?;
    record.set_item("forces", scaled_array(py, gradient.forces, scale))?;
    record.set_item("mass_damping", scale * gradient.mass_damping)?;
    record.set_item("stiffness_damping", scale * gradient.stiffness_damping)?;
    record.set_item("initial_displacement", scaled_array(py, gradient.initial.displacement, scale))?;
    record.set_item("initial_velocity", scaled_array(py, gradient.initial.velocity, scale))?;
    Ok(record)
}
