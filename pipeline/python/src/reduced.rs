//! Reduced models: made of snapshots, restored from their data, stepped, and differentiated step by step.

use std::sync::Arc;

use fem::{
    DynamicSettings, Parameter, ReducedEquilibrium, ReducedModelData, ReducedSolver, ReducedState, ReducedStep,
    ReductionSettings, RegionProperties, StaticSettings,
};
use nalgebra::DVector;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use simulate::{NamedRange, TrainingBox, train_reduced};

use crate::arrays::{Reals, number_slice, number_vector, numpy_array};
use crate::errors::{Kind, input_error, of_diagnostic, solve_exception};
use crate::interrupt::{run_guarded, run_watched};
use crate::memory;
use crate::motion::Settings;
use crate::solver::{Shared, Solver};
use crate::threads::in_this_process;

/// A body in a few dozen coordinates.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct ReducedModel {
    model: Arc<fem::ReducedModel>,
    /// Of the system that was reduced.
    regions: Vec<RegionProperties>,
}

impl ReducedModel {
    fn new(model: fem::ReducedModel, system: &fem::System) -> Self {
        Self { model: Arc::new(model), regions: system.regions().to_vec() }
    }

    /// The equilibrium under pressures of a body with E and ν of each region, near `start`, with its solver.
    fn equilibrium_near(
        &self,
        start: Vec<f64>,
        (pressures, constants): &Constants,
    ) -> PyResult<(ReducedSolver, ReducedEquilibrium)> {
        let mut solver = ReducedSolver::new(Arc::clone(&self.model), self.regions.clone());
        for (region, (youngs_modulus, poissons_ratio)) in constants.iter().enumerate() {
            solver.set_elastic(region, *youngs_modulus, *poissons_ratio).map_err(solve_exception)?;
        }
        let start: DVector<f64> = start.into();
        let equilibrium = solver.equilibrium_near(pressures, &start, &start).map_err(solve_exception)?;
        Ok((solver, equilibrium))
    }
}

/// `E` or `nu` of a region, by its number, with its name and range.
type NamedConstant = (String, usize, (String, f64, f64));
/// Pressures, Pa, by chamber; E, Pa, and ν by region.
type Constants = (Vec<f64>, Vec<(f64, f64)>);

/// What a step depends on beside the state.
struct Given {
    settings: DynamicSettings,
    pressures: Vec<f64>,
    modulus_scale: Vec<f64>,
}

impl Given {
    fn of((settings, pressures, modulus_scale): (Settings, Vec<f64>, Vec<f64>)) -> PyResult<Self> {
        Ok(Self { settings: settings.dynamic_settings()?, pressures, modulus_scale })
    }

    fn step(&self) -> ReducedStep<'_> {
        ReducedStep { settings: &self.settings, pressures: &self.pressures, modulus_scale: &self.modulus_scale }
    }
}

/// Coordinates and velocity, given and returned.
type Pair<'py> = (Reals<'py>, Reals<'py>);
type Arrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

fn reduced_state((coordinates, velocity): &Pair<'_>) -> PyResult<ReducedState> {
    let (coordinates, velocity) = (number_vector("coordinates", coordinates)?, number_vector("velocity", velocity)?);
    Ok(ReducedState { coordinates: coordinates.into(), velocity: velocity.into() })
}

fn state_arrays<'py>(py: Python<'py>, state: ReducedState) -> Arrays<'py> {
    (numpy_array(py, state.coordinates.data.into()), numpy_array(py, state.velocity.data.into()))
}

/// Bytes of the training matrix: the work of each quadrature point of a region along each mode, at each snapshot and perturbation, single.
fn training_bytes(shared: &Shared, snapshots: usize, coordinates: usize) -> f64 {
    let mesh = shared.system.mesh();
    let modes = snapshots.min(coordinates) as f64;
    let points = mesh.elements.len() as f64 * if mesh.elements.nodes_each() == 4 { 1.0 } else { 8.0 };
    // gradients of the modes as well, double
    points * (4.0 * modes * (snapshots as f64 + modes) + 72.0 * modes)
}

