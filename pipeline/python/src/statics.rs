//! Equilibria, their gradients, sensitivities and modes.

use fem::{Equilibrium, Gradient, Parameter, RegionGradient, StaticSettings};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Reals, number_slice, number_vector, numpy_array, scale_of};
use crate::errors::{Kind, input_error, of_diagnostic, solve_exception, typed_exception};
use crate::solver::{OfCase, Solver};
use simulate::{Budget, Converged, Exceeded, Levels, LostLevel};

/// Settings of a static solve.
#[derive(FromPyObject)]
pub(crate) struct Settings {
    #[pyo3(item)]
    tolerance: f64,
    #[pyo3(item)]
    load_steps: usize,
    #[pyo3(item)]
    reuse_factor: bool,
    #[pyo3(item)]
    max_iterations: Option<usize>,
    #[pyo3(item)]
    max_cutbacks: Option<usize>,
    #[pyo3(item)]
    timeout: Option<f64>,
}

impl Settings {
    pub(crate) fn budget(&self) -> Budget {
        Budget { max_iterations: self.max_iterations, max_cutbacks: self.max_cutbacks, timeout: self.timeout }
    }

    fn static_settings(&self) -> StaticSettings {
        let Self { tolerance, load_steps, reuse_factor, .. } = *self;
        self.budget().limiting(StaticSettings { tolerance, load_steps, reuse_factor, ..StaticSettings::default() })
    }
}

/// An equilibrium as Python has it.
fn found_equilibrium<'py>(py: Python<'py>, found: Equilibrium) -> PyResult<Bound<'py, PyDict>> {
    let record = PyDict::new(py);
    record.set_item("displacement", numpy_array(py, found.displacement))?;
    record.set_item("pressures", numpy_array(py, found.pressures))?;
    record.set_item("iterations", found.iterations)?;
    record.set_item("factorisations", found.factorisations)?;
    record.set_item("residual", found.residual)?;
    record.set_item("snap_through", found.snap_through)?;
    Ok(record)
}

/// The exception of a level without an equilibrium: it holds the last one, which the package's Python files make an equilibrium of theirs.
pub(crate) fn lost_level(lost: LostLevel) -> PyErr {
    let (level, last) = (lost.level, lost.last.clone());
    let error = of_diagnostic(&lost.diagnostic(), Kind::Input);
    let attached = Python::attach(|py| -> PyResult<()> {
        let value = error.value(py);
        value.setattr("_asked", level)?;
        let Some(Converged { level, displacement, pressures }) = last else { return Ok(()) };
        value.setattr("level", level)?;
        let empty = Equilibrium { displacement, pressures, ..Equilibrium::default() };
        value.setattr("_last", found_equilibrium(py, empty)?)
    });
    attached.err().unwrap_or(error)
}

fn late_modes(count: usize, limit: Exceeded) -> PyErr {
    let message = format!("{count} modes are not found");
    typed_exception(Kind::Budget, [&message, &limit.to_string(), "ask for fewer modes, or raise the limit"])
}

/// A direction in the space of parameters.
#[derive(FromPyObject)]
pub(crate) struct Direction<'py> {
    #[pyo3(item)]
    youngs_modulus: Vec<f64>,
    #[pyo3(item)]
    poissons_ratio: Vec<f64>,
    #[pyo3(item)]
    density: Vec<f64>,
    #[pyo3(item)]
    factors: Reals<'py>,
    #[pyo3(item)]
    pressures: Vec<f64>,
    #[pyo3(item)]
    forces: Reals<'py>,
}

impl Direction<'_> {
    /// Its parameters with a part other than zero.
    fn parameters(&self) -> PyResult<Vec<(Parameter, f64)>> {
        let mut list = Vec::new();
        let mut add = |values: &[f64], parameter: &dyn Fn(usize) -> Parameter| {
            let parts = values.iter().enumerate().filter(|(_, part)| **part != 0.0);
            list.extend(parts.map(|(at, &part)| (parameter(at), part)));
        };
        add(&self.youngs_modulus, &Parameter::YoungsModulus);
        add(&self.poissons_ratio, &Parameter::PoissonsRatio);
        add(&self.density, &Parameter::Density);
        add(number_slice("factors", &self.factors)?, &Parameter::ElementFactor);
        add(&self.pressures, &Parameter::Pressure);
        add(number_slice("forces", &self.forces)?, &|at| Parameter::Force { node: at / 3, axis: at % 3 });
        Ok(list)
    }
}

/// An equilibrium as a solver takes it back.
pub(crate) fn equilibrium_at(displacement: &Reals<'_>, pressures: Vec<f64>) -> PyResult<Equilibrium> {
    Ok(Equilibrium { displacement: number_vector("displacement", displacement)?, pressures, ..Equilibrium::default() })
}

