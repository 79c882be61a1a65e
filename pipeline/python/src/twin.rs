//! Reduced tails of `study export twin`, stepped in real time.

use std::path::Path;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{Reals, number_slice, numpy_array};
use crate::errors::{Kind, of_diagnostic};
use diagnostics::Diagnostic;
use twin::{TwinData, TwinError};

/// A tail and its arrays.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Twin {
    data: TwinData,
    twin: Arc<twin::Twin>,
}

/// A moving tail.
#[pyclass(module = "softfish._core")]
pub(crate) struct TwinState {
    twin: Arc<twin::Twin>,
    state: twin::TwinState,
}

/// Names, ranges (Pa) of chambers, coordinates at rest (m) of outputs, provenance, and whether half a body is modelled.
type Description = (Vec<String>, Vec<String>, Vec<[f64; 2]>, Vec<String>, Vec<f64>, Vec<(String, String)>, bool);

fn twin_exception(error: TwinError) -> PyErr {
    let kind = if matches!(error, TwinError::NoConvergence { .. }) { Kind::Convergence } else { Kind::Input };
    of_diagnostic(&Diagnostic::from(error), kind)
}

impl Twin {
    fn new(data: TwinData) -> PyResult<Self> {
        let twin = Arc::new(twin::Twin::new(data.clone()).map_err(twin_exception)?);
        Ok(Self { data, twin })
    }
}

#[pymethods]
impl Twin {
    /// Of a file.
    #[staticmethod]
    fn read(path: &str) -> PyResult<Self> {
        Self::new(twin::file::read(Path::new(path)).map_err(twin_exception)?)
    }

    /// Of the bytes of a file.
    #[staticmethod]
    fn parse(bytes: &[u8]) -> PyResult<Self> {
        Self::new(twin::file::parse(bytes, Path::new("the bytes of a twin")).map_err(twin_exception)?)
    }

    /// A clamped beam of rubber, in water or in air.
    #[staticmethod]
    fn example(water: bool) -> PyResult<Self> {
        Self::new(twin::example::beam(water))
    }

    /// The bytes of its file.
    fn content<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &twin::file::bytes(&self.data).map_err(twin_exception)?))
    }

    /// The page that describes it.
    fn page(&self) -> PyResult<String> {
        self.data.page().map_err(twin_exception)
    }

    fn coordinates(&self) -> usize {
        self.twin.coordinates()
    }

    fn description(&self) -> Description {
        let TwinData { regions, chambers, outputs, provenance, half, .. } = &self.data;
        (
            regions.iter().map(|region| region.name.clone()).collect(),
            chambers.iter().map(|chamber| chamber.name.clone()).collect(),
            chambers.iter().map(|chamber| chamber.range).collect(),
            outputs.iter().map(|output| output.name.clone()).collect(),
            outputs.iter().map(|output| output.at_rest).collect(),
            provenance.clone(),
            *half,
        )
    }

    fn start(&self) -> TwinState {
        TwinState { twin: self.twin.clone(), state: self.twin.start() }
    }

    /// A state that [`TwinState::saved`] gave.
    fn restored(&self, bytes: &[u8]) -> PyResult<TwinState> {
        Ok(TwinState { twin: self.twin.clone(), state: self.twin.restored(bytes).map_err(twin_exception)? })
    }
}

#[pymethods]
impl TwinState {
    /// One step, without the interpreter's lock.
    fn step(&mut self, py: Python<'_>, pressures: Reals<'_>, duration: f64) -> PyResult<()> {
        let pressures = number_slice("pressures", &pressures)?;
        let Self { twin, state } = self;
        py.detach(|| twin.step(state, pressures, duration)).map_err(twin_exception)
    }

    fn time(&self) -> f64 {
        self.state.time()
    }

    fn coordinates<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numpy_array(py, self.state.coordinates().to_vec())
    }

    fn velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numpy_array(py, self.state.velocity().to_vec())
    }

    /// Displacement of every output, m.
    fn outputs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numpy_array(py, (0..self.twin.outputs().count()).map(|number| self.twin.output(&self.state, number)).collect())
    }

    /// Volume of every chamber, m³.
    fn volumes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let volume = |chamber| self.twin.chamber_volume(&self.state, chamber);
        numpy_array(py, (0..self.twin.chambers().len()).map(volume).collect())
    }

    fn excursion(&self) -> f64 {
        self.twin.excursion(&self.state)
    }

    fn saved<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.twin.saved(&self.state).map_err(twin_exception)?))
    }
}