#[pymethods]
impl Solver {
    /// Reduces the body to at most `coordinates` modes of `snapshots` (3 entries per node each, one after the other);
    /// the cubature's relative error is below `tolerance`.
    fn reduce(
        &self,
        py: Python<'_>,
        snapshots: Reals<'_>,
        coordinates: usize,
        tolerance: f64,
    ) -> PyResult<ReducedModel> {
        let displacements = number_vector("snapshots", &snapshots)?;
        let settings = ReductionSettings { coordinates, tolerance, ..ReductionSettings::default() };
        let (shared, full) = (self.shared.clone(), 3 * self.shared.size_counts()[1]);
        memory::require_free("the reduction", training_bytes(&shared, displacements.len() / full, coordinates))?;
        run_watched(py, move |_| {
            // length: Python hands over whole snapshots
            let each: Vec<&[f64]> = displacements.chunks_exact(full).collect();
            Ok(ReducedModel::new(shared.system.reduce(&each, &settings).map_err(solve_exception)?, &shared.system))
        })
    }

    /// Trains a reduced model over ranges (low, high) of E or ν by region, and of every chamber's pressure, Pa; returns it with the number of equilibria
    /// that taught it and the largest difference of a node at points that were checked, over the largest displacement.
    fn train(
        &self,
        py: Python<'_>,
        ranges: (Vec<NamedConstant>, Vec<(String, f64, f64)>),
        limits: (f64, usize, f64),
    ) -> PyResult<(ReducedModel, usize, f64)> {
        let (shared, (constants, pressures), (tolerance, most, statics)) = (self.shared.clone(), ranges, limits);
        let range = |(name, low, high)| NamedRange { name, low, high };
        let constant = |(kind, region, named): NamedConstant| {
            let parameter =
                if kind == "E" { Parameter::YoungsModulus(region) } else { Parameter::PoissonsRatio(region) };
            (parameter, range(named))
        };
        let space = TrainingBox {
            constants: constants.into_iter().map(constant).collect(),
            pressures: pressures.into_iter().map(range).collect(),
            tolerance,
            most,
        };
        run_watched(py, move |_| {
            let settings = StaticSettings { tolerance: statics, ..StaticSettings::default() };
            let trained = train_reduced(&shared.system, &space, settings, &|_| ());
            let trained = trained.map_err(|e| of_diagnostic(&e, Kind::Convergence))?;
            let model = ReducedModel { model: trained.model, regions: shared.system.regions().to_vec() };
            Ok((model, trained.taught, trained.checked.1))
        })
    }

    /// The reduced model with the data that `ReducedModel.data` returned.
    fn restore(
        &self,
        py: Python<'_>,
        modes: Reals<'_>,
        points: Vec<(Vec<u32>, Vec<f64>)>,
        size: f64,
    ) -> PyResult<ReducedModel> {
        let rows = 3 * self.shared.size_counts()[1];
        let modes = number_slice("modes", &modes)?.chunks_exact(rows).map(<[f64]>::to_vec).collect();
        let points = points.into_iter().map(|(numbers, weights)| numbers.into_iter().zip(weights).collect()).collect();
        let data = ReducedModelData { modes, points, size };
        let shared = self.shared.clone();
        run_watched(py, move |_| {
            Ok(ReducedModel::new(shared.system.restore(&data).map_err(solve_exception)?, &shared.system))
        })
    }
}

#[pymethods]
impl ReducedModel {
    /// Number of coordinates.
    fn coordinates(&self) -> usize {
        self.model.coordinates()
    }