/// An array of so many times the numbers.
pub(crate) fn scaled_array(py: Python<'_>, mut numbers: Vec<f64>, scale: f64) -> Bound<'_, PyArray1<f64>> {
    numbers.iter_mut().for_each(|number| *number *= scale);
    numpy_array(py, numbers)
}

/// ∂L by E, ν and ρ of each region, so many times.
pub(crate) fn by_region(made: &Bound<'_, PyDict>, regions: &[RegionGradient], scale: f64) -> PyResult<()> {
    let list = |of: fn(&RegionGradient) -> f64| scaled_array(made.py(), regions.iter().map(of).collect(), scale);
    made.set_item("youngs_modulus", list(|of| of.youngs_modulus))?;
    made.set_item("poissons_ratio", list(|of| of.poissons_ratio))?;
    made.set_item("density", list(|of| of.density))
}

#[pymethods]
impl Solver {
    /// The equilibria of the levels `before` of the case, one after the other, and then that of `level` with these inputs under `pressures`;
    /// from a nearby shape where one is given. Of each `displacement` (3 entries per node), `pressures`, `iterations`, `factorisations`,
    /// `residual` and `snap_through`.
    fn equilibria<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        asked: (Vec<f64>, f64, Vec<f64>),
        start: (Option<Reals<'py>>, Settings),
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let ((before, level, pressures), (guess, settings)) = (asked, start);
        let inputs = self.inputs(inputs)?;
        let guess = guess.map(|guess| number_vector("initial_guess", &guess)).transpose()?;
        let shared = self.shared.clone();
        let equilibria = self.run_held(py, move |held, signals| {
            let watch = settings.budget().watch(Some(signals.interrupt()));
            held.solver.set_interrupt(Some(watch.interrupt()));
            let mut levels = Levels::new(settings.static_settings(), watch).near(guess);
            let mut equilibria = Vec::new();
            for (level, loads) in before.into_iter().zip(std::iter::repeat(shared.case.as_ref())) {
                let Some(OfCase { loads, .. }) = loads else { continue };
                held.apply(&inputs.with_forces(loads.forces_at_level(level)))?;
                held.move_clamps(shared.case.as_ref(), level)?;
                let pressures = loads.pressures_at_level(level);
                equilibria.push(levels.solve(&mut held.solver, level, &pressures).map_err(|lost| lost_level(*lost))?);
            }
            held.apply(&inputs)?;
            held.move_clamps(shared.case.as_ref(), level)?;
            equilibria.push(levels.solve(&mut held.solver, level, &pressures).map_err(|lost| lost_level(*lost))?);
            Ok(equilibria)
        })?;
        equilibria.into_iter().map(|equilibrium| found_equilibrium(py, equilibrium)).collect()
    }

    /// The equilibrium in which a motion of the case begins, as [`Solver::equilibria`] has them.
    fn start_equilibrium<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        settings: Settings,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (inputs, shared) = (self.inputs(inputs)?, self.shared.clone());
        let equilibrium = self.run(py, inputs, move |solver, signals| {
            let none =
                || input_error("the body has no case", "the start of a motion is that of a case", "give initial");
            let case = shared.case.as_ref().ok_or_else(none)?;
            let watch = settings.budget().watch(Some(signals.interrupt()));
            solver.set_interrupt(Some(watch.interrupt()));
            let equilibrium = simulate::start_equilibrium(solver, &case.loads, &settings.budget());
            equilibrium.map_err(|cause| lost_level(LostLevel::of(cause, 1.0, watch.exceeded(), None)))
        })?;
        found_equilibrium(py, equilibrium)
    }

    /// The gradient of a loss at an equilibrium (displacement, pressures) from its derivative by the displacement.
    fn equilibrium_gradient<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        at: (Reals<'py>, Vec<f64>),
        dloss_du: Reals<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (displacement, pressures) = at;
        let (inputs, at) = (self.inputs(inputs)?, equilibrium_at(&displacement, pressures)?);
        let mut slope = number_vector("dloss_du", &dloss_du)?;
        let scale = scale_of(&slope);
        slope.iter_mut().for_each(|entry| *entry /= scale);
        let gradient = self.run(py, inputs, move |solver, _| solver.gradient(&at, &slope).map_err(solve_exception))?;
        let Gradient { regions, elements, pressures, forces } = gradient;
        let record = PyDict::new(py);
        by_region(&record, &regions, scale)?;
        record.set_item("factors", scaled_array(py, elements, scale))?;
        record.set_item("pressures", scaled_array(py, pressures, scale))?;
        record.set_item("forces", scaled_array(py, forces, scale))?;
        Ok(record)
    }

    /// The derivative of an equilibrium along a direction of its parameters, 3 entries per node.
    fn equilibrium_sensitivity<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        at: (Reals<'py>, Vec<f64>),
        direction: Direction<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (displacement, pressures) = at;
        let (inputs, at) = (self.inputs(inputs)?, equilibrium_at(&displacement, pressures)?);
        let mut parts = direction.parameters()?;
        let scale = scale_of(parts.iter().map(|(_, part)| part));
        parts.iter_mut().for_each(|(_, part)| *part /= scale);
        let changed =
            self.run(py, inputs, move |solver, _| solver.sensitivity_along(&at, &parts).map_err(solve_exception))?;
        Ok(scaled_array(py, changed, scale))
    }

    /// The lowest natural frequencies (Hz) about an equilibrium, and their shapes one after the other: so many are `asked` for, within so many
    /// seconds where they are limited.
    fn modes<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyDict>,
        at: (Reals<'py>, Vec<f64>),
        asked: (usize, Option<f64>),
    ) -> PyResult<(Vec<f64>, Bound<'py, PyArray1<f64>>)> {
        let ((displacement, pressures), (count, timeout)) = (at, asked);
        let (inputs, at) = (self.inputs(inputs)?, equilibrium_at(&displacement, pressures)?);
        let modes = self.run(py, inputs, move |solver, signals| {
            let watch = Budget { timeout, ..Budget::default() }.watch(Some(signals.interrupt()));
            solver.set_interrupt(Some(watch.interrupt()));
            solver.modes(&at, count).map_err(|cause| match watch.exceeded() {
                Some(limit) => late_modes(count, limit),
                None => solve_exception(cause),
            })
        })?;
        let frequencies = modes.iter().map(|mode| mode.frequency).collect();
        Ok((frequencies, numpy_array(py, modes.into_iter().flat_map(|mode| mode.shape).collect())))
    }

    /// Volume of a chamber at a displacement, m³; of a half model, of the half; and the gauge pressure in it, Pa.
    fn chamber_state(
        &self,
        py: Python<'_>,
        inputs: &Bound<'_, PyDict>,
        at: (Reals<'_>, Vec<f64>),
        chamber: usize,
    ) -> PyResult<(f64, f64)> {
        let (displacement, pressures) = at;
        let (inputs, at) = (self.inputs(inputs)?, equilibrium_at(&displacement, pressures)?);
        let shared = self.shared.clone();
        self.run(py, inputs, move |solver, _| {
            let gauge = solver.chamber_pressure(chamber, &at.displacement, &at.pressures).map_err(solve_exception)?;
            Ok((shared.system.chamber_volume(chamber, &at.displacement), gauge))
        })
    }

    /// The elastic energy at a displacement, J.
    fn elastic_energy(&self, py: Python<'_>, inputs: &Bound<'_, PyDict>, displacement: Reals<'_>) -> PyResult<f64> {
        let (inputs, u) = (self.inputs(inputs)?, number_vector("displacement", &displacement)?);
        self.run(py, inputs, move |solver, _| solver.elastic_energy(&u).map_err(solve_exception))
    }

    /// Nodal forces (3 per node, N) of a traction over faces of 3, 4 or 6 nodes.
    fn traction_forces<'py>(
        &self,
        py: Python<'py>,
        faces: PyReadonlyArray1<'py, i64>,
        each: usize,
        traction: [f64; 3],
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let flat = faces
            .as_slice()
            .map_err(|_| input_error("faces is not contiguous", "its rows are apart", "pass a copy"))?;
        let nodes = crate::arrays::node_numbers(flat)?;
        let mesh = self.shared.system.mesh();
        if let Some(node) = nodes.iter().find(|&&node| node as usize >= mesh.nodes.len()) {
            let reason = format!("there are {} nodes, counted from 0", mesh.nodes.len());
            return Err(input_error(format!("a face names the node {node}"), reason, "check the faces"));
        }
        if each == 0 || nodes.len() % each != 0 {
            let reason = format!("there are {} node numbers", nodes.len());
            return Err(input_error(format!("faces have {each} nodes each"), reason, "check the faces"));
        }
        let mut sides = nodes.chunks_exact(each);
        let forces = sides.try_fold(fem::Forces::none(mesh), |sum, face| sum.on_face(face, traction));
        let forces = forces.map_err(|error| crate::case::case_exception(&error.into()))?;
        Ok(numpy_array(py, forces.as_slice().to_vec()))
    }
}