    /// Modes (one after the other, 3 entries per node), sampled points and weights by region, and size.
    fn data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let ReducedModelData { modes, points, size } = self.model.data();
        let record = PyDict::new(py);
        record.set_item("modes", numpy_array(py, modes.into_iter().flatten().collect()))?;
        let lists = points.into_iter().map(|region| region.into_iter().unzip::<u32, f64, Vec<_>, Vec<_>>());
        record.set_item("points", lists.collect::<Vec<_>>())?;
        record.set_item("size", size)?;
        Ok(record)
    }

    /// Displacement V q, 3 entries per node, m.
    fn displacement<'py>(&self, py: Python<'py>, coordinates: Reals<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let q = number_vector("coordinates", &coordinates)?;
        if q.len() != self.model.coordinates() {
            let reason = format!("this model has {}", self.model.coordinates());
            return Err(input_error(
                format!("{} coordinates are given", q.len()),
                reason,
                "pass the coordinates of its state",
            ));
        }
        run_guarded(|| Ok(numpy_array(py, self.model.displacement(&q.into()))))
    }

    /// Volume of a chamber, m³; of a half model, of the half.
    fn chamber_volume(&self, coordinates: Reals<'_>, chamber: usize) -> PyResult<f64> {
        let q = number_vector("coordinates", &coordinates)?;
        run_guarded(|| Ok(self.model.chamber_volume(chamber, &q.into())))
    }

    /// The state after a step of implicit Euler.
    fn step<'py>(
        &self,
        py: Python<'py>,
        before: Pair<'py>,
        given: (Settings, Vec<f64>, Vec<f64>),
    ) -> PyResult<Arrays<'py>> {
        let (before, given) = (reduced_state(&before)?, Given::of(given)?);
        // Steps take microseconds: a thread for each would cost as much.
        let step =
            || run_guarded(|| in_this_process(|| self.model.step(&before, &given.step()).map_err(solve_exception)));
        let state_after = py.detach(step)?;
        Ok(state_arrays(py, state_after))
    }

    /// The coordinates of an equilibrium.
    fn equilibrium<'py>(
        &self,
        py: Python<'py>,
        start: Reals<'py>,
        given: Constants,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let start = number_vector("coordinates", &start)?;
        let (_, found) = py.detach(|| run_guarded(|| in_this_process(|| self.equilibrium_near(start, &given))))?;
        Ok(numpy_array(py, found.coordinates.data.into()))
    }

    /// The gradient of a loss of the coordinates of an equilibrium: by pressures, and by E and ν of each region.
    fn equilibrium_gradient(
        &self,
        py: Python<'_>,
        coordinates: Reals<'_>,
        given: Constants,
        loss: Reals<'_>,
    ) -> PyResult<(Vec<f64>, Vec<f64>, Vec<f64>)> {
        let (coordinates, loss) = (number_vector("coordinates", &coordinates)?, number_vector("loss", &loss)?);
        let regions = self.regions.len();
        let gradient = || {
            let (solver, found) = self.equilibrium_near(coordinates, &given)?;
            let loss: DVector<f64> = loss.into();
            let gradient_by = |of: fn(usize) -> Parameter| {
                solver.adjoint(&found, &loss, &(0..regions).map(of).collect::<Vec<_>>()).map_err(solve_exception)
            };
            let moduli = gradient_by(Parameter::YoungsModulus)?;
            Ok((solver.pressure_gradient(&found, &loss), moduli, gradient_by(Parameter::PoissonsRatio)?))
        };
        py.detach(|| run_guarded(|| in_this_process(gradient)))
    }

    /// The gradient of a loss of the state after a step, from its derivatives: by coordinates, velocity, pressures and
    /// scale of the moduli.
    fn step_gradient<'py>(
        &self,
        py: Python<'py>,
        states: (Pair<'py>, Pair<'py>),
        given: (Settings, Vec<f64>, Vec<f64>),
        loss: Pair<'py>,
    ) -> PyResult<(Arrays<'py>, Vec<f64>, Vec<f64>)> {
        let (before, after) = states;
        let (before, after, loss, given) =
            (reduced_state(&before)?, reduced_state(&after)?, reduced_state(&loss)?, Given::of(given)?);
        let gradient = || self.model.step_gradient((&before, &after), &given.step(), &loss).map_err(solve_exception);
        let gradients = py.detach(|| run_guarded(|| in_this_process(gradient)))?;
        Ok((state_arrays(py, gradients.state), gradients.pressures, gradients.modulus_scale))
    }
}
